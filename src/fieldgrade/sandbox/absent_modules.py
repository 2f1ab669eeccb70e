"""Modules that the code of a submission tries to import and that are not there.

Code may pass over the error and go on without the module. The module is missing only if this
fails: if an error arises later in code that uses a name which the import should have defined.
"""

from __future__ import annotations

import ast
import dis
import sys
from collections.abc import Iterable, Iterator, Mapping
from types import FrameType, TracebackType
from typing import Any

from fieldgrade.sandbox.missing import MOST_MISSING
from fieldgrade.sandbox.statements import Statement

IMPORT_SYSTEM = ("<frozen importlib", "<frozen zipimport")
ANY_NAME = "*"
"""Stands for the unknown names of ``from … import *``."""


class AbsentModules:
    """The last finder of the import system, which is asked for modules that no other one finds.

    Parameters
    ----------
    namespace : mapping
        The names of the notebook.
    home : str
        The folder of the files that were submitted beside it.
    """

    def __init__(self, namespace: Mapping[str, Any], home: str) -> None:
        self.namespace, self.home = namespace, home
        self._tried: dict[str, None] = {}
        self._of_name: dict[str, tuple[str, ...]] = {}

    def find_spec(self, name: str, _path: object = None, _target: object = None) -> None:
        """Note a module for which the submission asks."""
        if len(self._tried) < MOST_MISSING and self._is_asked_by_submission():
            self._tried[name] = None

    def _is_asked_by_submission(self) -> bool:
        frame = sys._getframe(2)
        while frame.f_back and (
            frame.f_code.co_filename.startswith(IMPORT_SYSTEM)
            or frame.f_globals.get("__name__", "").partition(".")[0] == "importlib"
        ):
            frame = frame.f_back
        return self.is_own(frame)

    def is_own(self, frame: FrameType) -> bool:
        """Whether a frame runs code of the submission."""
        in_cell = frame.f_globals is self.namespace
        return in_cell or frame.f_code.co_filename.startswith(self.home)

    def begin(self) -> None:
        """Forget the modules for which the statement or call before has asked."""
        self._tried = {}

    def note(self, statement: Statement) -> None:
        """Note the names of a statement that has run, and the modules that it lacked."""
        absent = tuple(self._tried)
        if not absent and not self._of_name:
            return
        for name in {*statement.defines, *_all_of_a_module(statement)}:
            if absent:
                self._of_name[name] = absent
            else:
                self._of_name.pop(name, None)

    def behind(self, error: BaseException, names: Iterable[str] = ()) -> list[str]:
        """Return the modules without which an error arose, or `names` are not defined.

        They were asked for by the statement or call itself, or by one that defines a name which
        the code uses.
        """
        if not self._of_name:
            return sorted(self._tried)
        used = {*names, *self._used(error.__traceback__)}
        if isinstance(error, NameError):
            used.add(ANY_NAME)
        return sorted({*self._tried, *(m for name in used for m in self._of_name.get(name, ()))})

    def _used(self, trace: TracebackType | None) -> Iterator[str]:
        """Yield the global names in the submission's code through which an error has passed."""
        while trace is not None:
            if self.is_own(trace.tb_frame):
                yield from (
                    step.argval
                    for step in dis.get_instructions(trace.tb_frame.f_code)
                    if step.opname in ("LOAD_NAME", "LOAD_GLOBAL")
                )
            trace = trace.tb_next


def _all_of_a_module(statement: Statement) -> Iterator[str]:
    """Yield `ANY_NAME` if a statement contains ``from … import *``."""
    for node in ast.walk(statement.node) if statement.node else ():
        if isinstance(node, ast.ImportFrom) and node.names[0].name == ANY_NAME:
            yield ANY_NAME
