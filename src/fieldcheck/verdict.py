"""The verdict on an answer, in notebooks and in the grader, and the order of its findings."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import Literal, get_args

Finding = Literal[
    "missing",
    "unwritten",
    "exception",
    "endless",
    "type",
    "shape",
    "not finite",
    "modified",
    "inherited",
    "misconception",
    "wrong",
    "slow",
    "right",
]

FINDINGS: tuple[Finding, ...] = get_args(Finding)
"""All findings in the order in which they are looked for; the first is reported."""

WAITING = ("unwritten", "inherited")
"""Nothing is known about the answer itself yet."""

CREDIT = {"right": 1.0, "slow": 0.5}

TITLES: dict[str, str] = {
    "missing": "— the function is not there",
    "unwritten": "— not written yet",
    "exception": "— stops with an error",
    "endless": "— takes too long, and was stopped",
    "type": "— returns the wrong kind of thing",
    "shape": "— returns the wrong shape",
    "not finite": "— returns values that are not finite",
    "modified": "— changes its input",
    "inherited": "— waits for an earlier answer",
    "misconception": "— not right: your results are those of a known mistake",
    "wrong": "— not right yet",
    "slow": "— right, but slow",
    "right": "— right",
}


@dataclass(frozen=True)
class Verdict:
    """The first finding on an answer, and its sentence.

    Parameters
    ----------
    question : str
        The name of the question.
    finding : str
        What is wrong, or ``"right"``.
    sentence : str
        The sentence for the student.
    mistake : str
        Name of the recognized misconception.
    call : int, optional
        The first call that fails.
    picture : str
        A picture of the difference, as SVG; may be empty.
    """

    question: str
    finding: Finding
    sentence: str
    mistake: str = ""
    call: int | None = None
    picture: str = ""

    @property
    def credit(self) -> float:
        """The share of the points that the answer earns."""
        return CREDIT.get(self.finding, 0.0)

    @property
    def right(self) -> bool:
        """Whether the answer is right."""
        return self.finding == "right"

    def __str__(self) -> str:
        return f"{self.question} {TITLES[self.finding]}. {self.sentence}".rstrip()

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        color = "#2e8540" if self.right else "#767676" if self.finding in WAITING else "#c4501b"
        text = html.escape(self.sentence)
        return (
            f'<div style="border-left:4px solid {color};padding:.3em .8em;margin:.3em 0;'
            f'max-width:46em"><b style="color:{color}">{self.question} {TITLES[self.finding]}</b>'
            f"<div>{text}</div>{self.picture}{self._pointer()}</div>"
        )

    def _pointer(self) -> str:
        """Say where the failing inputs are, in a notebook."""
        if self.right or self.finding in ("missing", *WAITING):
            return ""
        return (
            '<div style="color:#767676;font-size:90%"><code>case()</code> shows the inputs, your '
            "values and the right ones.</div>"
        )
