"""The functions that a notebook calls: `check`, `progress`, `data`, `start_over`."""

from __future__ import annotations

import html
import json
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

from fieldcheck.answers import public_answers
from fieldcheck.calls import perform
from fieldcheck.judge import TIMEOUT_FACTOR, judge
from fieldcheck.pictures import picture_of_difference
from fieldcheck.question import Question
from fieldcheck.questions import get, questions
from fieldcheck.seeds import EVERYBODY, seed, student
from fieldcheck.verdict import CREDIT, Verdict

RECORD = ".progress.json"
"""The file beside the notebooks that stores the verdicts."""


def check(name: str, functions: dict[str, Any] | None = None) -> Verdict:
    """Check the answer to a question, and report the first problem, if there is any.

    Your function is called first with inputs that are the same for everybody, whose right answer is
    known, then with your own inputs, for which laws are checked that every right answer satisfies.

    Parameters
    ----------
    name : str
        Such as ``"02.3"``.
    functions : dict, optional
        The namespace of the function; by default that of the notebook.
    """
    question = get(name)
    functions = _notebook_namespace() if functions is None else functions
    verdict = try_public(question, functions)
    if verdict.right:
        verdict = try_seed(question, functions, seed(student(), name))
    _remember(verdict)
    return verdict


def try_public(question: Question, functions: dict[str, Any]) -> Verdict:
    """Judge the outcomes of the public cases."""
    calls = question.inputs(seed(EVERYBODY, question.name))
    outcomes = perform(functions, calls, TIMEOUT_FACTOR * question.limit)
    answers = public_answers(question.notebook).get(question.name)
    verdict = judge(question, calls, outcomes, answers)
    return picture_of_difference(verdict, question, calls, outcomes, answers)


def try_seed(question: Question, functions: dict[str, Any], number: int) -> Verdict:
    """Judge the outcomes for the inputs of a seed, by the laws alone."""
    calls = question.inputs(number)
    return judge(question, calls, perform(functions, calls, TIMEOUT_FACTOR * question.limit))


def data(name: str) -> tuple[Any, ...]:
    """Return your own inputs to a question: the arguments of its first call.

    They depend on the name in ``student.txt`` beside the notebooks.
    """
    return get(name).inputs(seed(student(), name))[0].arguments


def progress() -> Progress:
    """Return your progress: questions, verdicts and points of the notebooks that you began."""
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


class Progress:
    """A table of questions and verdicts."""

    def __init__(self, record: dict[str, str]) -> None:
        begun = {name.partition(".")[0] for name in record}
        self.rows = [
            (q.name, q.function, record.get(q.name, "unwritten"), q.points)
            for q in questions().values()
            if q.notebook in begun or not begun
        ]

    @property
    def earned(self) -> float:
        """The points that the right answers would earn."""
        return sum(CREDIT.get(rung, 0.0) * points for *_, rung, points in self.rows)

    @property
    def possible(self) -> int:
        """The points of all questions."""
        return sum(points for *_, points in self.rows)

    def __repr__(self) -> str:
        lines = [f"{name}  {function:<32} {_symbol(rung)}" for name, function, rung, _ in self.rows]
        return "\n".join([*lines, f"{self.earned:g} of {self.possible} points"])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td style='text-align:left'><code>{function}</code></td>"
            f"<td style='text-align:left'>{html.escape(_symbol(rung))}</td><td>{points}</td></tr>"
            for name, function, rung, points in self.rows
        )
        head = "<tr><th></th><th style='text-align:left'>function</th><th></th><th>points</th></tr>"
        total = f"<p>{self.earned:g} of {self.possible} points</p>"
        return f"<table>{head}{rows}</table>{total}"


def _symbol(rung: str) -> str:
    return {"right": "✓ right", "unwritten": "·", "missing": "·"}.get(rung, f"✗ {rung}")


def _record() -> dict[str, str]:
    file = Path.cwd() / RECORD
    try:
        return dict(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return {}


def _remember(verdict: Verdict) -> None:
    record = _record() | {verdict.question: verdict.rung}
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
