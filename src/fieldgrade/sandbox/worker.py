"""Run a student's code: cells, then calls, one frame for each."""

from __future__ import annotations

import builtins
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from threading import Lock
from typing import Any

from fieldcheck.calls import Call, perform
from fieldcheck.earlier_answers import in_place_of
from fieldgrade.sandbox import frames
from fieldgrade.sandbox.cells import Notebook, place, without_home
from fieldgrade.sandbox.given_functions import Exchange, given_function
from fieldgrade.sandbox.missing import Missing
from fieldgrade.sandbox.notebook_code import plain
from fieldgrade.sandbox.statements import MOST_REPORTED

MOST_TEXT = 2000
"""Characters of an error that are reported."""


def serve(incoming: int, outgoing: int) -> None:
    """Answer each frame with a frame of the same number, until the pipe is closed."""
    frames.send(outgoing, {"ready": True})
    with suppress(frames.PipeClosed):
        head, arrays = frames.receive(incoming)
        notebook = load(head["load"], arrays[0].tobytes())
        frames.send(outgoing, {"frame": head["frame"], "unused": notebook.unused_files})
        while True:
            _answer(notebook, incoming, outgoing, *frames.receive(incoming))


def _answer(
    notebook: Notebook, incoming: int, outgoing: int, head: dict[str, Any], arrays: list[Any]
) -> None:
    number = {"frame": head["frame"]}
    if head.get("needed"):
        notebook.keep_needed(head["left_out"])
        frames.send(outgoing, number)
    elif "cell" in head:
        begin = _progress(outgoing, number)
        report = notebook.run_cell(head["cell"], head["left_out"], begin)
        frames.send(outgoing, number | report | {"error": _short(report["error"])})
    else:
        exchange = _exchange(incoming, outgoing, number)
        given = {name: given_function(name, exchange) for name in head.get("given", ())}
        with in_place_of(notebook.namespace, head["function"], given):
            outcome, values = make_call(notebook, head, arrays)
        _send_result(outgoing, number, outcome, values)


def load(described: dict[str, Any], content: bytes) -> Notebook:
    """Return a notebook from the sizes of its cells and files, and their bytes."""
    parts, start = [], 0
    for size in [*described["cells"], *(size for _, size in described["files"])]:
        parts.append(content[start : start + size])
        start += size
    count = len(described["cells"])
    cells = [part.decode("utf-8", "surrogatepass") for part in parts[:count]]
    files = dict(zip([name for name, _ in described["files"]], parts[count:], strict=True))
    vars(builtins).update(of_notebooks())
    return Notebook(cells, files, described["asked"])


def _progress(outgoing: int, number: dict[str, int]) -> Callable[[int, int], None]:
    """Return a function that reports the statement of a cell which begins to run."""

    def begin(index: int, line: int) -> None:
        if index < MOST_REPORTED:
            frames.send(outgoing, number | {"statement": index, "line": line})

    return begin


def _exchange(incoming: int, outgoing: int, number: dict[str, int]) -> Exchange:
    """Return a function that asks the grader something while a call is made."""
    lock = Lock()

    def exchange(head: dict[str, Any], arrays: tuple[Any, ...]) -> tuple[dict[str, Any], list[Any]]:
        with lock:
            frames.send(outgoing, number | head, arrays)
            return frames.receive(incoming)

    return exchange


def make_call(
    notebook: Notebook, head: dict[str, Any], arrays: list[Any]
) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """Make the call that a frame describes, and return its outcome."""
    arguments = tuple(
        arrays[a["array"]] if "array" in a else a["number"] for a in head["arguments"]
    )
    call = Call(head["function"], arguments, head["case"])
    notebook.restore_answers()
    function = notebook.namespace.get(call.function)
    stopped = _Stopped(notebook, call.function)
    (outcome,) = perform({call.function: stopped.noting(function)}, (call,), head["seconds"])
    described = {
        "status": outcome.status,
        "returned": _short(outcome.returned),
        "error": _short(without_home(outcome.error, notebook.home)),
        "line": _short(stopped.place or outcome.line),
        "missing": vars(stopped.missing),
        "modified": list(outcome.modified),
        "numbers": outcome.values is not None,
    }
    return described, outcome.values or ()


class _Stopped:
    """Where a call stopped, and what is missing there."""

    def __init__(self, notebook: Notebook, function: str) -> None:
        self.notebook, self.function = notebook, function
        self.place, self.missing = "", Missing()
        notebook.absent.begin()

    def noting(self, function: Any) -> Any:
        """Return a function that notes an error; what cannot be called is noted here."""
        if not callable(function):
            self.missing = self.notebook.missing_in(NameError(), self.function)
            return function

        def called(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except (Exception, SystemExit) as error:
                self.place = place(error, self.notebook.home)
                self.missing = self.notebook.missing_in(error, self.function)
                raise

        return called


def _send_result(
    outgoing: int, number: dict[str, int], outcome: dict[str, Any], values: tuple[Any, ...]
) -> None:
    try:
        frames.send(outgoing, number | outcome, values)
    except frames.BadFrame:
        frames.send(outgoing, number | {"status": "too large"})


def _short(text: str) -> str:
    return text.encode("utf-8", "replace").decode("utf-8")[:MOST_TEXT]


def _nothing(*_: object, **__: object) -> None:
    return None


def _exit(*_: object) -> None:
    raise SystemExit


class _Shell:
    """A notebook's shell: it runs code, as exported notebooks ask; all else does nothing."""

    @property
    def user_ns(self) -> dict[str, Any]:
        return vars(sys.modules["__main__"])

    def run_cell(self, code: str, *_: object, **__: object) -> None:
        exec(plain(code), self.user_ns)

    def run_cell_magic(self, magic: str, line: str, cell: str) -> None:
        self.run_cell(f"%%{magic} {line}\n{cell}")

    def run_line_magic(self, magic: str, line: str = "", *_: object) -> None:
        self.run_cell(f"%{magic} {line}")

    def __getattr__(self, name: str) -> Any:
        return _Shell()

    def __call__(self, *_: object, **__: object) -> None:
        return None


def of_notebooks() -> dict[str, Any]:
    """Return the names that a notebook has without an import; most of them do nothing here."""
    return {
        "display": _nothing,
        "get_ipython": _Shell,
        "help": _nothing,
        "exit": _exit,
        "quit": _exit,
    }


def quiet_matplotlib() -> None:
    """Draw into memory, whatever window system a notebook asks for."""
    import matplotlib
    from matplotlib import pyplot

    pyplot.switch_backend("Agg")
    matplotlib.use = pyplot.switch_backend = _nothing


def quiet_fieldcheck() -> None:
    """Replace the functions of notebooks that show something: grading draws nothing."""
    import fieldcheck

    def undrawn(*_: object, **__: object) -> Any:
        return lambda picture: picture

    for name in ("check", "progress", "start_over"):
        setattr(fieldcheck, name, _nothing)
    fieldcheck.draw = fieldcheck.drag = undrawn


def silence() -> None:
    """Redirect the three standard streams to the null device."""
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    os.close(null)
