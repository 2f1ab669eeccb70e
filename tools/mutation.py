"""Mutation testing: mutants of single statements of the library, each run against its tests.

A mutant changes one operator, number, condition or loop of a statement, or deletes the statement.
Messages, types, decorators, docstrings and what no result depends on are left alone. A mutant is
caught if one of the tests that reach its statement fails; the mutants that survive are printed.

    python tools/mutation.py [--seed 1] [--count 200] [--jobs 2]

The copy of the checkout, the coverage of each test and the results so far are in build/mutation,
so that an interrupted run goes on where it stopped. Survivors that no test can catch, because the
mutant computes the same, are listed with the reason in tools/equivalent_mutants.toml.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import hashlib
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from itertools import accumulate, pairwise
from pathlib import Path
from queue import SimpleQueue
from time import monotonic

import parso
from cosmic_ray.ast import ast_nodes
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.operators.provider import OperatorProvider
from coverage import CoverageData

ROOT = Path(__file__).parents[1]
LIBRARY = Path("src", "fieldrecon")
WORK = ROOT / "build" / "mutation"
EQUIVALENT = ROOT / "tools" / "equivalent_mutants.toml"
REQUIRED = 0.92
"""Share of the mutants, without the equivalent ones, that the tests must catch."""
OF_THE_LIBRARY = ("tests/fieldrecon", "tests/test_laws.py", "tests/test_units.py")
LONGEST = 90.0
"""Seconds that the tests of one mutant may take together; the slowest are left out."""
PATIENCE = ("-o", "faulthandler_timeout=200", "-o", "faulthandler_exit_on_timeout=true")
"""A test that takes more seconds does not end; without a mutant none takes a fifth of them."""
LEFT_BEHIND = (".git", ".venv*", "build", "dist", "__pycache__", ".*_cache", ".hypothesis")
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "VECLIB_MAXIMUM_THREADS": "1"}


# --- What no test can catch


@cache
def listed() -> dict[str, list[dict]]:
    """Return the choices and the equivalent mutants of the list."""
    return tomllib.loads(EQUIVALENT.read_text())


def choices(path: str) -> set[str]:
    """Return the constants of a file that decide time, memory or looks alone."""
    constants = (c.split(":") for entry in listed()["choice"] for c in entry["constants"])
    return {name for file, name in constants if file == path}


def outdated() -> list[str]:
    """Return the entries of the list whose file or code is not there any more."""

    def code(path: str) -> str:
        file = ROOT / path
        return "\n".join(map(str.strip, file.read_text().splitlines())) if file.exists() else ""

    places = [c.split(":") for entry in listed()["choice"] for c in entry["constants"]]
    lines = [(entry["path"], entry["before"]) for entry in listed()["mutant"]]
    return [
        *(
            f"{path}: {name}"
            for path, name in places
            if not re.search(rf"^{name}\b", code(path), re.M)
        ),
        *(f"{path}: {before}" for path, before in lines if before not in code(path)),
    ]


# --- The mutants of a file


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
    """Return a mutant of each of `count` statements, drawn among all statements of the library."""
    by_statement: dict[tuple, list[Mutant]] = defaultdict(list)
    for file in sorted((ROOT / LIBRARY).rglob("*.py")):
        path = file.relative_to(ROOT).as_posix()
        for mutant in mutants_of(path, file.read_text()):
            by_statement[path, mutant.statement].append(mutant)
    choice = random.Random(seed)
    some = choice.sample(sorted(by_statement), min(count, len(by_statement)))
    tried = (choice.sample(by_statement[key], len(by_statement[key])) for key in some)
    return [mutant for one in tried if (mutant := next(filter(differs, one), None))]


def differs(mutant: Mutant) -> bool:
    """Whether it is another program, and one at all: 1e150 + 1 is 1e150."""
    source = (ROOT / mutant.path).read_text()
    try:
        return ast.dump(ast.parse(mutant.code(source))) != ast.dump(ast.parse(source))
    except SyntaxError:
        return False


# --- The tests that reach a statement


def run_tests(
    folder: Path, arguments: Iterable[str], timeout: float | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run pytest in a copy of the checkout, on the code of this copy."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", *arguments]
    paths = {"PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        command,
        cwd=folder,
        env=os.environ | ONE_THREAD | paths | variables,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


@dataclass(frozen=True)
class Reach:
    """For each line of each file the tests that run it, and the seconds of each test."""

    tests: dict[str, dict[int, list[str]]]
    seconds: dict[str, float]

    def of(self, mutant: Mutant) -> list[str]:
        """Return the tests of a statement, fast ones first; of one run by imports, the file's.

        Where all together take too long, the slowest are left out, and those of other folders
        before those of the statement's own.
        """
        by_line = self.tests.get(mutant.path, {})
        lines = range(mutant.statement[0], mutant.statement[1] + 1)
        found = {test for line in lines for test in by_line.get(line, ())}
        found = found or {test for tests in by_line.values() for test in tests}
        room = "tests/fieldrecon/" + Path(mutant.path).parts[2].removesuffix(".py").strip("_")

        def cost(test: str) -> tuple[float, str]:
            return self.seconds.get(test, 0.0), test

        ordered = sorted(found, key=lambda test: (not test.startswith(room), *cost(test)))
        total = accumulate(cost(test)[0] for test in ordered)
        kept = [test for test, until in zip(ordered, total, strict=True) if until <= LONGEST]
        return sorted(kept, key=cost)


def digest() -> str:
    """Return a digest of the library and the tests."""
    files = (f for top in (LIBRARY, "tests") for f in sorted((ROOT / top).rglob("*.py")))
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()[:16]


def record_reach(folder: Path, jobs: int) -> Reach:
    """Run the tests once with coverage, and note which of them reach which line.

    Of the slow tests these are those of the library. Those of the course and of the grader take
    longer and reach no more.
    """
    print("recording which tests reach which lines (once for this code; ten minutes)", flush=True)
    tests: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    seconds: dict[str, float] = defaultdict(float)
    failed: set[str] = set()
    for number, selection in enumerate((("-m", "not slow"), ("-m", "slow", *OF_THE_LIBRARY))):
        data_file = folder / f"coverage-{number}.db"
        result = run_tests(
            folder,
            (
                *(*selection, f"--numprocesses={jobs}", "-vv", "--durations=0"),
                *(f"--cov={LIBRARY}", "--cov-context=test", "--cov-report="),
            ),
            COVERAGE_FILE=str(data_file),
            COVERAGE_CORE="ctrace",
        )
        if not data_file.exists():
            sys.exit(f"the tests did not run:\n{result.stdout[-4000:]}{result.stderr[-4000:]}")
        failed |= set(re.findall(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", result.stdout, flags=re.M))
        for time, test in re.findall(
            r"^([\d.]+)s (?:call|setup) +(.*)$", result.stdout, flags=re.M
        ):
            seconds[test] += float(time)
        data = CoverageData(str(data_file))
        data.read()
        for file in data.measured_files():
            by_line = tests[Path(file).relative_to(folder).as_posix()]
            for line, contexts in data.contexts_by_lineno(file).items():
                by_line[line] |= {c.rpartition("|")[0] for c in contexts if c}
    if failed:
        print(f"left out, since they fail without a mutant: {', '.join(sorted(failed))}")
    kept = {
        file: {line: sorted(names - failed) for line, names in by_line.items()}
        for file, by_line in tests.items()
    }
    return Reach(kept, dict(seconds))


def reach(folder: Path, jobs: int) -> Reach:
    """Return what was recorded for this code, or record it."""
    kept = WORK / f"reach-{digest()}.json"
    if not kept.exists():
        kept.write_text(json.dumps(asdict(record_reach(folder, jobs))))
    read = json.loads(kept.read_text())
    tests = {f: {int(n): t for n, t in lines.items()} for f, lines in read["tests"].items()}
    return Reach(tests, read["seconds"])


# --- The trial of a mutant


def copy_of_checkout(name: str) -> Path:
    """Return a fresh copy of the checkout."""
    folder = WORK / name
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns(*LEFT_BEHIND), symlinks=True)
    return folder


def outcome(mutant: Mutant, folder: Path, known: Reach) -> str:
    """Return `caught`, `survived`, or `unreached`."""
    tests = known.of(mutant)
    if not tests:
        return "unreached"
    file, source = folder / mutant.path, (ROOT / mutant.path).read_text()
    listed = folder / "selected-tests"
    listed.write_text("\n".join(tests))
    seconds = sum(known.seconds.get(test, 0.0) for test in tests)
    file.write_text(mutant.code(source))
    try:
        status = run_tests(
            folder, ("-x", "-n0", "--no-cov", *PATIENCE, f"@{listed}"), timeout=120 + 10 * seconds
        ).returncode
    except subprocess.TimeoutExpired:
        return "caught"  # it does not end
    finally:
        file.write_text(source)
    return "survived" if status == 0 else "caught"


def equivalents() -> set[tuple[str, str, str]]:
    """Return path and lines, before and after, of the mutants that compute the same."""
    return {
        (entry["path"], entry["before"], after)
        for entry in listed()["mutant"]
        for after in entry["after"]
    }


def trials(mutants: list[Mutant], known: Reach, folders: list[Path], results: Path) -> dict:
    """Return the outcome of each mutant; those in the file of results are not tried again."""
    outcomes: dict[str, str] = {}
    if results.exists():
        outcomes = dict(json.loads(line) for line in results.read_text().splitlines())
    free: SimpleQueue[Path] = SimpleQueue()
    for folder in folders:
        free.put(folder)

    def tried(mutant: Mutant) -> None:
        folder, begin = free.get(), monotonic()
        try:
            found = outcome(mutant, folder, known)
        finally:
            free.put(folder)
        outcomes[repr(mutant)] = found
        with results.open("a") as file:
            file.write(json.dumps([repr(mutant), found]) + "\n")
        at = f"{mutant.path}:{mutant.statement[0]}"
        done = f"{len(outcomes)}/{len(mutants)}"
        print(
            f"{done:>8} {found:9} {monotonic() - begin:6.1f} s  {at}  {mutant.operator}", flush=True
        )

    with ThreadPoolExecutor(len(folders)) as pool:
        list(pool.map(tried, [m for m in mutants if repr(m) not in outcomes]))
    return outcomes


def report(mutants: list[Mutant], outcomes: dict[str, str]) -> bool:
    """Print the survivors and the share of mutants that were caught; return whether it suffices."""
    same, left, caught = equivalents(), 0, 0
    for mutant in mutants:
        lines = mutant.lines((ROOT / mutant.path).read_text())
        if outcomes[repr(mutant)] == "caught":
            caught += 1
        elif (mutant.path, *lines) not in same:
            left += 1
            print(f"\n{mutant.path}:{mutant.statement[0]} {outcomes[repr(mutant)]}")
            print("\n".join(f"- {line}" for line in lines[0].splitlines()))
            print("\n".join(f"+ {line}" for line in lines[1].splitlines()))
    for entry in outdated():
        print(f"\nnot in the code any more: {entry}")
    share = caught / (caught + left)
    print(
        f"\n{caught} of {len(mutants)} mutants caught, {left} not, "
        f"{len(mutants) - caught - left} equivalent: {share:.1%}; {REQUIRED:.0%} are required"
    )
    return share >= REQUIRED


def main() -> int:
    """Draw mutants, try them, and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="of the draw of mutants (1)")
    parser.add_argument("--count", type=int, default=200, help="number of mutants (200)")
    parser.add_argument("--jobs", type=int, default=2, help="mutants tried at the same time (2)")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    mutants = drawn(options.seed, options.count)
    folders = [copy_of_checkout(f"copy-{k}") for k in range(options.jobs)]
    known = reach(folders[0], options.jobs)
    results = WORK / f"results-{digest()}.jsonl"
    outcomes = trials(mutants, known, folders, results)
    return 0 if report(mutants, outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
