"""A field at targets as a data frame of pandas, or as a data set of xarray."""

from __future__ import annotations

from typing import Any

from fieldrecon._core.extras import optional
from fieldrecon.io.cf import CONVENTIONS, cf_variables
from fieldrecon.io.targets import TargetValues


def to_dataframe(result: TargetValues, coordinates: bool = True) -> Any:
    """Return a `pandas.DataFrame` with a row for each target.

    Parameters
    ----------
    result : TargetValues
    coordinates : bool
        Whether its first columns are the coordinates.

    Returns
    -------
    pandas.DataFrame
        With the names of the samples, and the index of the data frame of the targets if they came
        from one. Rows of the targets that are not points are NaN.

    Raises
    ------
    ModuleNotFoundError
        If pandas is not installed: with the extra that provides it.
    """
    pandas = optional("pandas")
    first = 0 if coordinates else result.d
    columns = dict([*result.rows.items()][first:])
    return pandas.DataFrame(columns, index=result.targets.index)


def to_xarray(result: TargetValues) -> Any:
    """Return an `xarray.Dataset`: over the axes of a grid, or over the dimension "point".

    Names are those of the samples without units, which are attributes, as in the NetCDF files.

    Raises
    ------
    ModuleNotFoundError
        If xarray is not installed: with the extra that provides it.
    """
    xarray = optional("xarray")
    variables = cf_variables(result)
    made = {v.name: xarray.Variable(v.dimensions, v.data, dict(v.attributes)) for v in variables}
    return xarray.Dataset(
        {v.name: made[v.name] for v in variables if v.role == "data"},
        {v.name: made[v.name] for v in variables if v.role != "data"},
        {"Conventions": CONVENTIONS},
    )
