"""Reconstruct a field from scattered samples.

Sites first, data second, then call: ``RBF(points, thin_plate_spline()).field(values)(x)``.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fieldrecon._public import *  # noqa: F403


def __getattr__(name: str) -> Any:
    """Import all public names when the first is used, so that the command line starts at once.

    A module is imported by itself. No module has the name of a public function, since its import
    would put it in the place of that function.
    """
    if name == "__version__":
        return version(__name__)
    if find_spec(f"{__name__}.{name}"):
        return import_module(f"{__name__}.{name}")
    public = import_module(f"{__name__}._public")
    globals().update({key: getattr(public, key) for key in ("__all__", *public.__all__)})
    if name not in globals():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *__getattr__("__all__")})
