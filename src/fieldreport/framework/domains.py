"""Domains of parameters: declared with the field, checked in one place, in one wording."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

ORDERS = {"increasing": False, "decreasing": True}
"""Whether a list in that order is sorted in reverse."""


@dataclass(frozen=True, kw_only=True)
class Domain:
    """The values for which a parameter makes sense; of a list, those of its entries and its length.

    Parameters
    ----------
    least, most : float, optional
        Bounds that belong to the domain.
    above, below : float, optional
        Bounds that do not belong to it.
    choices : tuple of str
        The texts that are accepted, if only some are.
    entries : int, optional
        The exact number of entries of a list.
    fewest : int
        The smallest number of entries of a list; an order of convergence needs two sizes.
    order : {"increasing", "decreasing"}, optional
        A list with an order is a set of values. It is accepted in any order, without repetitions,
        and stored in this one, so that the finest mesh is where ``run`` expects it.
    because : str
        The reason of a bound that is not evident.

    Examples
    --------
    >>> Domain(least=4).checked("side", 5)
    5
    >>> Domain(above=0, order="decreasing").checked("spacings", (0.1, 0.4, 0.2))
    (0.4, 0.2, 0.1)
    >>> Domain(least=0, below=1).checked("jitter", 1.5)
    Traceback (most recent call last):
    ...
    ValueError: parameter jitter must be 0 or more and less than 1; got 1.5
    """

    least: float | None = None
    most: float | None = None
    above: float | None = None
    below: float | None = None
    choices: tuple[str, ...] = ()
    entries: int | None = None
    fewest: int = 1
    order: Literal["increasing", "decreasing"] | None = None
    because: str = ""

    def checked(self, name: str, value: Any) -> Any:
        """Return the value as it is stored.

        Raises
        ------
        ValueError
            Naming the parameter, what is wanted and what came.
        """
        if not isinstance(value, tuple):
            return self._one(name, value)
        for x in value:
            self._one(name, x)
        if len(value) != (self.entries or len(value)):
            raise ValueError(f"parameter {name} must hold {self.entries} values; got {len(value)}")
        if self.order is None:
            return value
        if len(set(value)) < len(value):
            twice = next(x for x in value if value.count(x) > 1)
            raise ValueError(f"parameter {name} must hold different values; got {twice} twice")
        if len(value) < self.fewest:
            raise ValueError(
                f"parameter {name} must hold {self.fewest} different values or more"
                f"{self._reason}; got {', '.join(map(str, value))}"
            )
        return tuple(sorted(value, reverse=ORDERS[self.order]))

    def _one(self, name: str, x: Any) -> Any:
        if not self.holds(x):
            shown = repr(x) if isinstance(x, str) else f"{x:g}"
            raise ValueError(f"parameter {name} must be {self.wanted}{self._reason}; got {shown}")
        return x

    def holds(self, x: Any) -> bool:
        """Whether a value, or an entry of a list, lies in the domain."""
        if isinstance(x, str | bool):
            return not self.choices or x in self.choices
        return math.isfinite(x) and (
            (self.least is None or x >= self.least)
            and (self.most is None or x <= self.most)
            and (self.above is None or x > self.above)
            and (self.below is None or x < self.below)
        )

    @property
    def wanted(self) -> str:
        """The domain in words."""
        bounds = (
            ("{:g} or more", self.least),
            ("more than {:g}", self.above),
            ("{:g} or less", self.most),
            ("less than {:g}", self.below),
        )
        words = [text.format(bound) for text, bound in bounds if bound is not None]
        return " and ".join(words) or ", ".join(self.choices) or "a finite number"

    @property
    def _reason(self) -> str:
        return f" ({self.because})" if self.because else ""
