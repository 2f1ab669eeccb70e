"""Reconstruct a field from scattered samples.

Construct a method from the points, fit the values, evaluate: ``RBF(points,
thin_plate_spline()).field(values)(x)``. The methods are at the top of the package; what else
there is stands in namespaces by topic: ``kernels``, ``methods``, ``barycentric``, ``meshes``,
``velocity``, ``triangles``, ``solids``, ``surfaces``, ``coupling``, ``advection``, ``selection``,
``io``, ``datasets`` and ``pipelines``.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fieldrecon import advection as advection
    from fieldrecon import barycentric as barycentric
    from fieldrecon import coupling as coupling
    from fieldrecon import datasets as datasets
    from fieldrecon import io as io
    from fieldrecon import kernels as kernels
    from fieldrecon import meshes as meshes
    from fieldrecon import methods as methods
    from fieldrecon import pipelines as pipelines
    from fieldrecon import selection as selection
    from fieldrecon import solids as solids
    from fieldrecon import surfaces as surfaces
    from fieldrecon import triangles as triangles
    from fieldrecon import velocity as velocity
    from fieldrecon._public import *  # noqa: F403


def __getattr__(name: str) -> Any:
    """Import all names of the top when the first is used, so that the command line starts at once.

    A namespace is imported by itself. No module has the name of a public function, since its import
    would put it in the place of that function.
    """
    if name == "__version__":
        return version(__name__)
    if find_spec(f"{__name__}.{name}"):
        return import_module(f"{__name__}.{name}")
    public = import_module(f"{__name__}._public")
    globals().update({key: getattr(public, key) for key in ("__all__", *public.__all__)})
    if name in globals():
        return globals()[name]
    old = import_module(f"{__name__}._deprecated")
    if name in old.MOVED:
        return old.moved(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__getattr__("__all__")})
