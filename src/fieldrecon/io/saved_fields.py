"""Fitted fields in files: the method, its arguments, the sites and the data.

A file is an NPZ archive of plain arrays, no pickles:

- ``header``: JSON in UTF-8 as bytes, an object of ``format`` ("fieldrecon field"), ``version`` (2),
  ``method`` and ``names`` (of the columns of the data, or empty);
- ``points`` (n, d) and ``values`` (n, ...): the sites and the data.

``method`` is an object of ``name`` (the class) and the other arguments of its constructor; a kernel
is an object of ``name`` and its parameters, an array is nested lists, and the methods within
`OnGlobe` and `Mean` are arguments. A loaded field is fitted again. Its values are identical with
the same versions of NumPy and SciPy on the same kind of processor, and equal up to rounding
elsewhere.

In files of version 1, patches whose sites are in special position (on a line or a circle, say) were
fitted with other polynomials, and of equally distant sites the first ones were taken. They are read
with a warning.
"""

from __future__ import annotations

import json
import warnings
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon import barycentric, kernels, methods
from fieldrecon._core.atomic_files import whole_file
from fieldrecon.fields import Field
from fieldrecon.io.archives import write_archive
from fieldrecon.kernels import Radial
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.reconstruction import Reconstruction

FORMAT, VERSION = "fieldrecon field", 2
ADDED = {"metric": None}
"""Arguments that older files lack, with their values in these files."""


_METHODS: Mapping[str, type[Reconstruction]] = {
    name: method
    for name, method in (vars(methods) | vars(barycentric)).items()
    if isinstance(method, type) and issubclass(method, Reconstruction)
}
_KERNELS: Mapping[str, type[Radial]] = {
    name: kernel
    for name, kernel in vars(kernels).items()
    if is_dataclass(kernel) and isinstance(kernel, type) and issubclass(kernel, Radial)
}


def save(path: str | Path, field: Field, names: Sequence[str] = ()) -> None:
    """Write a field to a file, which `load` reads. The file is written completely or not at all.

    Parameters
    ----------
    path : str or pathlib.Path
        Name of the file, usually with the suffix .npz.
    field : Field
        A field of one of the library's methods.
    names : sequence of str
        Names of the coordinates and of the data.

    Raises
    ------
    TypeError
        If method or kernel is not one of the library's.

    Examples
    --------
    >>> import tempfile, fieldrecon as fr
    >>> s = fr.LeastSquares([[0.0], [1.0], [2.0]]).field([1.0, 3.0, 5.0])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save(f"{folder}/line.npz", s)
    ...     again = load(f"{folder}/line.npz")
    >>> bool(again([7.0]) == s([7.0]))
    True
    """
    described = description(field.method)
    header = {"format": FORMAT, "version": VERSION, "method": described, "names": list(names)}
    text = np.frombuffer(json.dumps(header, allow_nan=False, default=_plain).encode(), np.uint8)
    arrays = {"header": text, "points": field.method.points, "values": field.values}
    with whole_file(Path(path)) as temporary:
        write_archive(temporary, arrays)


def load(path: str | Path) -> Field:
    """Read a field that `save` wrote, and fit it again.

    Parameters
    ----------
    path : str or pathlib.Path

    Returns
    -------
    Field
        With the same values: identical with the same NumPy, SciPy and processor, otherwise up to
        rounding.

    Warns
    -----
    UserWarning
        If the field has patches and is of version 1, since they are fitted differently now.

    Raises
    ------
    ValueError
        If the file does not hold a field, or one of a later version: with its path.
    FileNotFoundError
        If there is no such file.
    """
    return load_with_names(path)[0]


def load_with_names(path: str | Path) -> tuple[Field, list[str]]:
    """Read a field as `load` does, and the names that were given to `save`."""
    header, points, values = _content(path)
    if header["version"] == 1 and _has_patches(header.get("method")):
        warnings.warn(
            f"{path} is a field of version 1, and patches are fitted differently now: its values "
            "may differ where sites are few, on lines, planes, circles or lattices, or far from "
            "the others",
            UserWarning,
            stacklevel=3,
        )
    try:
        method = _method(header["method"], points)
        return method.field(values), [str(name) for name in header["names"]]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ValueError(f"{path} holds no field that can be fitted again: {error}") from None


def _content(path: str | Path) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    try:
        with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as stored:
            header = json.loads(bytes(stored["header"]))
            arrays = stored["points"], stored["values"]
    except (ValueError, KeyError, TypeError, EOFError, RecursionError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} is not a file of a field: {error}") from None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise ValueError(f"{path} is not a file of a field: its header does not say {FORMAT!r}")
    if header.get("version") not in (1, VERSION):
        raise ValueError(
            f"{path} is a field of version {header.get('version')}; this program reads versions 1 "
            f"and {VERSION}"
        )
    return header, *arrays


def _has_patches(described: object) -> bool:
    """Whether a described method is, or contains, one on patches."""
    if isinstance(described, list):
        return any(map(_has_patches, described))
    if not isinstance(described, Mapping):
        return False
    patches = described.get("name") == PartitionOfUnityRBF.__name__
    return patches or any(map(_has_patches, described.values()))


def description(method: Reconstruction) -> dict[str, Any]:
    """Name of a method and the arguments it was made with besides the points, as in a file.

    Raises
    ------
    TypeError
        If method or kernel is not one of the library's.
    """
    name = type(method).__name__
    try:
        arguments = method._arguments()
    except TypeError as error:
        raise TypeError(f"a field of {name} cannot be saved: {error}") from None
    if _METHODS.get(name) is not type(method):
        raise TypeError(f"a field of {name} cannot be saved: fieldrecon has no method {name}")
    return {"name": name} | {key: _argument(value) for key, value in arguments.items()}


def _argument(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_argument(one) for one in value]
    if isinstance(value, Reconstruction):
        return description(value)
    if not isinstance(value, Radial):
        return value
    name = type(value).__name__
    if _KERNELS.get(name) is not type(value):
        raise TypeError(f"a field with {name} cannot be saved: fieldrecon.kernels has no {name}")
    return {"name": name} | asdict(value)  # type: ignore[call-overload]


def _plain(numbers: Any) -> Any:
    """A number or an array of NumPy as a number or lists of Python."""
    return numbers.tolist()


def _method(described: Mapping[str, Any], points: np.ndarray) -> Reconstruction:
    given = dict(described)
    method = _known(_METHODS, given.pop("name"))
    wanted = sorted(method._argument_names())
    given = {name: value for name, value in ADDED.items() if name in wanted} | given
    if sorted(given) != wanted:
        raise ValueError(f"{method.__name__} is made with {wanted}; got {sorted(given)}")
    return method._made(points, **{name: _restored(value) for name, value in given.items()})


def _restored(value: Any) -> Any:
    """An argument from its description: an array, a kernel, functions of points, or itself."""
    if isinstance(value, list):
        if value and all(isinstance(one, Mapping) for one in value):
            return [_restored(one) for one in value]
        return np.array(value)
    if not isinstance(value, Mapping):
        return value
    return partial(_method, value) if value.get("name") in _METHODS else _kernel(value)


def _kernel(described: Mapping[str, Any]) -> Radial:
    parameters = dict(described)
    kernel = _known(_KERNELS, parameters.pop("name"))
    wanted = {f.name for f in fields(kernel)}
    if set(parameters) != wanted:
        raise ValueError(f"{kernel.__name__} has {sorted(wanted)}; got {sorted(parameters)}")
    return kernel(**parameters)


def _known(kinds: Mapping[str, Any], name: object) -> Any:
    if not isinstance(name, str) or name not in kinds:
        raise ValueError(f"there is no {name!r}; there are {', '.join(sorted(kinds))}")
    return kinds[name]
