"""The verdict on an answer, in notebooks and in the grader, and the ladder of its rungs."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import Literal, get_args

Rung = Literal[
    "missing",
    "unwritten",
    "exception",
    "endless",
    "type",
    "shape",
    "not finite",
    "modified",
    "misconception",
    "wrong",
    "slow",
    "right",
]

LADDER: tuple[Rung, ...] = get_args(Rung)
"""The rungs in the order in which they are checked; the first that fails is reported."""

CREDIT = {"right": 1.0, "slow": 0.5}

TITLES: dict[str, str] = {
    "missing": "— the function is not there",
    "unwritten": "— not written yet",
    "exception": "— stops with an error",
    "endless": "— does not come to an end",
    "type": "— returns the wrong kind of thing",
    "shape": "— returns the wrong shape",
    "not finite": "— returns values that are not finite",
    "modified": "— changes its input",
    "misconception": "— not right, and this mistake is a known one",
    "wrong": "— not right yet",
    "slow": "— right, but slow",
    "right": "— right",
}


@dataclass(frozen=True)
class Verdict:
    """The rung that an answer reached, and its sentence.

    Parameters
    ----------
    question : str
        The name of the question.
    rung : str
        The first rung that failed, or ``"right"``.
    sentence : str
        The sentence for the student.
    mistake : str
        Name of the recognised misconception.
    call : int, optional
        The call with the largest error.
    picture : str
        A picture of the difference, as SVG; may be empty.
    """

    question: str
    rung: Rung
    sentence: str
    mistake: str = ""
    call: int | None = None
    picture: str = ""

    @property
    def credit(self) -> float:
        """The share of the points that the answer earns."""
        return CREDIT.get(self.rung, 0.0)

    @property
    def right(self) -> bool:
        """Whether the answer is right."""
        return self.rung == "right"

    def __str__(self) -> str:
        return f"{self.question} {TITLES[self.rung]}. {self.sentence}".rstrip()

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        color = "#2e8540" if self.right else "#767676" if self.rung == "unwritten" else "#c4501b"
        text = html.escape(self.sentence)
        return (
            f'<div style="border-left:4px solid {color};padding:.3em .8em;margin:.3em 0;'
            f'max-width:46em"><b style="color:{color}">{self.question} {TITLES[self.rung]}</b>'
            f"<div>{text}</div>{self.picture}</div>"
        )
