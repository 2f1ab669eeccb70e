"""The proof that the graders are right: what they say of every answer whose worth is known."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from fieldcheck.calls import Outcome
from fieldcheck.ladder import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldgrade.authoring.catalogue import Entry, entries
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.notebooks import stub
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import Trial, grade, trials
from fieldgrade.grader_validation.mutants import mutants

FEWEST_ALTERNATIVES = 3
FEWEST_CAUGHT = 0.95
APART = 100.0
"""Known answers differ by at least so many tolerances on the public cases."""
SECONDS_FOR_A_MUTANT = 0.5
STUDENT = "proof"


@dataclass(frozen=True)
class GraderReport:
    """What the graders of a question said, and what of it is wrong.

    Parameters
    ----------
    question : str
        Its name.
    mistakes, alternatives, mutants : int
        How many there are.
    caught : int
        How many mutants lost points.
    survivors : tuple of str
        The mutants that did not.
    problems : tuple of str
        What has to be mended; none if all is well.
    """

    question: str
    mistakes: int
    alternatives: int
    mutants: int
    caught: int
    survivors: tuple[str, ...] = field(default=())
    problems: tuple[str, ...] = field(default=())

    def with_problems(self, more: Sequence[str]) -> GraderReport:
        """Return a proof with more that has to be mended."""
        return replace(self, problems=(*self.problems, *more))


def grader_reports(source: Source, salt: str, only: str = "") -> Iterator[GraderReport]:
    """Yield the proof of each question of a notebook."""
    functions = source.functions()
    mistakes, others = entries(source, "misconceptions"), entries(source, "alternatives")
    hidden, cells = hidden_cases(source), source.answer_cells()
    reasons = survivors_with_reasons(source)
    for question in questions().values():
        if question.notebook == source.number and question.name.startswith(only):
            tried = trials(question, functions, mistakes, hidden, STUDENT, salt)
            yield _prove(
                question,
                tried,
                functions,
                cells[question.name],
                [m for m in mistakes if m.question == question.name],
                [a for a in others if a.question == question.name],
                reasons.get(question.name, {}),
            )


def _prove(
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
        *_alternatives(tried, functions, others),
        *(f"no reason is given why this survives: {s}" for s in survivors if s not in reasons),
        *(f"a reason is given, but this is caught: {s}" for s in reasons if s not in survivors),
    ]
    if not question.laws:
        problems.append("it has no law, so nothing can be said of a student's own inputs")
    if total == 0:
        problems.append("its solution cannot be changed: there is nothing between the markers")
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
    if verdict.rung != "unwritten" or verdict.credit:
        yield f"the stub should be told that it is not written; it is told: {verdict}"


def _mistakes(
    tried: Sequence[Trial], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> Iterator[str]:
    for mistake in mistakes:
        verdict = grade(tried, mistake.namespace(functions))
        if verdict.right:
            yield f"the mistake {mistake.name!r} is told that it is right"
        elif verdict.mistake != (mistake.name if mistake.named else ""):
            yield f"the mistake {mistake.name!r} is told: {verdict}"
        if len(mistake.sentence) < 40:
            yield f"the mistake {mistake.name!r} has no sentence to speak of"


def _apart(public: Trial) -> Iterator[str]:
    """Yield the pairs of known answers that the public cases hardly tell apart."""
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
        yield f"only {len(others)} right answers in other ways; {FEWEST_ALTERNATIVES} are wanted"
    for other in others:
        verdict = grade(tried, other.namespace(functions))
        if not verdict.right:
            yield f"the right answer {other.name!r} is told: {verdict}"


def _survivors(
    tried: Sequence[Trial], functions: dict[str, Any], code: str
) -> tuple[int, list[str]]:
    """Return how many mutants there are, and those that lose no points."""
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
    """Return what code defines, seeing the functions of the notebook."""
    namespace = dict(functions)
    exec(compile(code, "answer", "exec"), namespace)
    return {key: value for key, value in namespace.items() if functions.get(key) is not value}


def survivors_with_reasons(source: Source) -> dict[str, dict[str, str]]:
    """Return the changes that no check need notice, and why, by question."""
    path = Path(source.path.parent / "grading" / "survivors.toml")
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
