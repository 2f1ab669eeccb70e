"""Assignments for the grading benchmarks: a notebook for every grader, and submissions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from fieldcheck.questions import questions
from fieldgrade.authoring.known_answers import public_calls
from fieldgrade.authoring.notebooks import stub
from fieldgrade.authoring.sources import Cell, Source

ROOT = Path(__file__).parents[1]
SMALL, LARGE = "three questions", "exercise 02 with its figures"
VERSION = {"schema_version": 3, "task": False}


@dataclass(frozen=True)
class BenchmarkAssignment:
    """A notebook with a test after each question in nbgrader's form; otter uses the same tests.

    The tests compare with the correct answers to the public cases, to 1e-6.
    """

    name: str

    @cached_property
    def source(self) -> Source:
        number = "01" if self.name == SMALL else "02"
        return next(Source(path) for path in (ROOT / "solutions").glob(f"{number}_*.py"))

    @cached_property
    def cells(self) -> Sequence[Cell]:
        """The whole notebook, or the cells that its first three questions need."""
        cells = [cell for cell in self.source.cells if not cell.rubric]
        if self.name == LARGE:
            return cells
        setup = Cell("code", "import numpy as np", {})
        return [setup, *(cell for cell in cells if cell.question)][:4]

    @property
    def answers(self) -> Mapping[str, Cell]:
        return {cell.question: cell for cell in self.cells if cell.question}

    @cached_property
    def tests(self) -> Mapping[str, str]:
        """The test of each question as Python: calls, their arguments and the expected results."""
        functions = self.source.functions()
        return {name: test(name, functions) for name in self.answers}

    def notebook(self, instead: Mapping[str, str]) -> bytes:
        """The notebook file, with other answers to some questions."""
        made = []
        for cell in self.cells:
            text = instead.get(cell.question, cell.text)
            solution = {"grade": False, "locked": False, "solution": True}
            name = cell.question
            made.append(_cell(cell.kind, text, f"answer-{name}" if name else "", solution))
            if name:
                tested = {"grade": True, "locked": True, "solution": False, "points": 1}
                made.append(_cell("code", self.tests[name], f"test-{name}", tested))
        kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
        data = {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4}
        return json.dumps(data | {"nbformat_minor": 4}).encode()

    def submission(self, number: int) -> bytes:
        """A submission: of ten, four are right, three lack an answer, three return wrong values."""
        wrong = self.wrong(number)
        if wrong is None:
            return self.notebook({})
        cell = self.answers[wrong]
        head = cell.text.partition("\n")[0]
        lacks = number % 10 < 7
        return self.notebook(
            {wrong: stub(cell) if lacks else f"{head}\n    return np.zeros((2, 3))\n"}
        )

    def wrong(self, number: int) -> str | None:
        """The question with a wrong answer, one of the last three."""
        names, k = list(self.answers), number % 10
        return None if k < 4 else names[-1 - (k - 4) % 3]

    def right(self, number: int, *, inherit: bool) -> set[str]:
        """The questions that earn their points.

        Where mistakes are inherited, answers that call a wrong one do not.
        """
        wrong = self.wrong(number)
        if wrong is None:
            return set(self.answers)
        lost = {wrong, *self._callers(wrong)} if inherit else {wrong}
        return set(self.answers) - lost

    def _callers(self, wrong: str) -> set[str]:
        """All questions whose answers call a function, directly or not."""
        function = questions()[wrong].function
        direct = {n for n, c in self.answers.items() if f"{function}(" in c.text} - {wrong}
        return direct.union(*map(self._callers, direct))


def test(name: str, functions: Mapping[str, object]) -> str:
    """The test of a question in the form that nbgrader runs."""
    lines = []
    for call in public_calls(questions()[name]):
        arguments = ", ".join(map(_written, call.arguments))
        right = functions[call.function](*call.arguments)
        parts = right if isinstance(right, tuple) else (right,)
        for k, part in enumerate(parts):
            which = f"[{k}]" if isinstance(right, tuple) else ""
            lines.append(
                f"np.testing.assert_allclose({call.function}({arguments}){which}, "
                f"{_written(np.asarray(part))}, rtol=1e-6, atol=1e-6)"
            )
    return "\n".join(lines)


def _written(argument: object) -> str:
    return f"np.array({argument.tolist()})" if isinstance(argument, np.ndarray) else repr(argument)


def _cell(kind: str, text: str, name: str, what: Mapping[str, object]) -> dict:
    identifier = name.replace(".", "-")
    metadata = {"nbgrader": {"grade_id": identifier, **VERSION, **what}} if name else {}
    code = {"outputs": [], "execution_count": None} if kind == "code" else {}
    return {"cell_type": kind, "metadata": metadata, "source": text, **code}
