"""Similar answers, with the similar lines side by side: evidence, not a verdict.

Answers are compared by their syntax trees, without comments, docstrings, layout and the names that
a student chooses. Runs of k nodes are hashed, and the smallest of each w consecutive hashes is kept
(winnowing), so that every shared run of w + k - 1 nodes is found. Code that was handed out, and
code that many answers share, is excluded.

References
----------
S. Schleimer, D. S. Wilkerson, A. Aiken, "Winnowing: Local Algorithms for Document Fingerprinting",
SIGMOD 2003.
"""

from __future__ import annotations

import ast
import hashlib
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import combinations, islice

from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.html_pages import page, table
from fieldgrade.submissions.definitions import MOST_PARSED, is_stub, suppress_warnings

K, WINDOW = 12, 8
"""Nodes of a hashed run, and hashes of which one is kept: 19 shared nodes are always found, fewer
than 12 never."""
MOST_SHARED = 0.1
"""Code that more than this share of a class has in common is excluded."""
FEWEST = 3
"""... but code of at most this many students is never excluded."""

LINE_END = re.compile(r"\r\n?|\n")
"""Python's own; str.splitlines splits at other characters, too."""
MOST_NODES, MOST_COMPARED = 50_000, 200
"""Nodes and functions of a student that are compared at most; a notebook has about twenty
functions."""

MOST_PAIRS = 30
"""Pairs that are shown in full; the table has all pairs."""
MOST_FUNCTIONS = 4
CAUTION = (
    "This is evidence to look at, not a verdict. Students who worked together with permission, or "
    "who read the same page of a book, write similar code, and a short question has few answers. "
    "Marked lines are shared by these two students and by few others. Code that was handed out, "
    "names, comments and layout do not count."
)

Node = tuple[str, int]
"""The kind of a node of a syntax tree, and its line."""


@dataclass(frozen=True)
class Code:
    """A student's functions, and the fingerprints of each.

    Parameters
    ----------
    student : str
        The student.
    texts : mapping
        The text of each function, by its name.
    nodes : mapping
        The nodes of each, in normal form, with their lines in the text.
    prints : mapping
        The fingerprints of each, with the index of the run of nodes.
    left_out : int
        How many functions or cells are not compared, since there are too many or they are too long.
    """

    student: str
    texts: Mapping[str, str]
    nodes: Mapping[str, Sequence[Node]]
    prints: Mapping[str, Mapping[int, int]]
    left_out: int = 0

    def all_prints(self) -> set[int]:
        """Return the fingerprints of all functions together."""
        return set().union(*self.prints.values())


@dataclass(frozen=True)
class Pair:
    """Two students, and the code that they share and few others have.

    Parameters
    ----------
    one, other : Code
        Their answers.
    shared : frozenset of int
        The fingerprints that both have.
    part : float
        The shared part of the fingerprints of the shorter answer.
    """

    one: Code
    other: Code
    shared: frozenset[int]
    part: float

    def functions(self) -> list[tuple[str, str, int]]:
        """Return which functions share how many fingerprints, the most first."""
        found = [
            (mine, theirs, len(self.shared & set(a) & set(b)))
            for mine, a in self.one.prints.items()
            for theirs, b in self.other.prints.items()
        ]
        return sorted((f for f in found if f[2]), key=lambda f: (-f[2], f[0], f[1]))

    def lines(self, mine: str, theirs: str) -> tuple[set[int], set[int]]:
        """Return the lines of two functions that are alike, around the fingerprints they share."""
        one, other = self.one.nodes[mine], self.other.nodes[theirs]
        here, there = self.one.prints[mine], self.other.prints[theirs]
        alike: tuple[set[int], set[int]] = (set(), set())
        for value in self.shared & set(here) & set(there):
            for i, j in _alike(one, other, here[value], there[value]):
                alike[0].add(one[i][1])
                alike[1].add(other[j][1])
        return alike


def _alike(one: Sequence[Node], other: Sequence[Node], i: int, j: int) -> Iterator[tuple[int, int]]:
    """Yield the indices of equal nodes before and after two indices of equal nodes."""
    for step, a, b in ((1, i, j), (-1, i - 1, j - 1)):
        while 0 <= a < len(one) and 0 <= b < len(other) and one[a][0] == other[b][0]:
            yield a, b
            a, b = a + step, b + step


def code(student: str, cells: Iterable[str]) -> Code:
    """Return the functions in the cells of a student, except stubs."""
    cells = list(cells)
    short = [cell for cell in cells if len(cell) <= MOST_PARSED]
    found = [(cell, function) for cell in short for function in _functions(cell)]
    own = {function.name for _, function in found}
    texts: dict[str, str] = {}
    nodes: dict[str, list[Node]] = {}
    left, left_out = MOST_NODES, len(cells) - len(short)
    for cell, function in found:
        first = min([function.lineno, *(n.lineno for n in function.decorator_list)])
        its = [(kind, n - first) for kind, n in islice(normalized(function, own), left + 1)]
        if len(its) > left or len(nodes) == MOST_COMPARED:
            left_out += 1
            continue
        left -= len(its)
        texts[function.name] = "\n".join(LINE_END.split(cell)[first - 1 : function.end_lineno])
        nodes[function.name] = its
    prints = {name: dict(winnowed(nodes[name])) for name in nodes}
    return Code(student, texts, nodes, prints, left_out)


def _functions(cell: str) -> list[ast.FunctionDef]:
    try:
        with suppress_warnings():
            tree = ast.parse(cell)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    return [n for n in tree.body if isinstance(n, ast.FunctionDef) and not is_stub(n)]


def normalized(function: ast.FunctionDef, own: Collection[str] = ()) -> Iterator[Node]:
    """Yield the nodes of a function in normal form, in order.

    All names that the function binds are equal, as are all strings; docstrings, annotations and
    contexts are left out. Numbers, operators, attributes and names of libraries remain.

    Parameters
    ----------
    function : ast.FunctionDef
        The function.
    own : collection of str
        Names of the student's other functions, which are also chosen freely.
    """
    bound = {*own, *(name for node in ast.walk(function) for name in _bound(node))}
    for statement in function.body:
        if not _is_text(statement):
            yield from _nodes(statement, bound, function.lineno)


def _bound(node: ast.AST) -> Iterator[str]:
    match node:
        case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()) | ast.FunctionDef(name=name):
            yield name


def _nodes(node: ast.AST, bound: set[str], line: int) -> Iterator[Node]:
    """Yield a node and its descendants; with a stack, since trees may be deep."""
    stack = [(node, line)]
    while stack:
        node, line = stack.pop()
        line = getattr(node, "lineno", line)
        if isinstance(node, ast.AnnAssign):
            node = ast.Assign([node.target], node.value or ast.Constant(None), lineno=line)
        yield _kind(node, bound), line
        inner = [
            child
            for name, child in _children(node)
            if name not in ("annotation", "returns", "ctx", "type_comment") and not _is_text(child)
        ]
        stack += [(child, line) for child in reversed(inner)]


def _children(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield name, child


def _kind(node: ast.AST, bound: set[str]) -> str:
    kind = type(node).__name__
    match node:
        case ast.Name(id=name):
            return f"{kind} {'' if name in bound else name}"
        case ast.Attribute(attr=name):
            return f"{kind} {name}"
        case ast.Constant(value=int(value)) if type(value) is int:
            return f"{kind} {value:x}"  # Python refuses to write thousands of decimal digits
        case ast.Constant(value=value):
            return f"{kind} {'' if isinstance(value, str | bytes) else repr(value)}"
        case ast.keyword(arg=name):
            return f"{kind} {name}"
        case _:
            return kind


def _is_text(node: ast.AST) -> bool:
    """Whether a statement is a docstring or another string."""
    is_constant = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return is_constant and isinstance(node.value.value, str)  # type: ignore[attr-defined]


def winnowed(nodes: Sequence[Node], k: int = K, window: int = WINDOW) -> list[tuple[int, int]]:
    """Return fingerprints of a sequence of nodes, each with the index at which its run begins.

    Of each `window` consecutive hashes of `k` nodes the smallest is kept, of equal ones the last.
    """
    hashes = [_hash(nodes[at : at + k]) for at in range(len(nodes) - k + 1)]
    kept: dict[int, int] = {}
    for start in range(max(len(hashes) - window + 1, min(len(hashes), 1))):
        near = range(start, min(start + window, len(hashes)))
        at = min(near, key=lambda i: (hashes[i], -i))
        kept[at] = hashes[at]
    return [(value, at) for at, value in kept.items()]


def _hash(run: Sequence[Node]) -> int:
    text = "\0".join(kind for kind, _ in run)
    content = text.encode("utf-8", "surrogatepass")
    return int.from_bytes(hashlib.blake2b(content, digest_size=8).digest(), "big")


def pairs(codes: Sequence[Code], handed_out: Code | None = None) -> list[Pair]:
    """Return the pairs that share code that few others have, the most similar pair first.

    Parameters
    ----------
    codes : sequence of Code
        One for each student.
    handed_out : Code, optional
        The code that was handed out.
    """
    counts = Counter(value for c in codes for value in c.all_prints())
    given = handed_out.all_prints() if handed_out else set()
    most = max(FEWEST, MOST_SHARED * len(codes))
    telling = {value for value, count in counts.items() if 1 < count <= most} - given
    own = {c.student: c.all_prints() - given for c in codes}
    found = []
    for one, other in combinations(codes, 2):
        shared = own[one.student] & own[other.student] & telling
        if shared:
            shorter = min(len(own[one.student]), len(own[other.student]))
            found.append(Pair(one, other, frozenset(shared), len(shared) / shorter))
    return sorted(found, key=lambda p: (-p.part, -len(p.shared), p.one.student, p.other.student))


def to_table(pairs: Sequence[tuple[str, Pair]]) -> str:
    """Return the pairs of each notebook as CSV."""
    columns = ("notebook", "one", "other", "shared part", "shared fingerprints", "functions")
    return to_csv(
        columns,
        (
            (number, p.one.student, p.other.student, p.part, len(p.shared), _shared_functions(p))
            for number, p in pairs
        ),
    )


def similarity_page(title: str, pairs: Sequence[Pair], compared: int) -> str:
    """Return the page for a notebook.

    Parameters
    ----------
    title : str
        The title of the notebook.
    pairs : sequence of Pair
        The pairs, most similar first.
    compared : int
        The number of notebooks.
    """
    rows = [
        (f'<a href="#p{n}">{_names(p)}</a>', f"{p.part:.0%}", escape(_shared_functions(p)))
        for n, p in enumerate(pairs[:MOST_PAIRS])
    ]
    overview = table(("Pair", "Shared", "In"), rows, numbers=(1,)) if pairs else ""
    body = [f"<p>{escape(CAUTION)}</p>", overview]
    body += [line for n, p in enumerate(pairs[:MOST_PAIRS]) for line in _pair(n, p)]
    if not pairs:
        body.append("<p>No two of them share code that few others have.</p>")
    subtitle = f"{compared} notebooks compared, {len(pairs)} pairs share code"
    return page(f"Similar answers: {title}", subtitle, "\n".join(body))


def _pair(number: int, pair: Pair) -> Iterator[str]:
    yield f'<h2 id="p{number}">{_names(pair)}, {pair.part:.0%}</h2>'
    for mine, theirs, _ in pair.functions()[:MOST_FUNCTIONS]:
        here, there = pair.lines(mine, theirs)
        sides = _side(pair.one, mine, here) + _side(pair.other, theirs, there)
        yield f'<div class="pair">{sides}</div>'


def _side(code: Code, name: str, marked: set[int]) -> str:
    text = "\n".join(
        f"<mark>{escape(line)}</mark>" if n in marked and line.strip() else escape(line)
        for n, line in enumerate(code.texts[name].split("\n"))
    )
    return f'<div><p class="quiet">{escape(code.student)}</p><pre>{text}</pre></div>'


def _names(pair: Pair) -> str:
    return f"{escape(pair.one.student)} and {escape(pair.other.student)}"


def _shared_functions(pair: Pair) -> str:
    found = pair.functions()
    return ", ".join(one if one == other else f"{one} and {other}" for one, other, _ in found)
