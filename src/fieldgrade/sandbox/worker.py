"""Run a student's code: cells, then calls, one frame for each."""

from __future__ import annotations

import linecache
import os
from typing import Any

from fieldcheck.calls import Call, perform
from fieldgrade.sandbox import frames

MOST_TEXT = 2000
"""Characters of an error that are reported."""


def serve(incoming: int, outgoing: int) -> None:
    """Answer each frame with a frame of the same number, until the pipe is closed."""
    namespace = {"__name__": "__main__", "__builtins__": __builtins__} | of_notebooks()
    frames.send(outgoing, {"ready": True})
    while True:
        try:
            head, arrays = frames.receive(incoming)
        except frames.PipeClosed:
            return
        number = {"frame": head["frame"]}
        if "cell" in head:
            frames.send(outgoing, number | run_cell(namespace, head["cell"], head["code"]))
        else:
            outcome, values = make_call(namespace, head, arrays)
            _send_result(outgoing, number, outcome, values)


def run_cell(namespace: dict[str, Any], number: int, code: str) -> dict[str, Any]:
    """Run a cell and return its error."""
    name = f"cell {number}"
    linecache.cache[name] = (len(code), None, code.splitlines(keepends=True), name)
    try:
        exec(compile(code, name, "exec"), namespace)
    except BaseException as error:
        return {"cell": number, "error": _short(f"{type(error).__name__}: {error}")}
    return {"cell": number, "error": ""}


def make_call(
    namespace: dict[str, Any], head: dict[str, Any], arrays: list[Any]
) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """Make the call that a frame describes, and return its outcome."""
    arguments = tuple(
        arrays[a["array"]] if "array" in a else a["number"] for a in head["arguments"]
    )
    call = Call(head["function"], arguments, head["case"])
    (outcome,) = perform(namespace, (call,), head["seconds"])
    described = {
        "status": outcome.status,
        "returned": _short(outcome.returned),
        "error": _short(outcome.error),
        "line": _short(outcome.line),
        "modified": list(outcome.modified),
        "numbers": outcome.values is not None,
    }
    return described, outcome.values or ()


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


class _Shell:
    """A notebook's shell whose methods do nothing."""

    def __getattr__(self, name: str) -> Any:
        return _nothing


def of_notebooks() -> dict[str, Any]:
    """Return the names that a notebook defines without an import; here they do nothing."""
    return {"display": _nothing, "get_ipython": _Shell}


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
