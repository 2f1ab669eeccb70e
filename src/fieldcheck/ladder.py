"""The ladder of verdicts: what a check looks for, in this order, and what each rung is worth."""

from __future__ import annotations

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
