"""Parameters of experiments: declared with their domains, and read from text."""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

from fieldreport.framework.names import no_such

ORDERS = {"increasing": False, "decreasing": True}
"""Whether a list in that order is sorted in reverse."""

_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a finite number",
    str: "a text",
}


@dataclass(frozen=True, kw_only=True)
class Domain:
    """The valid values of a parameter; for a list, of its entries, and its valid lengths.

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
        and stored in this order, so that the finest mesh is where ``run`` expects it.
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
            The message names the parameter, the requirement and the value.
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
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        if self.least is not None and self.most is not None:
            return f"between {self.least:g} and {self.most:g}"
        bounds = (
            ("{:g} or more", self.least),
            ("more than {:g}", self.above),
            ("{:g} or less", self.most),
            ("less than {:g}", self.below),
        )
        words = [text.format(bound) for text, bound in bounds if bound is not None]
        return " and ".join(words) or "a finite number"

    def __str__(self) -> str:
        """The domain of the entries, and the length of a list."""
        length = f"; {self.entries} values" if self.entries else ""
        return self.wanted + (f"; {self.fewest} values or more" if self.order else length)

    @property
    def _reason(self) -> str:
        return f" ({self.because})" if self.because else ""


def parameter(default: Any, meaning: str, **domain: Any) -> Any:
    """Declare a field of ``Params``: its default, its meaning with its unit, and its ``Domain``.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Params(Parameters):
    ...     points: int = parameter(100, "number of sample points", least=3)
    >>> Params().points
    100
    >>> Params(points=2)
    Traceback (most recent call last):
    ...
    ValueError: parameter points must be 3 or more; got 2
    """
    return field(default=default, metadata={"meaning": meaning, "domain": Domain(**domain)})


def input_file(default: str, meaning: str) -> Any:
    """Declare a field that names a file of the checkout; the content of the file is a parameter."""
    return field(default=default, metadata={"meaning": meaning, "file": True})


@dataclass(frozen=True)
class Parameters:
    """The parameters of an experiment, each in its domain.

    A relation between parameters is checked by a ``__post_init__`` that calls this one first.
    """

    def __post_init__(self) -> None:
        for f in fields(self):
            stored = f.metadata.get("domain", Domain()).checked(f.name, getattr(self, f.name))
            object.__setattr__(self, f.name, stored)


def require(condition: bool, name: str, wanted: str, got: Any) -> None:
    """Refuse parameters that contradict each other.

    Raises
    ------
    ValueError
        In the wording of ``Domain``, if the condition does not hold.

    Examples
    --------
    >>> require(False, "largest", "10 times smallest or more", 0.1)
    Traceback (most recent call last):
    ...
    ValueError: parameter largest must be 10 times smallest or more; got 0.1
    """
    if not condition:
        shown = f"{got:g}" if isinstance(got, float) else got
        raise ValueError(f"parameter {name} must be {wanted}; got {shown}")


def replace_parameters(params: Any, settings: Mapping[str, Any]) -> Any:
    """Return the parameters with some fields replaced; values are checked against declared types.

    Parameters
    ----------
    params : dataclass
        Fields are of type int, float, bool, str, or ``tuple[T, ...]`` of one of those.
    settings : mapping of str
        New values by field: a text from the command line (``"0.1"``; a tuple is a list with commas,
        ``"1,2,4"``), or a value of the declared type from a settings file.

    Raises
    ------
    ValueError
        If a field does not exist, or a value has another type or lies outside its domain.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Params:
    ...     powers: tuple[int, ...] = (1, 2)
    ...     epsilon: float = 1.0
    >>> replace_parameters(Params(), {"powers": "1,3", "epsilon": 2})
    Params(powers=(1, 3), epsilon=2.0)
    """
    types = typing.get_type_hints(type(params))
    known = [f.name for f in fields(params)]
    for name in settings:
        if name not in known:
            raise ValueError(f"there is {no_such('parameter', name, known)}")
    return replace(params, **{name: _of(name, types[name], x) for name, x in settings.items()})


def _of(name: str, kind: Any, x: Any) -> Any:
    if typing.get_origin(kind) is tuple:
        return _tuple_of(name, typing.get_args(kind)[0], x)
    value = _read(kind, x) if isinstance(x, str) else _as(kind, x)
    if value is None:
        raise ValueError(f"parameter {name} must be {_WORDS[kind]}; got {x!r}")
    return value


def _tuple_of(name: str, kind: Any, x: Any) -> tuple:
    items = [item.strip() for item in x.split(",")] if isinstance(x, str) else x
    if not isinstance(items, list | tuple) or not items or "" in items:
        raise ValueError(f"parameter {name} must be a list such as 1,2,4; got {x!r}")
    return tuple(_of(name, kind, item) for item in items)


def _read(kind: type, text: str) -> Any:
    """Return the value that a text represents, or None."""
    if kind is str:
        return text
    if kind is bool:
        return {"true": True, "false": False}.get(text.lower())
    try:
        return _as(kind, kind(text))
    except ValueError:
        return None


def _as(kind: type, x: Any) -> Any:
    """Return the value as that type, or None; an integer is accepted as a float, a bool is not."""
    if kind is float and isinstance(x, int | float) and not isinstance(x, bool):
        return float(x) if math.isfinite(x) else None
    return x if type(x) is kind else None
