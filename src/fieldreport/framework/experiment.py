"""The parts of an experiment: parameters, the result of a run, and figures of the result."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, TypeAlias

import numpy as np

from fieldrecon._core.blas_threads import one_blas_thread
from fieldreport.framework.orders_of_magnitude import OrderOfMagnitude, order_of_magnitude

Cell: TypeAlias = int | float | str
Map: TypeAlias = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]

SIGNIFICANT_DIGITS = 9
FACT_DIGITS = 6
"""Significant digits of a fact, unless the ``DIGITS`` of its experiment state another number."""


class ExperimentError(ValueError):
    """A run with parameters for which the experiment cannot give a result."""


USER_ERRORS = (ValueError, ArithmeticError, MemoryError)
"""Errors that other parameters may cause; a LinAlgError is a ValueError."""


def in_checkout(name: str) -> Path:
    """Return the path of a file that is named relative to the root of the checkout.

    Installed from a wheel, the code is not in a checkout; then the current folder is the root.
    """
    root = Path(__file__).parents[3]
    return (root if (root / "pyproject.toml").is_file() else Path()) / name


def round_to_digits(x: Cell, digits: int) -> Cell:
    """Round a float to a number of significant digits; with 0 digits, to its order of magnitude.

    Examples
    --------
    >>> round_to_digits(0.123456789, 3), round_to_digits(0.123456789, 0), round_to_digits(12345, 3)
    (0.123, ~1e-01, 12345)
    """
    if not isinstance(x, float) or isinstance(x, OrderOfMagnitude):
        return x
    return float(f"{x:.{digits}g}") if digits else order_of_magnitude(x)


def _normalized(name: str, x: Any) -> Cell:
    """Return the value that is stored: an int, a text, or a float with nine significant digits."""
    if isinstance(x, str):
        return str(x)
    if isinstance(x, OrderOfMagnitude):
        return x
    if isinstance(x, bool | np.bool_):
        raise ValueError(f"{name} must be a number or a text; got the truth value {x}")
    if isinstance(x, int | np.integer):
        return int(x)
    if isinstance(x, float | np.floating):
        if not math.isfinite(x):
            raise ValueError(f"{name} must be finite; got {x}")
        return float(f"{x:.{SIGNIFICANT_DIGITS}g}")
    raise ValueError(f"{name} must be a number or a text; got {type(x).__name__}")


def cell_from_text(text: str) -> Cell:
    """Read a table's cell: an integer, a decimal number, an order of magnitude or a text."""
    for number in (int, float, OrderOfMagnitude.parse):
        try:
            return number(text)
        except ValueError:
            pass
    return text


@dataclass(frozen=True)
class ResultTable:
    """Named columns and rows of numbers and texts.

    Floats are rounded to nine significant digits: writing and reading do not change a table.

    Parameters
    ----------
    columns : tuple of str
        The heading of each column, with its unit if it has one.
    rows : tuple of tuple
        One cell per column. A text that could be read as a number is refused.

    Examples
    --------
    >>> ResultTable(("n", "error"), ((1, 1 / 3), (2, 0.25))).column("error")
    (0.333333333, 0.25)
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def __post_init__(self) -> None:
        columns = tuple(self.columns)
        rows = tuple(tuple(self._cells(columns, row)) for row in self.rows)
        object.__setattr__(self, "columns", columns)
        object.__setattr__(self, "rows", rows)

    @staticmethod
    def _cells(columns: tuple[str, ...], row: Iterable[Any]) -> Iterable[Cell]:
        row = tuple(row)
        if len(row) != len(columns):
            raise ValueError(f"a row must have {len(columns)} cells, {columns}; got {row}")
        for column, cell in zip(columns, row, strict=True):
            cell = _normalized(f"column {column!r}", cell)
            if isinstance(cell, str) and cell_from_text(cell) != cell:
                raise ValueError(f"column {column!r} holds the text {cell!r}; give the number")
            yield cell

    def column(self, name: str) -> tuple[Cell, ...]:
        """Return the cells under one heading."""
        if name not in self.columns:
            raise ValueError(f"no column {name!r}; the table has {', '.join(self.columns)}")
        k = self.columns.index(name)
        return tuple(row[k] for row in self.rows)


@dataclass(frozen=True, eq=False)
class Result:
    """The result of a run: sufficient to draw every figure and to quote every number.

    Parameters
    ----------
    params : dataclass
        The parameters of the run.
    tables : mapping of str to ResultTable
        Tables by name; each becomes a file of that name.
    facts : mapping of str to int, float or str
        The numbers that the text may quote. Floats are finite, with nine significant digits.
    arrays : mapping of str to ndarray
        Further data of the figures, stored exactly.
    """

    params: Any
    tables: Mapping[str, ResultTable]
    facts: Mapping[str, Cell]
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        facts = {name: _normalized(f"fact {name!r}", x) for name, x in self.facts.items()}
        arrays = {name: _frozen(name, a) for name, a in self.arrays.items()}
        for name, mapping in (("tables", self.tables), ("facts", facts), ("arrays", arrays)):
            object.__setattr__(self, name, MappingProxyType(dict(mapping)))

    def __eq__(self, other: object) -> bool:
        """Equal in every parameter, cell, fact and bit."""
        if not isinstance(other, Result):
            return NotImplemented
        return (
            (self.params, self.tables, self.facts) == (other.params, other.tables, other.facts)
            and self.arrays.keys() == other.arrays.keys()
            and all(_same_array(a, other.arrays[name]) for name, a in self.arrays.items())
        )

    __hash__ = None  # type: ignore[assignment]


def _shown(x: Any) -> str:
    return ",".join(map(str, x)) if isinstance(x, tuple) else str(x)


def _same_array(a: np.ndarray, b: np.ndarray) -> bool:
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def _frozen(name: str, a: Any) -> np.ndarray:
    a = np.array(a, order="C")
    if a.dtype.hasobject:
        raise ValueError(f"array {name!r} must hold numbers or texts; got objects")
    a.flags.writeable = False
    return a


@dataclass(frozen=True)
class Experiment:
    """One experiment: a module with ``Params``, ``QUICK``, ``run`` and ``plot``.

    Parameters
    ----------
    name : str
        The name of the module and of the folder to which a run is written.
    module : module
        Its docstring's first line is the title of the experiment.
    """

    name: str
    module: ModuleType = field(repr=False)

    @property
    def title(self) -> str:
        """The first line of the module's docstring, without its full stop."""
        return (self.module.__doc__ or self.name).strip().splitlines()[0].rstrip(".")

    @property
    def description(self) -> str:
        """The module's docstring after its first line."""
        return (self.module.__doc__ or "").strip().partition("\n")[2].strip()

    @property
    def defaults(self) -> Any:
        """The parameters of the report."""
        return self.module.Params()

    @property
    def quick(self) -> Any:
        """A small variant of the parameters, for tests."""
        return self.module.QUICK

    @property
    def meanings(self) -> dict[str, str]:
        """The meaning of each parameter, by its name."""
        return {f.name: f.metadata.get("meaning", "") for f in fields(self.module.Params)}

    @property
    def domains(self) -> dict[str, str]:
        """The domain of each parameter in words, by its name; that of a file is empty."""
        return {f.name: str(f.metadata.get("domain", "")) for f in fields(self.module.Params)}

    def digits(self, fact: str) -> int:
        """The number of digits of a fact in which all machines agree.

        The module's ``DIGITS`` names the facts with fewer than six; 0 is an order of magnitude.
        Another machine may differ by one unit in the last digit.
        """
        stated: Mapping[str, int] = getattr(self.module, "DIGITS", {})
        return stated.get(fact, FACT_DIGITS)

    def inputs(self, params: Any) -> dict[str, Path]:
        """The input files, by the name of the parameter that names them."""
        named = [f.name for f in fields(params) if f.metadata.get("file")]
        return {name: in_checkout(getattr(params, name)) for name in named}

    @cached_property
    def plots(self) -> Mapping[str, Callable[[Result], Any]]:
        """The plotting functions, by the name of the figure.

        ``plot`` draws the figure NAME, and ``plot_SOMETHING`` the figure NAME_SOMETHING.
        """
        return MappingProxyType(
            {
                self.name + name.removeprefix("plot"): function
                for name, function in vars(self.module).items()
                if (name == "plot" or name.startswith("plot_")) and callable(function)
            }
        )

    def run(self, params: Any = None, each: Map = map) -> Result:
        """Run the experiment with BLAS on one thread: no digit depends on the number of cores.

        Parameters
        ----------
        params : Params, optional
            The defaults if not given.
        each : callable
            An order-preserving map, which calls the independent parts of the run.

        Raises
        ------
        ExperimentError
            If the run fails with parameters that differ from the defaults, which it names.
        """
        params = self.defaults if params is None else params
        try:
            with one_blas_thread():
                found = self.module.run(params, each)
        except USER_ERRORS as error:
            if params == self.defaults:
                raise  # an error of the program, shown with its traceback
            raise ExperimentError(self._refusal(params, error)) from error
        facts = {name: round_to_digits(x, self.digits(name)) for name, x in found.facts.items()}
        return replace(found, facts=facts)

    def _refusal(self, params: Any, error: Exception) -> str:
        """Return a sentence with the experiment, the changed parameters, and the error."""
        usual, given = asdict(self.defaults), asdict(params)
        changed = [f"{name} = {_shown(x)}" for name, x in given.items() if x != usual[name]]
        reason = str(error) or type(error).__name__
        return f"experiment {self.name} fails with {', '.join(changed)}: {reason}"
