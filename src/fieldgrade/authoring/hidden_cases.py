"""Hidden cases, which only the grader uses: ``grading/`` beside the sources.

A hidden case has a sentence for the student, who never sees the input::

    @hidden("01.2", "Points far from the origin lose digits in monomials around it.")
    def far_away(seed):
        return (Call("fit", (points, values), "points at an offset"),)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fieldcheck.calls import Call
from fieldgrade.authoring.catalogue import load
from fieldgrade.authoring.sources import Source

Inputs = Callable[[int], tuple[Call, ...]]


@dataclass(frozen=True)
class Hidden:
    """Hidden cases of a question: a function from seeds to calls, and the sentence for students."""

    question: str
    sentence: str
    inputs: Inputs

    @property
    def name(self) -> str:
        """The name of the function, in words."""
        return self.inputs.__name__.replace("_", " ")


def hidden(question: str, sentence: str) -> Callable[[Inputs], Inputs]:
    """Mark a function from seeds to calls as hidden cases of a question."""

    def mark(inputs: Inputs) -> Inputs:
        inputs.__dict__["hidden"] = Hidden(question, sentence, inputs)
        return inputs

    return mark


def hidden_cases(source: Source) -> list[Hidden]:
    """Return the hidden cases of the questions of a source."""
    path = source.path.parent / "grading" / source.path.name
    if not path.is_file():
        return []
    return [f.hidden for f in vars(load(path)).values() if hasattr(f, "hidden")]
