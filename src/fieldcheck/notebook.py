"""The functions that a notebook calls: `check`, `case`, `progress`, `data`, `start_over`."""

from __future__ import annotations

import html
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from fieldcheck.answers import Answers, public_answers
from fieldcheck.calls import Call, Outcome, perform
from fieldcheck.earlier_answers import explained_by_earlier
from fieldcheck.failed_case import FailedCase, failed_case
from fieldcheck.judge import TIMEOUT_FACTOR, judge
from fieldcheck.pictures import picture_of_difference
from fieldcheck.question import Question
from fieldcheck.questions import get, questions
from fieldcheck.seeds import EVERYBODY, seed, student
from fieldcheck.verdict import CREDIT, TITLES, WAITING, Verdict

RECORD = ".progress.json"
"""The file beside the notebooks that stores the verdicts."""

Row = tuple[str, str, str, int]
"""A question, its function, the verdict, and its points."""
Part = tuple[str, list[Row], str]
"""A heading, rows, and the sum of their points in words."""

_failed: dict[str, FailedCase | None] = {}
"""The failed case of each question, or None after a right check; the latest last."""


def check(name: str, functions: dict[str, Any] | None = None) -> Verdict:
    """Check the answer to a question, and report the first problem, if there is any.

    Your function is called first with inputs that are the same for everybody, whose right answer is
    known, then with your own inputs, for which laws are checked that every right answer satisfies.
    If it is not right and calls a function of an earlier question that is not right either, the
    check names that question, which must be corrected first.

    Parameters
    ----------
    name : str
        Such as ``"02.3"``.
    functions : dict, optional
        The namespace of the function; by default that of the notebook.
    """
    question = get(name)
    functions = _notebook_namespace() if functions is None else functions
    tried = _try_both(question, functions)
    verdict = picture_of_difference(
        tried.verdict, question, tried.calls, tried.outcomes, tried.answers
    )
    _remember(verdict)
    if verdict.right:
        _failed[question.name] = None
    return verdict


@dataclass(frozen=True)
class _Tried:
    """The calls of an answer, their outcomes, the known answers, and the verdict."""

    calls: Sequence[Call]
    outcomes: Sequence[Outcome]
    answers: Answers | None
    verdict: Verdict


def try_public(question: Question, functions: dict[str, Any]) -> Verdict:
    """Judge the outcomes of the public cases."""
    return _try_public(question, functions).verdict


def try_seed(question: Question, functions: dict[str, Any], number: int) -> Verdict:
    """Judge the outcomes for the inputs of a seed, by the laws alone."""
    return _try(question, functions, number, None).verdict


def _try_both(question: Question, functions: dict[str, Any]) -> _Tried:
    """Try the public cases and, if they are right, the student's own inputs."""
    public = _try_public(question, functions)
    if not public.verdict.right:
        return public
    return _try(question, functions, seed(student(), question.name), None)


def _try_public(question: Question, functions: dict[str, Any]) -> _Tried:
    answers = public_answers(question.notebook).get(question.name)
    return _try(question, functions, seed(EVERYBODY, question.name), answers)


def _try(
    question: Question, functions: dict[str, Any], number: int, answers: Answers | None
) -> _Tried:
    calls = question.inputs(number)
    outcomes = perform(functions, calls, TIMEOUT_FACTOR * question.limit)
    verdict = judge(question, calls, outcomes, answers)
    if verdict.finding not in ("right", "missing"):
        verdict = explained_by_earlier(
            verdict, question, calls, functions, lambda q: _try_both(q, functions).verdict
        )
    _failed.pop(question.name, None)
    if failed := failed_case(verdict, question, calls, outcomes, answers):
        _failed[question.name] = failed
    return _Tried(calls, outcomes, answers, verdict)


def case(name: str = "") -> FailedCase:
    """Return the case for which a check failed: arguments, returned values, and right values.

    Parameters
    ----------
    name : str, optional
        The question; by default that of the last check that was not right.

    Raises
    ------
    ValueError
        If the last check of this question, or without a name the last check, has not failed.
    """
    found = _failed.get(get(name).name) if name else next(reversed(_failed.values()), None)
    if found is None:
        raise ValueError(f"the last check{name and ' of '}{name} has not failed; run a check first")
    return found


def data(name: str) -> tuple[Any, ...]:
    """Return your own inputs to a question: the arguments of its first call.

    They depend on the name in ``student.txt`` beside the notebooks.
    """
    return get(name).inputs(seed(student(), name))[0].arguments


def progress() -> Progress:
    """Return your progress: questions, verdicts and points of each notebook that you began.

    Optional questions have a table and a sum of their own. Answers in words are not checked.
    """
    return Progress(_record())


def start_over(name: str) -> None:
    """Insert the original cell of a question, as a new cell below.

    It is not called ``reset``, since IPython has a command of this name that deletes all variables.
    """
    stub = stubs()[get(name).name]
    shell = _shell()
    if shell is None:
        print(stub)
    else:
        shell.set_next_input(stub)


def stubs() -> dict[str, str]:
    """Return the original cells, by question."""
    return dict(json.loads((files("fieldcheck") / "stubs.json").read_text(encoding="utf-8")))


def optional_questions() -> frozenset[str]:
    """Return the names of the optional questions."""
    return frozenset(_outline()["optional"])


def points_in_words() -> dict[str, float]:
    """Return the points of the answers in words of each notebook, without the optional ones."""
    return dict(_outline()["points_in_words"])


def _outline() -> dict[str, Any]:
    file = files("fieldcheck") / "outline.json"
    return dict(json.loads(file.read_text(encoding="utf-8")))


class Progress:
    """A table for each notebook: its questions for functions, and the sum of their points."""

    def __init__(self, record: dict[str, str]) -> None:
        begun = {name.partition(".")[0] for name in record}
        self.rows: list[Row] = [
            (q.name, q.function, record.get(q.name, "unwritten"), q.points)
            for q in questions().values()
            if q.notebook in begun or not begun
        ]
        optional = optional_questions()
        self.core = [row for row in self.rows if row[0] not in optional]

    @property
    def earned(self) -> float:
        """The points that the right answers of the core would earn."""
        return _earned(self.core)

    @property
    def possible(self) -> int:
        """The points of the functions of the core."""
        return _possible(self.core)

    @property
    def _parts(self) -> list[Part]:
        return [
            part
            for notebook in dict.fromkeys(_notebook(row) for row in self.rows)
            for part in self._parts_of([row for row in self.rows if _notebook(row) == notebook])
        ]

    def _parts_of(self, rows: list[Row]) -> list[Part]:
        notebook = _notebook(rows[0])
        core = [row for row in rows if row in self.core]
        optional = [row for row in rows if row not in self.core]
        words = points_in_words().get(notebook, 0)
        more = f"; {words:g} more for answers in words, which are graded by hand" if words else ""
        parts = [(f"Notebook {notebook}", core, f"{_sum(core)} for functions{more}")]
        if optional:
            parts.append((f"Notebook {notebook}, optional", optional, _sum(optional)))
        return parts

    def __repr__(self) -> str:
        return "\n".join(
            line
            for heading, rows, total in self._parts
            for line in (
                heading,
                *(
                    f"{name}  {function:<32} {_symbol(finding)}"
                    for name, function, finding, _ in rows
                ),
                total,
            )
        )

    def _repr_html_(self) -> str:
        left = "style='text-align:left'"
        return "".join(
            f"<table><caption {left}>{heading}</caption>"
            f"<tr><th></th><th {left}>function</th><th></th><th>points</th></tr>"
            f"{''.join(map(_html_row, rows))}</table><p>{total}</p>"
            for heading, rows, total in self._parts
        )


def _notebook(row: Row) -> str:
    return row[0].partition(".")[0]


def _earned(rows: list[Row]) -> float:
    return sum(CREDIT.get(finding, 0.0) * points for *_, finding, points in rows)


def _possible(rows: list[Row]) -> int:
    return sum(points for *_, points in rows)


def _sum(rows: list[Row]) -> str:
    return f"{_earned(rows):g} of {_possible(rows)} points"


def _html_row(row: Row) -> str:
    name, function, finding, points = row
    return (
        f"<tr><td>{name}</td><td style='text-align:left'><code>{function}</code></td>"
        f"<td style='text-align:left'>{html.escape(_symbol(finding))}</td><td>{points}</td></tr>"
    )


def _symbol(finding: str) -> str:
    if finding in ("unwritten", "missing"):
        return "·"
    sign = "✓" if CREDIT.get(finding) else "·" if finding in WAITING else "✗"
    return f"{sign} {TITLES.get(finding, finding).lstrip('— ')}"


def _record() -> dict[str, str]:
    file = Path.cwd() / RECORD
    try:
        return dict(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return {}


def _remember(verdict: Verdict) -> None:
    record = _record() | {verdict.question: verdict.finding}
    try:
        (Path.cwd() / RECORD).write_text(json.dumps(record, sort_keys=True), encoding="utf-8")
    except OSError:
        return  # in a read-only folder nothing is stored


def _shell() -> Any:
    module = sys.modules.get("IPython")
    return module.get_ipython() if module else None


def _notebook_namespace() -> dict[str, Any]:
    shell = _shell()
    if shell is not None:
        return dict(shell.user_ns)
    return dict(vars(sys.modules["__main__"]))
