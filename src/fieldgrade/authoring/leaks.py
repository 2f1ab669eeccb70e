"""Find parts of solutions, hidden cases and their answers in files for students."""

from __future__ import annotations

import ast
import json
import keyword
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from functools import cache
from itertools import chain, zip_longest
from typing import NamedTuple

import numpy as np

from fieldcheck.calls import Call, Values
from fieldgrade.authoring.sources import Source

RUN = 6
"""Names, numbers and operators in a row that count as a leak, brackets not counted.

It is the smallest number for which no existing file matches; ``(…).sum(axis=0)`` has three.
"""
WORDS = 12
"""The same for words of a model answer or a rubric."""
SIGNIFICANT, MOST_SIGNIFICANT = 9, 12
"""Numbers are equal if they agree in all written digits, and at least this many are written."""
ENOUGH = 2
"""Distinct numbers of one array that count as a leak: one may agree by chance."""
SHORT_BITS = 24
"""Numbers with at most so many binary digits are not secret; a random one has 53."""
LARGEST_DENOMINATOR, LARGEST_NUMERATOR = 1000, 10**6
"""Ratios of integers up to these are not secret: they are answers to questions about integers."""
ROUNDING = 1e-13
"""Numbers smaller than this, and than this part of the largest of their call, are not secret: they
are rounding errors. Where lengths are 10¹², weights of size one remain secret."""
LONG_NUMBER = re.compile(r"-?\d*\.?\d+(?:e[-+]?\d+)?", re.IGNORECASE)
TOKEN = re.compile(
    r"(?P<word>(?:\.?[^\W\d]\w*)+|\.?\d[\w.]*(?:(?<=[eE])[-+]\d+)?|\*\*|//|[=!<>]=|[-+*/@%<>&|^~])"
    r"|[^\s\w\"'`\\]"
)
"""A token of code; names with dots, numbers and operators are significant.

Quotes are not tokens, so code in a string is code.
"""

TokenRun = tuple[str, ...]


class PublicText(NamedTuple):
    """A text in a file for students, and the number of its first line."""

    place: str
    first: int
    text: str

    def line(self, number: int) -> str:
        """Name a line of the text."""
        return f"{self.place}, line {self.first + number}"


def code_leaks(source: Source, files: Mapping[str, str]) -> Iterator[str]:
    """Yield each line of a file for students with a part of a solution, or of a model answer.

    Parameters
    ----------
    source : Source
    files : mapping
        The files for students: names and contents.
    """
    solutions = [body for cell in source.cells for body in cell.solutions]
    code = set(chain.from_iterable(map(token_runs, solutions))) - _signatures(source)
    secret = [cell.text for cell in source.cells if cell.answer or cell.rubric]
    words = set(chain.from_iterable(map(word_runs, secret)))
    for text in chain.from_iterable(_texts(*file) for file in files.items()):
        for line, run in _first_on_each_line(token_runs(text.text), code):
            yield f"{text.line(line)} holds a part of a solution of {source.name}: {run}"
        for line, run in _first_on_each_line(word_runs(text.text), words):
            yield f"{text.line(line)} holds a part of a model answer of {source.name}: {run}"


def _first_on_each_line(
    found: Mapping[TokenRun, int], secret: Set[TokenRun]
) -> Iterator[tuple[int, str]]:
    """Yield the lines on which a secret run begins, each with its first run."""
    runs = {line: " ".join(run) for run, line in reversed(list(found.items())) if run in secret}
    yield from sorted(runs.items())


def number_leaks(
    calls: Sequence[Call],
    answers: Sequence[Values],
    written: Mapping[str, Set[str]],
    public: Set[str] = frozenset(),
) -> Iterator[str]:
    """Yield each file for students with numbers of a hidden input, or of the answer to one.

    A file holds an array if it has `ENOUGH` of its distinct numbers, or all if there are fewer.

    Parameters
    ----------
    calls, answers : sequence
        Hidden inputs, and the right answers.
    written : mapping
        The long numbers in the files, by the names of the files.
    public : set of str
        Numbers that are no secret, since public calls have them, too: see `numbers_of`.
    """
    for array in _arrays(calls, answers):
        secret = {k: x for k, x in _secret_numbers(array).items() if k not in public}
        enough = min(ENOUGH, len(set(secret.values())))
        for name, numbers in written.items():
            found = {secret[digits] for digits in numbers & secret.keys()}
            if found and len(found) >= enough:
                yield f"{name} holds numbers of a hidden case: {sorted(found)[:ENOUGH]}"


def numbers_of(calls: Sequence[Call], answers: Sequence[Values]) -> set[str]:
    """Return the long numbers of calls and of the answers to them, by each way of writing them."""
    return {digits for array in _arrays(calls, answers) for digits in _secret_numbers(array)}


def _arrays(calls: Sequence[Call], answers: Sequence[Values]) -> Iterator[np.ndarray]:
    """Yield the inputs and the answers, with zeros for their rounding errors."""
    for call, values in zip_longest(calls, answers):
        given = call.arguments if call else ()
        arrays = [np.asarray(a, dtype=float) for a in (*given, *(values or ()))]
        finite = [np.where(np.isfinite(a), a, 0.0) for a in arrays]
        rounding = ROUNDING * min(1.0, max(np.abs(a).max(initial=0.0) for a in finite))
        yield from (np.where(np.abs(a) > rounding, a, 0.0) for a in finite)


def long_numbers(text: str) -> set[str]:
    """Return the long numbers in a text, with up to twelve digits.

    Examples
    --------
    >>> sorted(long_numbers("1.5, 0.12345678901 and -12.34567890123456"))
    ['-12.3456789012', '0.12345678901']
    """
    return {
        _digits(float(number), min(count, MOST_SIGNIFICANT))
        for number in LONG_NUMBER.findall(text)
        if (count := _significant(number)) >= SIGNIFICANT
    }


def _signatures(source: Source) -> set[TokenRun]:
    """Return the runs in the signatures of the requested functions, which are public."""
    cells = source.answer_cells().values()
    lines = (line for cell in cells for line in cell.text.splitlines() if line.startswith("def "))
    return {run for line in lines for run in token_runs(line)}


@cache
def token_runs(text: str) -> Mapping[TokenRun, int]:
    r"""Return all runs of `RUN` significant tokens, each with the line on which it first begins.

    Comments are treated as separate texts, so that they do not interrupt code.

    Examples
    --------
    >>> print(*next(iter(token_runs("x = np.linalg.solve(a + b,  # so\n  c)"))))
    x = np.linalg.solve ( a + b , c
    >>> token_runs("(x - y).sum(axis=0)")
    {('x', '-', 'y', ')', '.sum', '(', 'axis', '=', '0'): 0}
    >>> token_runs("(...).sum(axis=0)")
    {}
    """
    lines = [line.partition("#") for line in text.splitlines()]
    code = [token for k, (line, _, _) in enumerate(lines) for token in _tokens(line, k)]
    comments = (list(_tokens(comment, k)) for k, (_, _, comment) in enumerate(lines))
    return _first_lines(run for tokens in (code, *comments) for run in _runs(tokens))


def _first_lines(runs: Iterable[tuple[TokenRun, int]]) -> dict[TokenRun, int]:
    found: dict[TokenRun, int] = {}
    for run, line in runs:
        found.setdefault(run, line)
    return found


class _Token(NamedTuple):
    text: str
    line: int
    is_significant: bool


def _tokens(text: str, line: int) -> Iterator[_Token]:
    for match in TOKEN.finditer(text):
        yield _Token(match[0], line, bool(match["word"]) and not keyword.iskeyword(match[0]))


def _runs(tokens: Sequence[_Token]) -> Iterator[tuple[TokenRun, int]]:
    """Yield each run that begins and ends with a significant token, and its line."""
    at = [k for k, token in enumerate(tokens) if token.is_significant]
    for first, last in zip(at, at[RUN - 1 :], strict=False):
        yield tuple(token.text for token in tokens[first : last + 1]), tokens[first].line


@cache
def _texts(name: str, content: str) -> Sequence[PublicText]:
    """List the texts of a file: cells and outputs of a notebook, strings of code and of JSON."""
    return list(_read_texts(name, content))


def _read_texts(name: str, content: str) -> Iterator[PublicText]:
    if name.endswith(".ipynb"):
        for number, cell in enumerate(json.loads(content)["cells"], 1):
            yield PublicText(f"{name}, cell {number}", 1, "".join(cell["source"]))
            outputs = _strings(cell.get("outputs", []))
            yield from (PublicText(f"{name}, output of cell {number}", 1, text) for text in outputs)
    elif name.endswith(".json"):
        for key, value in json.loads(content).items():
            yield from (PublicText(f"{name}, {key}", 1, text) for text in _strings(value))
    else:
        yield PublicText(name, 1, content)
    if name.endswith(".py"):
        for node in ast.walk(ast.parse(content)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield PublicText(name, node.lineno, node.value)


def _strings(data: object) -> Iterator[str]:
    """Yield the texts in data; a list of strings is one text, as a notebook stores its lines."""
    if isinstance(data, str):
        yield data
    elif isinstance(data, dict):
        for value in data.values():
            yield from _strings(value)
    elif isinstance(data, list) and all(isinstance(value, str) for value in data):
        yield "".join(data)
    elif isinstance(data, list):
        for value in data:
            yield from _strings(value)


@cache
def word_runs(text: str) -> Mapping[TokenRun, int]:
    """Return all runs of `WORDS` words, each with the line on which it first begins."""
    words = [(word, k) for k, line in enumerate(text.splitlines()) for word in line.split()]
    runs = [words[i : i + WORDS] for i in range(len(words) - WORDS + 1)]
    return _first_lines((tuple(word for word, _ in run), run[0][1]) for run in runs)


def _secret_numbers(array: np.ndarray) -> dict[str, float]:
    """Return the numbers of an array that need all digits, by each way of writing them.

    A number is not secret if it is short in decimal digits, such as 0.5, or in binary digits, such
    as -1.1e-16 = -2⁻⁵³: the rounding error of a difference is a small multiple of a power of two;
    or if it is a ratio of small integers, such as 8/31.
    """
    numbers = {float(x) for x in np.ravel(array) if np.isfinite(x)}
    long = [x for x in numbers if float(f"{x:.6g}") != x and not _is_dyadic(x)]
    secret = [x for x in long if not _is_ratio(x)]
    return {_digits(x, k): x for x in secret for k in range(SIGNIFICANT, MOST_SIGNIFICANT + 1)}


def _is_dyadic(x: float) -> bool:
    """Whether a number is m 2ᵉ with an integer m of at most `SHORT_BITS` bits."""
    mantissa, _ = math.frexp(x)
    return math.ldexp(mantissa, SHORT_BITS).is_integer()


def _is_ratio(x: float) -> bool:
    """Whether a number agrees with a ratio of small integers in as many digits as are compared."""
    p = x * np.arange(1, LARGEST_DENOMINATOR + 1)
    near = np.abs(p - np.rint(p)) < 10.0**-MOST_SIGNIFICANT * np.abs(p)
    return bool((near & (np.abs(p) <= LARGEST_NUMERATOR)).any())


def _digits(x: float, count: int) -> str:
    return f"{x:.{count}g}"


def _significant(number: str) -> int:
    return len(number.lower().partition("e")[0].replace(".", "").lstrip("-0"))
