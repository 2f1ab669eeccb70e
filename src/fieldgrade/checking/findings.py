"""What the checks of a question find of an answer, made in order up to the first not passed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fieldcheck.verdict import Verdict


@dataclass(frozen=True)
class Finding:
    """What one check finds of an answer; it can be kept, since it depends on no points.

    Parameters
    ----------
    verdict : Verdict
        How far up the ladder the answer came.
    check : str
        Its name, if the answer did not pass.
    broke : tuple of str
        Why processes had to be ended, in cells or in calls of this check.
    cell_errors : tuple of (int, str)
        The code cells that did not end well.
    returned : tuple of mapping
        The wrong numbers on the public case that shows it best, for a picture.
    """

    verdict: Verdict
    check: str = ""
    broke: tuple[str, ...] = ()
    cell_errors: tuple[tuple[int, str], ...] = ()
    returned: tuple[Mapping[str, Any], ...] = ()


Found = Mapping[str, Mapping[str, Finding]]
"""By question and check, in the order of the checks; the first that is not passed is the last."""


def unknown(checks: Iterable[str], known: Mapping[str, Finding]) -> Iterator[str]:
    """Yield the checks that are to be made: none behind one that is known not to be passed.

    Those behind an unknown one are made in the same run, which costs less than running all cells
    once more when it is passed.
    """
    for check in checks:
        if check not in known:
            yield check
        elif not known[check].verdict.right:
            return


def reached(checks: Iterable[str], found: Mapping[str, Finding]) -> dict[str, Finding]:
    """Return the findings up to the first check that is not passed, wherever they come from."""
    so_far = {}
    for check in checks:
        so_far[check] = found[check]
        if not found[check].verdict.right:
            break
    return so_far
