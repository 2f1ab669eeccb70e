"""Run the cells of a submission, statement by statement, in the namespace of a notebook.

A statement that fails does not affect the others of its cell that stand alone: definitions, and
statements that use nothing which the failed statement should have defined. The same holds in the
blocks of a statement such as ``if`` or ``with``.
"""

from __future__ import annotations

import asyncio
import importlib
import importlib.util
import inspect
import linecache
import os
import sys
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import CodeType, ModuleType, TracebackType
from typing import Any

from fieldcheck.calls import LONGEST_ERROR
from fieldgrade.sandbox import blocks, statements
from fieldgrade.sandbox.absent_modules import AbsentModules
from fieldgrade.sandbox.missing import FontWarnings, Missing, in_error
from fieldgrade.sandbox.statements import NO_DEFINITION, Statement
from fieldgrade.sandbox.written_files import WrittenFiles

MOST_CHAINED = 10
"""Errors that were handled when another one arose."""
NAME = "code cell {}"
"""The file name of a cell, numbered from 1, in tracebacks."""


class Notebook:
    """The code of a submission and the names that it has defined.

    Parameters
    ----------
    cells : sequence of str
        The code of the cells.
    files : mapping
        The content of the files that were submitted beside it; they can be imported or read.
    asked : sequence of str
        The names of the functions that are called.

    Attributes
    ----------
    absent : AbsentModules
        The modules that its code asks for and that are not there.
    """

    def __init__(
        self, cells: Sequence[str], files: Mapping[str, bytes], asked: Sequence[str]
    ) -> None:
        self.asked, self.answers = asked, dict[str, Any]()
        self.cells, self.home = cells, os.getcwd()  # noqa: PTH109
        self.unused_files = _write(files)
        module = ModuleType("__main__")
        self.namespace = vars(module)
        self.namespace |= {"__builtins__": __builtins__, "In": [""], "Out": {}}
        self._replaced = sys.modules["__main__"], module  # neither may be collected
        sys.modules["__main__"] = module
        sys.path.insert(0, self.home)
        self.flags = 0
        self.stubs: dict[str, Any] = {}
        self.needed: dict[int, set[int]] | None = None
        self._fonts = FontWarnings()
        self.absent = AbsentModules(self.namespace, self.home)
        sys.meta_path.append(self.absent)
        self._written = WrittenFiles(self.home)
        sys.addaudithook(self._written)
        self._loop: asyncio.AbstractEventLoop | None = None

    def run_cell(
        self, number: int, left_out: Collection[int], begin: Callable[[int, int], None]
    ) -> dict[str, Any]:
        """Run a cell, and report its first error, what is missing, and stubs passed over.

        Parameters
        ----------
        number : int
            The index of the cell.
        left_out : collection of int
            The indices of its statements that are not run, or `NO_DEFINITION`.
        begin : callable
            Called with the index and the line of each statement before it runs.
        """
        name, code = NAME.format(number + 1), self.cells[number]
        linecache.cache[name] = (len(code), None, code.splitlines(keepends=True), name)
        importlib.invalidate_caches()
        report = _Report(name, self.home, self.missing_in)
        try:
            found, self.flags = statements.read(code, name, self.flags)
        except BaseException as error:
            report.add(error, getattr(error, "lineno", None) or 0)
            return report.as_dict()
        run = _CellRun(found, left_out, report)
        for index, statement in enumerate(found):
            if not self._is_needed(number, index) or not run.is_due(index):
                continue
            if index in run.unless_known and not self._is_unknown(statement):
                continue
            if self._passed_over(statement, report):
                continue
            begin(index, statement.line)
            self.absent.begin()
            try:
                self._run(statement.code)
            except BaseException as error:
                run.fail(index, error)
            else:
                self._note(statement)
                run.succeed(index, self._is_unknown)
            self.absent.note(statement)
            self._remember_answers()
        report.missing |= self._fonts.take()
        return report.as_dict()

    def missing_in(self, error: BaseException, function: str = "") -> Missing:
        """Return what an error misses, or what a function does that is not defined.

        Parameters
        ----------
        error : BaseException
            The error. One that arose while another was handled misses the same as the other.
        function : str
            The name of the function that was called, if any.
        """
        found = Missing()
        with suppress(BaseException):  # the error may be an object of the submission's own
            for one in self._handled(error):
                lacking = in_error(in_words(one, self.home))
                found |= replace(lacking, files=()) if self._written.concerned(one) else lacking
            found |= Missing(modules=tuple(self.absent.behind(error, (function,))))
        return found

    def _handled(self, error: BaseException | None) -> Iterator[BaseException]:
        """Yield an error, and those that the submission's own code handled when it arose."""
        for _ in range(MOST_CHAINED):
            if error is None:
                return
            yield error
            error = error.__context__
            trace = error.__traceback__ if error else None
            if trace is None or not self.absent.is_own(trace.tb_frame):
                return

    def _note(self, statement: Statement) -> None:
        """Note the function that a stub has defined."""
        if statement.stub:
            self.stubs[statement.stub] = self.namespace.get(statement.stub)

    def _is_unknown(self, statement: Statement) -> bool:
        """Whether none of the names that a statement defines has a value of the notebook's own."""
        return all(
            name not in self.namespace
            or self.namespace[name] is self.stubs.get(name, self)
            or _is_of_library(self.namespace[name], self.home)
            for name in statement.defines
        )

    def _remember_answers(self) -> None:
        found = ((name, self.namespace.get(name)) for name in self.asked)
        self.answers.update((name, value) for name, value in found if callable(value))

    def restore_answers(self) -> None:
        """Define the functions again whose names were used for values: ``rank = rank(points)``."""
        for name, answer in self.answers.items():
            if not callable(self.namespace.get(name)):
                self.namespace[name] = answer

    def keep_needed(self, left_out: Collection[int]) -> None:
        """From now on run only the statements on which the definitions of the answers depend."""
        places: list[tuple[int, int]] = []
        every: list[Statement] = []
        flags = 0
        for number in (n for n in range(len(self.cells)) if n not in left_out):
            with suppress(SyntaxError, ValueError, RecursionError, MemoryError):
                found, flags = statements.read(self.cells[number], NAME.format(number + 1), flags)
                places += [(number, index) for index in range(len(found))]
                every += found
        self.needed = {}
        for index in statements.needed(self.asked, every):
            number, own = places[index]
            self.needed.setdefault(number, set()).add(own)

    def _is_needed(self, number: int, index: int) -> bool:
        return self.needed is None or index in self.needed.get(number, ())

    def _passed_over(self, statement: Statement, report: _Report) -> bool:
        """Whether a statement is a stub in place of an answer, such as `start_over` inserts."""
        name = statement.stub
        known = self.namespace.get(name)
        is_answer = callable(known) and known is not self.stubs.get(name)
        if not is_answer or _is_of_library(known, self.home):
            return False
        report.stubs.append(name)
        return True

    def _run(self, code: CodeType) -> None:
        """Run a statement; one that awaits runs in an event loop."""
        if not code.co_flags & inspect.CO_COROUTINE:
            exec(code, self.namespace)
            return
        if self._loop is None:
            self._loop = _EventLoop()
        self._loop.run_until_complete(eval(code, self.namespace))


class _CellRun:
    """Which statements of a cell run after others have failed."""

    def __init__(
        self, found: Sequence[Statement], left_out: Collection[int], report: _Report
    ) -> None:
        self.found, self.left_out, self.report = found, left_out, report
        self.lost: set[str] = set()
        self.stopped = False
        self.not_reached: set[int] = set()
        self.unless_known: set[int] = set()

    def is_due(self, index: int) -> bool:
        """Whether a statement runs; if it does not, the definitions in its blocks do."""
        statement = self.found[index]
        if statement.parent >= 0 and index not in self.not_reached:
            return False
        if index in self.left_out:
            pass
        elif statement.is_definition:
            return True
        elif self.stopped or (self.lost and self.lost & statement.uses):
            self.lost |= statement.defines
        elif NO_DEFINITION not in self.left_out:
            return True
        self.not_reached |= {*blocks.definitions(self.found, index)}
        return False

    def fail(self, index: int, error: BaseException) -> None:
        """Note an error, the names that are lost, and what was not reached."""
        statement = self.found[index]
        if index in self.unless_known:
            return
        self.report.add(error, statement.line)
        self.stopped |= _is_deliberate(statement, error)
        line = _line(error.__traceback__, self.report.name)
        self.not_reached |= {*blocks.not_reached(self.found, index, line)}
        before = (s for s in blocks.inside(self.found, index) if s.last < line and s.is_definition)
        self.lost |= statement.defines.difference(*(s.defines for s in before))

    def succeed(self, index: int, is_unknown: Callable[[Statement], bool]) -> None:
        """Note the names that are defined, and functions that a passed over error has skipped."""
        self.lost -= self.found[index].defines
        skipped = [*blocks.unconditional_definitions(self.found, index)]
        if any(self.found[k].is_function and is_unknown(self.found[k]) for k in skipped):
            self.not_reached |= {*skipped}
            self.unless_known |= {*skipped}


class _Report:
    """The first error of a cell, what is missing, and the stubs passed over."""

    def __init__(
        self, name: str, home: str, missing_in: Callable[[BaseException], Missing]
    ) -> None:
        self.name, self.home, self.missing_in = name, home, missing_in
        self.error, self.line = "", 0
        self.missing = Missing()
        self.stubs: list[str] = []

    def add(self, error: BaseException, line: int) -> None:
        words = in_words(error, self.home)
        self.missing |= self.missing_in(error)
        if not self.error:
            self.error = words
            self.line = _line(error.__traceback__, self.name) or line

    def as_dict(self) -> dict[str, Any]:
        return {
            "error": self.error,
            "line": self.line,
            "missing": vars(self.missing),
            "stubs": self.stubs,
        }


def in_words(error: BaseException, home: str) -> str:
    """Return the type and the message of an error, without the path of the home."""
    try:
        text = str(error.msg if isinstance(error, SyntaxError) else error)[:LONGEST_ERROR]
        return without_home(f"{type(error).__name__}: {text}", home)
    except BaseException:
        return "an error that cannot be shown"


def without_home(text: str, home: str) -> str:
    """Return a text without the path of the home, which is another one in each run."""
    return text.replace(f"{home}/", "").replace(home, "~")


def place(error: BaseException, home: str) -> str:
    """Return the innermost line of the submission that an error comes from; empty if unknown."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        path = frame.filename
        if path.startswith((NAME.format(""), home)):
            inside = "" if frame.name == "<module>" else f", in {frame.name}"
            text = f": {frame.line}" if frame.line else ""
            return f"line {frame.lineno} of {path.removeprefix(f'{home}/')}{inside}{text}"
    return ""


def _line(trace: TracebackType | None, name: str) -> int:
    """Return the line of a cell at which an error leaves it; 0 if there is none."""
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == name:
            return trace.tb_lineno
        trace = trace.tb_next
    return 0


def _is_of_library(thing: Any, home: str) -> bool:
    """Whether a function is one of a library, as after ``from numpy import *``."""
    module = sys.modules.get(getattr(thing, "__module__", None) or "")
    if module is None or module.__name__ == "__main__":
        return False
    is_helper = (getattr(module, "__file__", None) or "").startswith(home)
    return not is_helper and getattr(module, getattr(thing, "__name__", ""), None) is thing


def _is_deliberate(statement: Statement, error: BaseException) -> bool:
    """Whether a cell was stopped on purpose: by ``exit()``, ``raise`` or ``assert``."""
    return statement.stops or not isinstance(error, Exception)


def _write(files: Mapping[str, bytes]) -> list[str]:
    """Write files into the home; return modules that are not used: libraries keep their names.

    A module of Python that is not loaded yet gives way, as it does in a notebook's folder.
    """
    unused = []
    for name, content in files.items():
        module = name.partition("/")[0].removesuffix(".py")
        if name.endswith(".py") and (module in sys.modules or _is_installed(module)):
            unused.append(name)
            continue
        path = Path(name)
        with suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    return unused


def _is_installed(module: str) -> bool:
    """Whether a module is in an installed package, rather than one of Python's own."""
    try:
        found = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        found = None
    if found is None or module in sys.stdlib_module_names:
        return False
    location = (found.submodule_search_locations or [found.origin or ""])[0]
    return Path(location).parent != Path(os.__file__).parent


class _EventLoop(asyncio.SelectorEventLoop):
    """An event loop that other threads wake through a pipe: the sandbox has no sockets."""

    _add_reader: Callable[..., Any]
    _remove_reader: Callable[..., Any]

    def _make_self_pipe(self) -> None:
        self._woken, self._waker = os.pipe()
        for end in (self._woken, self._waker):
            os.set_blocking(end, False)
        self._add_reader(self._woken, os.read, self._woken, 4096)

    def _close_self_pipe(self) -> None:
        self._remove_reader(self._woken)
        os.close(self._woken)
        os.close(self._waker)

    def _write_to_self(self) -> None:
        with suppress(OSError):
            os.write(self._waker, b"\0")
