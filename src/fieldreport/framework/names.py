"""Names that do not exist: the nearest one that does."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

SIMILAR = 0.7
"""Smallest similarity of a name that is suggested; 1 is the same."""


def no_such(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the message for an unknown name: the nearest known one, or all of them.

    Capitals and hyphens do not count.

    Examples
    --------
    >>> no_such("parameter", "pionts", ["points", "powers"])
    "no parameter 'pionts'; did you mean points?"
    >>> no_such("parameter", "n", ["points", "powers"])
    "no parameter 'n'; there are points, powers"
    """
    known = list(known)
    by_fold = {_folded(k): k for k in known}
    near = get_close_matches(_folded(name), by_fold, n=1, cutoff=SIMILAR)
    rest = f"did you mean {by_fold[near[0]]}?" if near else f"there are {', '.join(known)}"
    return f"no {kind} {name!r}; {rest}"


def _folded(name: str) -> str:
    return name.casefold().replace("-", "_")
