"""Numbers without a reliable digit: powers of ten that no format prints with digits."""

from __future__ import annotations

import math
import re
from typing import Any


class OrderOfMagnitude(float):
    """A power of ten that stands for a number without a reliable digit.

    It computes as a float. In files it is written ``~1e-16``, so that reading restores the type.

    Raises
    ------
    ValueError
        From a format that would print digits, such as ``.1e``.

    Examples
    --------
    >>> x = OrderOfMagnitude(0.01)
    >>> x, f"{x:.0e}", 10 * x
    (~1e-02, '1e-02', 0.1)
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return f"~{self:.0e}"

    __str__ = __repr__

    def __format__(self, spec: str) -> str:
        if spec not in ("", "e", "g", ".0e"):
            raise ValueError(f"an order of magnitude has no digits: format .0e, not {spec}")
        return format(float(self), ".0e")

    @classmethod
    def parse(cls, text: str) -> OrderOfMagnitude:
        """Read ``~1e-16``."""
        if not re.fullmatch(r"~1e[+-]\d+", text):
            raise ValueError(f"an order of magnitude is written ~1e-16; got {text!r}")
        return cls(text[1:])


def order_of_magnitude(x: float) -> float:
    """Return the power of ten nearest to ``|x|`` on a logarithmic scale; zero stays zero.

    A value with fewer than three reliable digits, such as a rounding error, is reported in this
    form.

    Examples
    --------
    >>> order_of_magnitude(2.2e-16), order_of_magnitude(-250.0), order_of_magnitude(0.0)
    (~1e-16, ~1e+02, 0.0)
    """
    return OrderOfMagnitude(f"1e{round(math.log10(abs(x)))}") if x else 0.0


def floored(x: float, level: float) -> float:
    """Return x, or the order of magnitude ``level`` if x is not above it: a rounding error.

    Examples
    --------
    >>> floored(0.02, 1e-12), floored(3e-15, 1e-12)
    (0.02, ~1e-12)
    """
    return float(x) if x > level else OrderOfMagnitude(level)


def mark_orders(x: Any) -> Any:
    """Write each order of magnitude as the text ``~1e-16``, which JSON does not confuse."""
    if isinstance(x, dict):
        return {key: mark_orders(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [mark_orders(value) for value in x]
    return str(x) if isinstance(x, OrderOfMagnitude) else x
