"""Tables in memory: data frames, data sets of xarray, named arrays, and arrays of points.

They are recognized by their attributes, so that neither pandas nor xarray has to be installed: who
has such an object has the package. A frame gives columns by name, with their units, and is read as
a file is: rows without a number are skipped and reported, by their position from 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon.io.column_names import AXES
from fieldrecon.io.number_formats import parse_number
from fieldrecon.io.tables import BadRow, ColumnSpec, Table, read_table


@dataclass(frozen=True, eq=False)
class Frame:
    """Columns in memory.

    Parameters
    ----------
    title : str
        What it is, for messages: "the data frame".
    names : list of str
        Names of the columns that may hold numbers.
    read : callable
        Takes names of columns to arrays (n,) of equal length.
    units : mapping of str to str
        Units of columns, where they are known.
    only_value : str, optional
        The only column that is no coordinate, if the frame tells coordinates from data.
    index : object, optional
        Labels of the rows, which a data frame of results keeps.
    crs : object, optional
        The coordinate reference system, as `fieldrecon.io.crs.grid_mapping` takes it.
    axes : mapping of str to ndarray
        Coordinates that are axes of a grid.
    """

    title: str
    names: list[str]
    read: Callable[[Sequence[str]], list[np.ndarray]]
    units: Mapping[str, str] = field(default_factory=dict)
    only_value: str | None = None
    index: Any = None
    crs: Any = None
    axes: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.title

    @property
    def name(self) -> str:
        """What it is, without an article."""
        return self.title.removeprefix("the ")


Source: TypeAlias = "Path | Frame"
"""A table: in a file, or in memory."""


def as_source(data: Any) -> Source:
    """A path as it is; a table in memory, or an array of points (n, d), as a frame.

    Raises
    ------
    TypeError
        If it is nothing of these.
    """
    if isinstance(data, str | Path):
        return Path(data)
    for kind, read in _KINDS:
        if kind(data):
            return read(data)
    raise TypeError(
        "data must be a path, a data frame, an xarray object, a mapping of names to arrays, or an "
        f"array of points (n, d); got {type(data).__name__}"
    )


def is_table(data: Any) -> bool:
    """Whether it is a path or has named columns, and is not only an array."""
    return isinstance(data, str | Path) or any(kind(data) for kind, _ in _KINDS[:-1])


def is_labelled(data: Any) -> bool:
    """Whether it is an array or a data set of xarray."""
    return _is_array_of_xarray(data) or _is_set_of_xarray(data)


Names: TypeAlias = dict[str, Any]
"""Names of x, y, z, the value (or the values) and its sigma in a table, where they are given."""


def as_table(
    data: Any, x: Any, y: Any, value: Any, z: Any, sigma: Any = None
) -> tuple[Source, Names]:
    """A table, and the names in it of x, y, z, the value and its sigma, from what a user gives.

    Raises
    ------
    ValueError
        If arrays and names are mixed, or too few are given.
    TypeError
        If the data are of no known kind.
    """
    given = {"x": x, "y": y, "z": z, "value": value, "sigma": sigma}
    arrays = {role: a for role, a in given.items() if a is not None and not _is_name(a, role)}
    if data is None:
        return _table_of_arrays(arrays)
    if _is_array(data) and not is_table(data):
        return _table_of_points(data, arrays)
    source = as_source(data)
    if arrays:
        role = next(iter(arrays))
        raise ValueError(f"{role} must be the name of a column of data; got an array")
    return source, given


def _is_name(given: Any, role: str) -> bool:
    """Whether it is the name of a column, or of the values the names of several."""
    if role == "value" and isinstance(given, list | tuple) and given:
        return all(isinstance(name, str) for name in given)
    return isinstance(given, str)


def _table_of_arrays(arrays: Mapping[str, Any]) -> tuple[Frame, Names]:
    if not {"x", "y", "value"} <= {*arrays}:
        raise ValueError("give samples: data, or arrays x, y and value, or load with a field")
    _require_one_index(arrays)
    own = {role: _own_name(array, role) for role, array in arrays.items()}
    names = own if len({*own.values()}) == len(own) else {role: role for role in arrays}
    values, value = _columns_of_values(arrays["value"], names["value"])
    others = {names[role]: array for role, array in arrays.items() if role != "value"}
    frame = frame_of_mapping(others | values, "the arrays")
    return frame, {role: names.get(role) for role in ("x", "y", "z", "sigma")} | {"value": value}


def _table_of_points(points: Any, arrays: Mapping[str, Any]) -> tuple[Frame, Names]:
    if {*arrays} - {"sigma"} != {"value"}:
        raise ValueError("with data as an array of points (n, d), give the array value (n,)")
    _require_one_index(arrays)
    name = _own_name(arrays["value"], "value")
    name = "value" if name in (*AXES, "sigma") else name
    values, value = _columns_of_values(arrays["value"], name)
    frame = frame_of_points(
        points, **values, **{role: arrays[role] for role in arrays if role == "sigma"}
    )
    in_space = "z" if "z" in frame.names else None
    sigma = "sigma" if "sigma" in arrays else None
    return frame, {"x": "x", "y": "y", "z": in_space, "value": value, "sigma": sigma}


def _columns_of_values(array: Any, name: str) -> tuple[dict[str, Any], str | list[str]]:
    """An array (n,) under the name, or the columns of an array (n, k) under numbered ones."""
    if np.ndim(array) != 2:
        return {name: array}, name
    columns = array if np.ma.isMaskedArray(array) else np.asarray(array)
    named = {f"{name}_{k}": column for k, column in enumerate(columns.T, 1)}
    return named, [*named]


def _require_one_index(arrays: Mapping[str, Any]) -> None:
    """Refuse columns of data frames whose rows have other labels, or the same in another order."""
    indices = {role: getattr(array, "index", None) for role, array in arrays.items()}
    labelled = [(role, index) for role, index in indices.items() if hasattr(index, "equals")]
    for role, index in labelled[1:]:
        first, labels = labelled[0]
        if not labels.equals(index):  # type: ignore[union-attr]
            raise ValueError(
                f"{first} and {role} have different indices, so their rows do not belong together "
                "in this order; align them, or give arrays without an index"
            )


def _own_name(array: Any, role: str) -> str:
    """The name that an array has, as a column of a data frame does, else its role."""
    name = getattr(array, "name", None)
    return name if isinstance(name, str) else role


def read_source(source: Source, spec: ColumnSpec, progress: Progress | None = None) -> Table:
    """Read columns of a table in a file or in memory, as `fieldrecon.io.tables.read_table`."""
    if isinstance(source, Path):
        return read_table(source, spec, progress)
    names = [source.names[k] for k in spec.choose(source.names)]
    columns = source.read(names)
    if of_complex := [n for n, c in zip(names, columns, strict=True) if c.dtype.kind == "c"]:
        raise ValueError(
            f"{source}: {of_complex[0]} is complex; give its real and its imaginary part as two "
            "values"
        )
    lengths = {len(column) for column in columns}
    if len(lengths) > 1:
        sizes = ", ".join(f"{name} {len(c)}" for name, c in zip(names, columns, strict=True))
        raise ValueError(f"{source}: the columns must be equally long; got {sizes}")
    if lengths == {0}:
        raise ValueError(f"{source} has no rows")
    numbers = np.column_stack([_numbers(column) for column in columns])
    good = spec.valid_rows(numbers)
    bad = [
        BadRow(int(row), spec.error(names, [column[row] for column in columns]), int(row))
        for row in np.flatnonzero(~good)
    ]
    return Table(names, numbers[good], bad)


def bad_row_message(source: Source, row: BadRow) -> str:
    """Return the sentence about a bad row of a table: lines of a file, positions in memory."""
    return f"{source}, {numbered(source)} {row.line}: {row.reason}"


def numbered(source: Source) -> str:
    """What the number of a row of a table is."""
    return "line" if isinstance(source, Path) else "row"


def frame_of_points(points: Any, **columns: Any) -> Frame:
    """Points (n, d), d at most 3, as columns x, y and z, beside further columns."""
    points = np.ma.asanyarray(points) if np.ma.isMaskedArray(points) else np.asarray(points)
    if points.ndim != 2 or not 2 <= points.shape[1] <= len(AXES):
        raise ValueError(
            f"points must have the shape (n, 2) or (n, 3); got {points.shape}: give the arrays of "
            "coordinates and values by x, y and value, or points and value"
        )
    named = dict(zip(AXES, points.T, strict=False))
    return frame_of_mapping(named | columns, "the arrays")


def frame_of_mapping(columns: Mapping[str, Any], title: str = "the mapping") -> Frame:
    """Named arrays (n,), such as a dictionary or an open ``.npz`` file."""

    def read(names: Sequence[str]) -> list[np.ndarray]:
        return [_one_dimensional(columns[name], name) for name in names]

    return Frame(title, [str(name) for name in columns], read)


# --- kinds of tables ------------------------------------------------------------------------------


def _is_array_of_xarray(data: Any) -> bool:
    return hasattr(data, "to_dataset") and hasattr(data, "coords")


def _is_set_of_xarray(data: Any) -> bool:
    return hasattr(data, "data_vars") and hasattr(data, "to_dataframe")


def _is_frame(data: Any) -> bool:
    return hasattr(data, "columns") and hasattr(data, "__getitem__")


def _is_structured(data: Any) -> bool:
    return getattr(getattr(data, "dtype", None), "names", None) is not None


def _is_mapping(data: Any) -> bool:
    return isinstance(data, Mapping)


def _is_array(data: Any) -> bool:
    return isinstance(data, np.ndarray | list | tuple) or hasattr(data, "__array__")


def _frame_of_data_array(data: Any) -> Frame:
    return _frame_of_data_set(data.to_dataset(name=data.name or "value"))


def _frame_of_data_set(data: Any) -> Frame:
    """Variables of a data set, in a row for each combination of their dimensions."""
    variables = {
        str(name): data[name]
        for name in (*data.coords, *data.data_vars)
        if data[name].ndim and data[name].dtype.kind in "biufO"
    }
    values = [str(name) for name in data.data_vars if str(name) in variables]
    return Frame(
        "the data set",
        [*variables],
        partial(_columns_of_data_set, data),
        {name: str(v.attrs["units"]) for name, v in variables.items() if "units" in v.attrs},
        only_value=values[0] if len(values) == 1 else None,
        crs=_crs_of_data_set(data),
        axes={name: np.asarray(v) for name, v in variables.items() if v.dims == (name,)},
    )


def _columns_of_data_set(data: Any, names: Sequence[str]) -> list[np.ndarray]:
    coordinates = [name for name in names if name in data.coords] or names[:-1]
    along = {dimension for name in coordinates for dimension in data[name].dims}
    beside = [dimension for dimension in data[names[-1]].dims if dimension not in along]
    if beside and names[-1] not in data.dims:
        raise ValueError(
            f"{names[-1]} has the dimension {beside[0]!r} beside those of the coordinates: choose "
            f"one, such as data.isel({beside[0]}=0)"
        )
    rows = data.reset_coords()[[*names]].to_dataframe().reset_index()
    return [rows[name].to_numpy() for name in names]


def _crs_of_data_set(data: Any) -> Mapping[str, Any] | None:
    """Attributes of the grid mapping that a variable names, by the CF conventions."""
    named = (
        v.attrs.get("grid_mapping", v.encoding.get("grid_mapping")) for v in data.data_vars.values()
    )
    name = next((name for name in named if name in data.variables), None)
    return None if name is None else dict(data[name].attrs)


def _frame_of_frame(data: Any) -> Frame:
    """A data frame of pandas or polars, or a table of pyarrow."""
    labels = getattr(data, "column_names", None) or data.columns
    by_name = {str(label): label for label in labels}

    def read(names: Sequence[str]) -> list[np.ndarray]:
        return [_one_dimensional(data[by_name[name]], name) for name in names]

    return Frame("the data frame", [*by_name], read, index=getattr(data, "index", None))


def _frame_of_structured(data: Any) -> Frame:
    return frame_of_mapping({name: data[name] for name in data.dtype.names}, "the array")


_KINDS: tuple[tuple[Callable[[Any], bool], Callable[[Any], Frame]], ...] = (
    (_is_array_of_xarray, _frame_of_data_array),
    (_is_set_of_xarray, _frame_of_data_set),
    (_is_frame, _frame_of_frame),
    (_is_structured, _frame_of_structured),
    (_is_mapping, frame_of_mapping),
    (_is_array, frame_of_points),
)
"""How a table is recognized, and read; the first that fits counts."""


# --- numbers --------------------------------------------------------------------------------------


def _one_dimensional(column: Any, name: str) -> np.ndarray:
    """A column as an array (n,); entries behind a mask are not numbers."""
    if np.ma.isMaskedArray(column):
        column = np.ma.filled(column.astype(float), np.nan)
    array = np.asarray(column)
    if array.ndim != 1:
        raise ValueError(f"{name} must be one number for each row, shape (n,); got {array.shape}")
    return array


def _numbers(column: np.ndarray) -> np.ndarray:
    """The column as floating-point numbers, NaN for other entries."""
    if column.dtype.kind in "biuf":
        return column.astype(float)
    return np.array([parse_number(cell) for cell in column])
