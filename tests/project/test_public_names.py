"""Public names of the package: resolved on first use, and not imported earlier."""

import inspect
import re
import subprocess
import sys
import warnings
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

import pytest

import fieldrecon
from fieldrecon import _deprecated, _public


def test_the_package_resolves_and_lists_its_public_names():
    """Each name gives the object that its module defines, and ``dir`` lists it."""
    assert fieldrecon.__all__ == _public.__all__
    assert set(dir(fieldrecon)) >= set(_public.__all__)
    for name in _public.__all__:
        assert getattr(fieldrecon, name) is getattr(_public, name), name


NAMESPACES = tuple(
    import_module(f"fieldrecon.{room}")
    for room in (
        *("advection", "barycentric", "coupling", "datasets", "io", "kernels", "meshes", "methods"),
        *("pipelines", "selection", "solids", "surfaces", "triangles", "velocity"),
    )
)


@pytest.mark.parametrize("package", [fieldrecon, *NAMESPACES], ids=lambda p: p.__name__)
def test_no_module_has_the_name_of_a_public_object(package):
    """Importing such a module would replace the object by the module."""
    objects = [n for n in package.__all__ if not isinstance(getattr(package, n), ModuleType)]
    assert objects
    assert [name for name in objects if find_spec(f"{package.__name__}.{name}")] == []
    assert find_spec("fieldrecon.methods.globe"), "else the line above finds nothing"


def test_each_public_name_is_also_in_exactly_one_room():
    for name in _public.__all__:
        rooms = [room for room in NAMESPACES if name in room.__all__]
        if name not in ("Field", "Reconstruction"):
            assert [getattr(room, name) for room in rooms] == [getattr(fieldrecon, name)], name


def test_public_names_do_not_warn():
    """Warnings are errors in this test."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in CONTRACT:
            getattr(fieldrecon, name)


CONTRACT = [
    "Reconstruction",
    "Field",
    "LeastSquares",
    "MovingLeastSquares",
    "RBF",
    "PartitionOfUnityRBF",
    "inverse_square",
    "thin_plate_spline",
    "polyharmonic",
    "gaussian",
    "multiquadric",
    "inverse_multiquadric",
    "matern",
    "wendland",
    "BarycentricCoordinates",
    "VoronoiCell",
    "voronoi_weights",
    "SimplexMesh",
    "normal_velocities",
    "divergence",
    "vertex_velocities",
    "cell_velocities",
    "vertex_velocities_from_cells",
    "vertex_gradients",
    "velocity_weights",
    "estimate_normals",
    "orient_normals",
    "off_surface_points",
    "implicit_surface",
    "extract_surface",
    "union",
    "intersection",
    "difference",
    "blend",
    "Coupling",
    "departure_points",
    "semi_lagrangian",
    "NaturalCubicSpline",
    "audit_mesh",
    "MeshAudit",
    "repair_mesh",
    "leave_one_out",
    "save",
    "load",
]


@pytest.mark.parametrize("name", sorted(_deprecated.MOVED))
def test_a_deprecated_name_warns_and_gives_the_new_object(name):
    """The warning, which names the new location, stays throughout version 0.2."""
    new = _deprecated.MOVED[name]
    room, _, attribute = new.rpartition(".")
    with pytest.warns(DeprecationWarning, match=f"fieldrecon.{name} is now {re.escape(new)}"):
        found = getattr(fieldrecon, name)
    assert found is getattr(import_module(room), attribute)


def returned_types(function):
    """The classes of this library in the return annotation of a function."""
    words = re.findall(r"[\w.]+", str(inspect.signature(function).return_annotation))
    module = inspect.getmodule(function)
    found = [getattr(module, word.rpartition(".")[2], None) for word in words]
    return [x for x in found if inspect.isclass(x) and x.__module__.startswith("fieldrecon.")]


@pytest.mark.parametrize("room", NAMESPACES, ids=lambda p: p.__name__)
def test_every_returned_type_is_a_public_name(room):
    """Each type is public in a room or at the top level."""
    public = {
        getattr(package, n)
        for package in (fieldrecon, *NAMESPACES)
        for n in package.__all__
        if inspect.isclass(getattr(package, n))
    }
    functions = [getattr(room, n) for n in room.__all__ if inspect.isfunction(getattr(room, n))]
    received = {t for f in functions for t in returned_types(f)}
    assert {t.__name__ for t in received if t not in public} == set()


def test_an_unknown_name_raises_attribute_error():
    with pytest.raises(AttributeError, match="module 'fieldrecon' has no attribute 'kriging'"):
        fieldrecon.kriging  # noqa: B018


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["experiments", "list"]])
def test_the_command_line_answers_without_numpy(arguments):
    """Commands that compute nothing do not import NumPy, SciPy or matplotlib."""
    code = (
        "import sys\nfrom fieldrecon.cli.main import main\n"
        f"try:\n    main({arguments})\nexcept SystemExit:\n    pass\n"
        "print([name for name in ('numpy', 'scipy', 'matplotlib') if name in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.endswith("\n[]\n")
    assert len(shown.stdout) > len("\n[]\n")
