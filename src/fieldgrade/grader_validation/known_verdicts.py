"""Test the graders on answers with known verdicts: solution, stub, mistakes, mutants and others."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from fieldcheck.calls import Outcome
from fieldcheck.judge import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldgrade.authoring.catalogue import Entry, entries
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.notebooks import stub
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import Trial, grade, trials
from fieldgrade.grader_validation.inherited_mistakes import blamed, unpaid
from fieldgrade.grader_validation.mutants import mutants
from fieldgrade.grader_validation.single_inputs import caught_by_few

FEWEST_ALTERNATIVES = 3
FEWEST_CAUGHT = 0.95
APART = 100.0
"""Known answers must differ by this many tolerances on the public cases."""
SECONDS_FOR_A_MUTANT = 0.5
STUDENT = "proof"


@dataclass(frozen=True)
class GraderReport:
    """The verdicts of the graders of a question, and what is wrong with them.

    Parameters
    ----------
    question : str
        The name of the question.
    mistakes, alternatives, mutants : int
        The numbers of answers.
    caught : int
        The number of mutants that lost points.
    survivors : tuple of str
        The mutants that lost no points.
    problems : tuple of str
        Failures of the test; empty if there are none.
    """

    question: str
    mistakes: int
    alternatives: int
    mutants: int
    caught: int
    survivors: tuple[str, ...] = field(default=())
    problems: tuple[str, ...] = field(default=())

    def with_problems(self, more: Sequence[str]) -> GraderReport:
        """Return the report with more problems."""
        return replace(self, problems=(*self.problems, *more))


def grader_reports(source: Source, salt: str, only: str = "") -> Iterator[GraderReport]:
    """Yield the report on each question of a notebook."""
    functions = source.functions()
    mistakes, others = entries(source, "misconceptions"), entries(source, "alternatives")
    hidden, cells = hidden_cases(source), source.answer_cells()
    reasons = survivors_with_reasons(source)
    for question in questions().values():
        if question.notebook == source.number and question.name.startswith(only):
            tried = trials(question, functions, mistakes, hidden, STUDENT, salt)
            yield _report(
                question,
                tried,
                functions,
                cells[question.name],
                [m for m in mistakes if m.question == question.name],
                [a for a in others if a.question == question.name],
                reasons.get(question.name, {}),
            ).with_problems(
                [
                    *blamed(question, functions, mistakes),
                    *unpaid(question, functions, source, tried),
                ]
            )


def _report(
    question: Question,
    tried: Sequence[Trial],
    functions: dict[str, Any],
    cell: Any,
    mistakes: Sequence[Entry],
    others: Sequence[Entry],
    reasons: dict[str, str],
) -> GraderReport:
    total, survivors = _survivors(tried, functions, cell.text)
    caught = total - len(survivors)
    problems = [
        *_reference_and_stub(tried, functions, stub(cell)),
        *_mistakes(tried, functions, mistakes),
        *_apart(tried[0]),
        *caught_by_few(tried, functions, mistakes),
        *_alternatives(tried, functions, others),
        *(f"no reason is given why this survives: {s}" for s in survivors if s not in reasons),
        *(f"a reason is given, but this is caught: {s}" for s in reasons if s not in survivors),
    ]
    if not question.laws:
        problems.append("it has no law, so answers to a student's own inputs cannot be judged")
    if total == 0:
        problems.append("its solution has no mutants: there is nothing between the markers")
    elif caught < FEWEST_CAUGHT * total:
        problems.append(f"only {caught} of {total} mutants lose points")
    return GraderReport(
        question.name, len(mistakes), len(others), total, caught, tuple(survivors), tuple(problems)
    )


def _reference_and_stub(
    tried: Sequence[Trial], functions: dict[str, Any], empty: str
) -> Iterator[str]:
    verdict = grade(tried, functions)
    if not verdict.right:
        yield f"the solution is not right: {verdict}"
    verdict = grade(tried, functions | _defined(empty, functions))
    if verdict.finding != "unwritten" or verdict.credit:
        yield f"the stub should get the verdict unwritten; it gets: {verdict}"


def _mistakes(
    tried: Sequence[Trial], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> Iterator[str]:
    for mistake in mistakes:
        verdict = grade(tried, mistake.namespace(functions))
        if verdict.right:
            yield f"the mistake {mistake.name!r} gets the verdict right"
        elif verdict.mistake != (mistake.name if mistake.named else ""):
            yield f"the mistake {mistake.name!r} gets: {verdict}"
        if len(mistake.sentence) < 40:
            yield f"the mistake {mistake.name!r} has a sentence of less than 40 characters"


def _apart(public: Trial) -> Iterator[str]:
    """Yield the pairs of known answers that hardly differ on the public cases."""
    right = tuple(Outcome("returned", values=values) for values in public.answers.right)
    known = [("the right answer", right)]
    known += [(f"{m.name!r}", m.outcomes) for m in public.answers.mistakes]
    for (one, outcomes), (other, others) in combinations(known, 2):
        apart = public.answers.distance(public.question, public.calls, outcomes, others)
        if not apart > APART:
            yield f"{one} and {other} are only {apart:.2g} tolerances apart"


def _alternatives(
    tried: Sequence[Trial], functions: dict[str, Any], others: Sequence[Entry]
) -> Iterator[str]:
    if len(others) < FEWEST_ALTERNATIVES:
        yield f"only {len(others)} alternative right answers; {FEWEST_ALTERNATIVES} are required"
    for other in others:
        verdict = grade(tried, other.namespace(functions))
        if not verdict.right:
            yield f"the right answer {other.name!r} gets: {verdict}"


def _survivors(
    tried: Sequence[Trial], functions: dict[str, Any], code: str
) -> tuple[int, list[str]]:
    """Return the number of mutants, and those that lose no points."""
    limit = SECONDS_FOR_A_MUTANT / TIMEOUT_FACTOR
    hurried = [replace(t, question=replace(t.question, limit=limit)) for t in tried]
    total, survivors = 0, []
    for change, changed in mutants(code):
        total += 1
        try:
            defined = _defined(changed, functions)
        except Exception:  # a mutant that cannot even be defined is caught
            continue
        if grade(hurried, functions | defined).credit > 0:
            survivors.append(change)
    return total, survivors


def _defined(code: str, functions: dict[str, Any]) -> dict[str, Any]:
    """Return the definitions of code that may use the functions of the notebook."""
    namespace = dict(functions)
    exec(compile(code, "answer", "exec"), namespace)
    return {key: value for key, value in namespace.items() if functions.get(key) is not value}


def survivors_with_reasons(source: Source) -> dict[str, dict[str, str]]:
    """Return the equivalent mutants with their reasons, by question."""
    path = Path(source.path.parent / "grading" / "survivors.toml")
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
