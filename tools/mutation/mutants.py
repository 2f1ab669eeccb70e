"""The mutants of the library, and the draw among them.

A mutant changes one operator, number, condition or loop of a statement, or deletes the statement.
Messages, types, decorators, docstrings and what no result depends on are left alone.
"""

from __future__ import annotations

import ast
import difflib
import random
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice, pairwise

import parso
from cosmic_ray.ast import ast_nodes
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.operators.provider import OperatorProvider
from tools.mutation.judged import ROOT, choices, equivalents

LIBRARY = ROOT / "src" / "fieldrecon"


class StatementDeletion(Operator):
    """Replace a call, an augmented assignment or an assignment to an array's entry by `pass`."""

    def mutation_positions(self, node):
        """Return the extent of such a statement."""
        if node.type == "expr_stmt":
            target, assigned = node.children[0], node.children[1]
            entry = target.type == "atom_expr" and target.children[-1].children[0] == "["
            deletable = entry or getattr(assigned, "value", "=") != "="
        else:
            in_statement = node.parent is not None and node.parent.type == "simple_stmt"
            deletable = in_statement and node.type == "atom_expr"
        return [(node.start_pos, node.end_pos)] if deletable else []

    def mutate(self, node, index):  # noqa: ARG002 - one mutant of each statement
        """Return the statement `pass`."""
        return parso.python.tree.Name("pass", node.start_pos, node.get_first_leaf().prefix)

    @classmethod
    def examples(cls):
        """Return none: the tool has no use for them."""
        return ()


OPERATORS: dict[str, Operator] = {
    name: OperatorProvider()[name]()
    for name in (
        *(
            f"ReplaceBinaryOperator_{pair}"
            for pair in (
                *("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Pow_Mul", "FloorDiv_Mul"),
                *("Mod_FloorDiv", "BitAnd_BitOr", "BitOr_BitAnd", "BitXor_BitAnd"),
            )
        ),
        *(
            f"ReplaceComparisonOperator_{pair}"
            for pair in (
                *("Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is"),
                *("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_GtE", "LtE_Gt", "Gt_LtE", "GtE_Lt"),
            )
        ),
        *(f"ReplaceUnaryOperator_Delete_{name}" for name in ("USub", "Invert", "Not")),
        *("AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse"),
        *("ReplaceFalseWithTrue", "ReplaceBreakWithContinue", "ReplaceContinueWithBreak"),
        *("ExceptionReplacer", "NumberReplacer", "ZeroIterationForLoop"),
    )
} | {"StatementDeletion": StatementDeletion()}

Position = tuple[int, int]  # line, from 1, and column


@dataclass(frozen=True)
class Mutant:
    """One change of one statement."""

    path: str
    statement: tuple[int, int]  # first and last line, without a body
    operator: str
    occurrence: int  # in the file

    def code(self, source: str) -> str:
        """Return the changed source."""
        changed = mutate_code(source, OPERATORS[self.operator], self.occurrence)
        assert changed is not None, self
        return changed

    def lines(self, source: str) -> tuple[str, str]:
        """Return the lines that differ, before and after."""
        diff = difflib.ndiff(source.splitlines(), self.code(source).splitlines())
        changed: dict[str, list[str]] = {"-": [], "+": []}
        for line in diff:
            if line[0] in changed:
                changed[line[0]].append(line[2:].strip())
        return "\n".join(changed["-"]), "\n".join(changed["+"])


def statements(tree: ast.Module) -> dict[int, tuple[int, int]]:
    """Return for each line the lines of the smallest statement there, of a block its head."""
    extents = {}
    for node in ast.walk(tree):  # outer statements come before those inside them
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            last = body[0].lineno - 1 if body else node.end_lineno
            extent = (node.lineno, max(node.lineno, last))
            extents |= dict.fromkeys(range(extent[0], extent[1] + 1), extent)
    return extents


Extent = tuple[Position, Position]


def extents_of(nodes: Iterable[ast.AST | None]) -> list[Extent]:
    """Return where the nodes begin and end."""
    return [
        ((n.lineno, n.col_offset), (n.end_lineno, n.end_col_offset)) for n in nodes if n is not None
    ]


def signatures(tree: ast.Module) -> tuple[list[Extent], list[Extent]]:
    """Return the extents of the heads of functions, and of the default values in them."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    heads = [((f.lineno, 0), (f.body[0].lineno, f.body[0].col_offset)) for f in functions]
    defaults = (d for f in functions for d in (*f.args.defaults, *f.args.kw_defaults))
    return heads, extents_of(defaults)


SPARED_ARGUMENTS = {
    *("strict", "copy", "overwrite_a", "overwrite_b", "overwrite_c", "check_finite", "clean"),
    *("balanced_tree", "workers", "pure", "maxsize", "linewidth", "linewidths", "dpi", "figsize"),
    *("markersize", "markeredgewidth", "pad", "borderpad", "nbins", "allow_nan", "indent"),
}
"""Guards and permissions to change or share an argument, threads and caches, sizes of marks."""
SPARED_CALLS = {
    *("rows_of", "rows", "_chunk_rows", "blas_threads_for", "split_progress", "default_rng"),
    "_parts",
}
"""Calls whose arguments decide how much is done at once, what a bar shows, or which sample."""
SPARED_FUNCTIONS = {"_chunk_rows", "_weight_chunk_rows"}
"""Functions that say how many rows are computed at once."""


def names(target: ast.expr) -> set[str]:
    """Return the names that are assigned."""
    return {node.id for node in ast.walk(target) if isinstance(node, ast.Name)}


def spared(tree: ast.Module, chosen: set[str]) -> list[Extent]:
    """Return the extents of messages, types, decorators, imports and lists of public names.

    And of what no result depends on: the arguments and functions named above, the `chosen`
    constants, the unknown length in ``reshape``, for which NumPy takes any negative number, and the
    divisor that ``where`` puts in place of those that are not used.
    """
    nodes: list[ast.AST | None] = []
    for node in ast.walk(tree):
        match node:
            case ast.Assign(targets=[ast.Name() | ast.Tuple() as target]) if names(target) & chosen:
                nodes.append(node)
            case ast.AnnAssign(target=ast.Name(id=name)) if name in chosen:
                nodes.append(node)
            case ast.Expr(value=ast.Call(func=ast.Name(id="stage" | "stages"))):
                nodes.append(node)
            case ast.FunctionDef(name=name) if name in SPARED_FUNCTIONS:
                nodes.append(node)
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)) if (
                name in SPARED_CALLS
            ):
                nodes += node.args
            case ast.keyword(arg=name) if name in SPARED_ARGUMENTS:
                nodes.append(node.value)
            case ast.BinOp(op=ast.Div(), right=ast.Call(func=ast.Attribute(attr="where")) as where):
                nodes += where.args[2:]
            case ast.Raise() | ast.JoinedStr() | ast.Import() | ast.ImportFrom():
                nodes.append(node)
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                nodes.append(node)
            case ast.Call(func=ast.Attribute(attr="warn")):
                nodes.append(node)
            case ast.Call(func=ast.Attribute(attr="reshape")):
                nodes += [length for length in node.args if isinstance(length, ast.UnaryOp)]
            case ast.AnnAssign(annotation=ast.Name(id="TypeAlias")):
                nodes.append(node)
            case ast.AnnAssign():
                nodes.append(node.annotation)
            case ast.FunctionDef() | ast.ClassDef():
                nodes += node.decorator_list
            case ast.Assign(targets=[ast.Name(id="__all__")]):
                nodes.append(node)
    return extents_of(nodes)


STRICTNESS = {
    f"ReplaceComparisonOperator_{pair}" for pair in ("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt")
}


def thresholds(tree: ast.Module) -> list[Extent]:
    """Return where operators stand between a value and a constant, which it equals by coincidence.

    Constants have names in capitals.
    """
    found: list[Extent] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            found += [
                ((one.end_lineno, one.end_col_offset), (other.lineno, other.col_offset))
                for one, other in pairwise(sides)
                if any(name.isupper() for side in (one, other) for name in names(side))
            ]
    return found


def mutants_of(path: str, source: str) -> Iterator[Mutant]:
    """Yield the mutants of a file."""
    tree = ast.parse(source)
    extents, left_out = statements(tree), spared(tree, choices(path))
    heads, defaults = signatures(tree)
    coincidences = thresholds(tree)
    nodes = list(ast_nodes(parso.parse(source)))

    def inside(position: Position, places: list[Extent]) -> bool:
        return any(begin <= position < end for begin, end in places)

    def mutable(position: Position) -> bool:
        in_head = inside(position, heads) and not inside(position, defaults)
        return position[0] in extents and not in_head and not inside(position, left_out)

    for name, operator in OPERATORS.items():
        positions = (p for node in nodes for p in operator.mutation_positions(node))
        for occurrence, (start, _) in enumerate(positions):
            if mutable(start) and not (name in STRICTNESS and inside(start, coincidences)):
                yield Mutant(path, extents[start[0]], name, occurrence)


def drawn(seed: int, count: int) -> list[Mutant]:
    """Return a mutant of each of `count` statements, drawn among all statements of the library.

    A mutant that is known to compute the same is not drawn.
    """
    by_statement: dict[tuple, list[Mutant]] = defaultdict(list)
    for file in sorted(LIBRARY.rglob("*.py")):
        path = file.relative_to(ROOT).as_posix()
        for mutant in mutants_of(path, file.read_text()):
            by_statement[path, mutant.statement].append(mutant)
    choice = random.Random(seed)
    shuffled = choice.sample(sorted(by_statement), len(by_statement))
    ordered = (choice.sample(by_statement[key], len(by_statement[key])) for key in shuffled)
    first = (next(filter(may_matter, some), None) for some in ordered)
    return list(islice(filter(None, first), count))


def may_matter(mutant: Mutant) -> bool:
    """Whether it is another program, one at all (1e150 + 1 is 1e150), and not known as the same."""
    source = (ROOT / mutant.path).read_text()
    try:
        differs = ast.dump(ast.parse(mutant.code(source))) != ast.dump(ast.parse(source))
    except SyntaxError:
        return False
    return differs and (mutant.path, *mutant.lines(source)) not in equivalents()
