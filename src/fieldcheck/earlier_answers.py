"""Earlier answers that an answer calls: right code that calls wrong code is not blamed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import update_wrapper
from io import StringIO
from itertools import takewhile
from typing import Any

from fieldcheck.calls import Call, perform
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldcheck.verdict import Verdict

_ABSENT = object()


def explained_by_earlier(
    verdict: Verdict,
    question: Question,
    calls: Sequence[Call],
    functions: dict[str, Any],
    check: Callable[[Question], Verdict],
) -> Verdict:
    """Return the verdict that names the first wrong answer which the failing calls use, if any.

    Parameters
    ----------
    verdict : Verdict
        The verdict on the answer.
    question : Question
        Its question.
    calls : sequence of Call
        The calls on which it was judged.
    functions : dict
        The namespace of the functions.
    check : callable
        ``check(earlier) -> Verdict``, the verdict on the answer to an earlier question.

    Returns
    -------
    Verdict
        The same verdict if the failing calls use no wrong answer, so that the answer itself is
        wrong. An earlier answer that is only slow explains only that this one is slow.
    """
    failing = calls if verdict.call is None else calls[verdict.call : verdict.call + 1]
    for earlier in called_by(question, failing, functions):
        found = check(earlier)
        if found.finding == "inherited":
            return Verdict(question.name, "inherited", found.sentence)
        if found.credit == 0 or (
            found.finding == "slow" and verdict.finding in ("slow", "endless")
        ):
            action = "write" if found.finding in ("missing", "unwritten") else "correct"
            sentence = (
                f"First {action} {earlier.name} (function `{earlier.function}`), which "
                f"{question.function} calls."
            )
            return Verdict(question.name, "inherited", sentence)
    return verdict


def earlier_questions(question: Question) -> list[Question]:
    """Return the questions of the same notebook that come before a question."""
    before = takewhile(lambda other: other.name != question.name, questions().values())
    return [other for other in before if other.notebook == question.notebook]


def called_by(
    question: Question, calls: Sequence[Call], functions: dict[str, Any]
) -> list[Question]:
    """Return the earlier questions whose functions are called when these calls are made again."""
    earlier, called = earlier_questions(question), set[str]()
    recorders = {q.function: _recorder(q, functions.get(q.function), called) for q in earlier}
    with in_place_of(functions, question.function, recorders), redirect_stdout(StringIO()):
        perform(functions, calls, question.limit)
    return [other for other in earlier if other.name in called]


def _recorder(question: Question, function: Any, called: set[str]) -> Callable[..., Any]:
    """Return a function that calls another, and notes it; one that is missing raises NameError."""

    def record(*arguments: Any, **named: Any) -> Any:
        called.add(question.name)
        if not callable(function):
            raise NameError(f"name {question.function!r} is not defined")
        return function(*arguments, **named)

    return update_wrapper(record, function) if callable(function) else record


@contextmanager
def in_place_of(
    functions: dict[str, Any], answer: str, stand_ins: Mapping[str, Callable[..., Any]]
) -> Iterator[None]:
    """Let an answer, and all that it calls, call other functions in this block.

    Parameters
    ----------
    functions : dict
        The namespace of the functions.
    answer : str
        The name of the function that is the answer.
    stand_ins : mapping
        The other functions, by the names of those that they replace. A function is replaced under
        each of its global names, also in the module that defines it. A name that is not defined
        is defined.
    """
    own = getattr(functions.get(answer), "__globals__", functions)
    homes = (getattr(functions.get(name), "__globals__", functions) for name in stand_ins)
    spaces = {id(space): space for space in (functions, own, *homes)}.values()
    changed: list[tuple[dict[str, Any], str, Any]] = []
    try:
        for name, stand_in in stand_ins.items():
            known = functions.get(name)
            for space in spaces:
                names = [n for n, value in space.items() if value is known and callable(known)]
                if (space is functions or space is own) and not callable(space.get(name)):
                    names.append(name)
                changed += [(space, n, space.get(n, _ABSENT)) for n in names]
                space.update(dict.fromkeys(names, stand_in))
        yield
    finally:
        for space, name, before in reversed(changed):
            if before is _ABSENT:
                space.pop(name, None)
            else:
                space[name] = before
