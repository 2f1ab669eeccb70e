"""Saved fields: a field is reproduced by its file, and other files are refused."""

import io
import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.io.saved_fields import load_with_names
from fieldrecon.methods.functionals import values_at

POINTS = fr.datasets.halton(120, 2)
VALUES = fr.datasets.franke(POINTS)
QUERIES = fr.datasets.uniform(50, 2, seed=1)
LONLAT = POINTS * [360, 180] - [180, 90]

KERNELS = [
    fr.thin_plate_spline(),
    fr.polyharmonic(np.int64(3)),
    fr.multiquadric(0.1),
    fr.gaussian(0.05),
    fr.inverse_multiquadric(0.1),
    fr.matern(1.5, 0.3),
    fr.wendland(3, 1, 0.4),
]
METHODS = [
    fr.LeastSquares(POINTS, 3),
    fr.MovingLeastSquares(POINTS, fr.inverse_square(0.1), 1),
    fr.MovingLeastSquares(POINTS, fr.wendland(3, 1), 2, 24),
    *(fr.RBF(POINTS, kernel) for kernel in KERNELS),
    fr.RBF(POINTS, fr.thin_plate_spline(), degree=2, smoothing=0.1 + 0.2),
    fr.PartitionOfUnityRBF(POINTS),
    fr.PartitionOfUnityRBF(POINTS, fr.polyharmonic(3), degree=2, patch_size=30, smoothing=1e-3),
    fr.PartitionOfUnityRBF(POINTS, smoothing=0.1 * np.arange(120) ** 2),
    fr.OnGlobe(LONLAT, lambda u: fr.RBF(u, fr.polyharmonic(3))),
    fr.OnGlobe(LONLAT, fr.PartitionOfUnityRBF),
    fr.methods.Mean(POINTS, [fr.PartitionOfUnityRBF, fr.LeastSquares]),
]


@pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
def test_a_saved_field_is_reproduced_bit_for_bit(tmp_path, method):
    """Values, gradients and column names of a loaded field equal those of the saved one."""
    field = method.field(VALUES)
    fr.save(tmp_path / "field.npz", field, names=("x", "höhe"))
    again, names = load_with_names(tmp_path / "field.npz")
    assert type(again.method) is type(method)
    assert names == ["x", "höhe"]
    assert np.array_equal(again(QUERIES), field(QUERIES))
    assert np.array_equal(again.gradient(QUERIES), field.gradient(QUERIES))


def with_other_arguments():
    """Methods that have no kernel, or other data or queries, with queries."""
    yield fr.NaturalCubicSpline(POINTS[:, 0]), QUERIES[:, 0]
    kinds = [fr.methods.values_at(POINTS[:9]), fr.methods.laplacians_at(POINTS[9:20] / 3)]
    yield fr.HermiteRBF(kinds, fr.matern(5.5, 0.1)), QUERIES
    at_units = fr.OnGlobe(
        LONLAT, lambda u: fr.HermiteRBF(fr.methods.values_at(u), fr.gaussian(0.1))
    )
    yield at_units, LONLAT
    units = fr.methods.to_unit(LONLAT)
    yield fr.methods.OnTangentPlane(units, fr.LeastSquares), units
    yield fr.BarycentricCoordinates([[0, 0], [1, 0], [2, 2], [0, 1]]), QUERIES
    mesh = fr.SimplexMesh.delaunay(POINTS)
    yield fr.VoronoiCell(mesh, np.flatnonzero(~mesh.boundary_vertices)[7]), QUERIES


def test_every_method_is_saved(tmp_path):
    """No class is missing; coordinates of a Voronoi cell keep the cells round the vertex."""
    others = [*with_other_arguments()]
    spaces = vars(fr.methods) | vars(fr.barycentric)
    classes = {
        c for c in spaces.values() if isinstance(c, type) and issubclass(c, fr.Reconstruction)
    }
    assert {type(m) for m in METHODS} | {type(m) for m, _ in others} == classes
    for method, queries in others:
        field = method.field(np.cos(np.arange(len(method.points))))
        fr.save(tmp_path / "field.npz", field)
        again = fr.load(tmp_path / "field.npz")
        assert type(again.method) is type(method)
        assert np.array_equal(again(queries), field(queries))
        assert np.array_equal(again.method.points, method.points)
        fr.save(tmp_path / "again.npz", again)
        assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "field.npz").read_bytes()
        if isinstance(method, fr.VoronoiCell):
            assert all(map(np.array_equal, again.method.cells, method.cells))


def test_data_of_any_shape_and_type_are_reproduced(tmp_path):
    """The data at a site may be complex numbers, vectors or matrices."""
    rng = np.random.default_rng(0)
    for shape, unit in (((), 1j), ((2,), 1.0), ((2, 3), 1j)):
        values = rng.standard_normal((120, *shape)) * (1 + unit)
        field = fr.RBF(POINTS, fr.thin_plate_spline()).field(values)
        fr.save(tmp_path / "field.npz", field)
        again = fr.load(tmp_path / "field.npz")
        assert np.array_equal(again(QUERIES), field(QUERIES))
        assert np.array_equal(again.values, values)


def test_the_requested_degree_of_patches_is_saved(tmp_path):
    """On a line the patches reduce their polynomial degree; the file keeps the requested degree."""
    line = np.linspace(0, 1, 200)[:, None] * [1.0, 2.0]
    field = fr.PartitionOfUnityRBF(line).field(np.sin(line[:, 0]))
    fr.save(tmp_path / "field.npz", field)
    again = fr.load(tmp_path / "field.npz")
    assert again.method.reduced == field.method.reduced > 0
    assert np.array_equal(again(QUERIES), field(QUERIES))


@pytest.mark.parametrize("name", ["patches", "patches_on_globe"])
def test_patches_of_version_1_are_read_with_a_warning(name):
    """The files were written by that version; their sites are on circles, their data constants."""
    path = Path(__file__).with_name(f"{name}_version_1.npz")
    with pytest.warns(UserWarning, match=r"version_1\.npz is a field of version 1") as warnings:
        field = fr.load(path)
    assert warnings[0].filename == __file__
    center = np.zeros(2)
    assert field.values.max() == field.values.min() == 1.0
    assert field(center) == pytest.approx(1.0, abs=1e-12)


def test_other_methods_of_version_1_are_read_without_a_warning(tmp_path):
    """Nothing has changed for them; warnings are errors here."""
    field = fr.load(written(tmp_path, lambda h: h.update(version=1)))
    assert np.array_equal(field.values, VALUES)


def test_a_field_copies_its_data():
    """The data do not change with the caller's array and are read-only."""
    values = VALUES.copy()
    field = METHODS[0].field(values)
    values[:] = 0
    assert np.array_equal(field.values, VALUES)
    with pytest.raises(ValueError, match="read-only"):
        field.values[0] = 1


def test_a_field_of_an_unknown_method_cannot_be_saved(tmp_path):
    """A subclass cannot be reconstructed from the file, so `save` raises and leaves no file."""

    class Mine(fr.LeastSquares):
        pass

    with pytest.raises(TypeError, match="a field of Mine cannot be saved"):
        fr.save(tmp_path / "field.npz", Mine(POINTS).field(VALUES))
    assert list(tmp_path.iterdir()) == []


def written(folder, change=None, **arrays):
    """Write a field with a changed header or changed arrays, and return the path."""
    fr.save(folder / "good.npz", fr.RBF(POINTS, fr.gaussian(0.05)).field(VALUES))
    with np.load(folder / "good.npz") as stored:
        content = dict(stored)
    header = json.loads(bytes(content["header"]))
    if change:
        change(header)
    content["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    path = folder / "changed.npz"
    np.savez(path, **(content | arrays))
    return path


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda h: h.update(format="zarr"), "its header does not say 'fieldrecon field'"),
        (lambda h: h.update(version=3), "is a field of version 3; .* reads versions 1 and 2"),
        (lambda h: h.pop("version"), "is a field of version None"),
        (lambda h: h.pop("method"), "'method'"),
        (lambda h: h.update(names=3), "no field that can be fitted again"),
        (lambda h: h.update(method=[]), "no field that can be fitted again"),
        (lambda h: h["method"].update(name="system"), "there is no 'system'; there are Bary"),
        (lambda h: h["method"].update(name=["RBF"]), r"there is no \['RBF'\]"),
        (lambda h: h["method"].update(shell="ls"), r"RBF is made with .*; got .*'shell'"),
        (lambda h: h["method"].update(smoothing=-1), "smoothing must be zero or a positive"),
        (lambda h: h["method"].update(kernel={"name": "exec"}), "there is no 'exec'; there are g"),
        (lambda h: h["method"].update(kernel={"name": "gaussian"}), r"gaussian has \['scale'\]"),
        (lambda h: h["method"]["kernel"].update(scale="1"), "scale must be a positive number"),
    ],
)
def test_a_wrong_header_is_refused(tmp_path, change, words):
    """The message names the file. Names in the header are looked up among the library's only."""
    with pytest.raises(ValueError, match=words) as caught:
        fr.load(written(tmp_path, change))
    assert "changed.npz" in str(caught.value)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"points": POINTS[:7]}, "values must have one entry for each point"),
        ({"points": POINTS[:, 0]}, r"points must have the shape \(n, d\)"),
        ({"values": VALUES * np.nan}, "values must be finite"),
        ({"header": np.frombuffer(b"\xff{", np.uint8)}, "is not a file of a field"),
        ({"header": np.frombuffer(b"[]", np.uint8)}, "does not say"),
        ({"header": np.frombuffer(b"[" * 100_000, np.uint8)}, "is not a file of a field"),
        ({"values": np.array([{}], dtype=object)}, "is not a file of a field.*allow_pickle"),
    ],
)
def test_inconsistent_arrays_are_refused(tmp_path, arrays, words):
    """A pickle in the archive is not opened."""
    with pytest.raises(ValueError, match=words):
        fr.load(written(tmp_path, **arrays))


def test_parts_of_functionals_of_another_shape_are_refused(tmp_path):
    """Numbers for the gradients would be taken for each of their components."""
    path = tmp_path / "field.npz"
    fr.save(path, fr.HermiteRBF(values_at(POINTS), fr.polyharmonic(3)).field(VALUES))
    with np.load(path) as stored:
        content = dict(stored)
    header = json.loads(bytes(content["header"]))
    header["method"]["gradient"] = [0.0] * len(POINTS)
    np.savez(path, **(content | {"header": np.frombuffer(json.dumps(header).encode(), np.uint8)}))
    with pytest.raises(ValueError, match=r"gradient must have the shape \(120, 2\); got \(120,\)"):
        fr.load(path)


def test_other_files_are_refused(tmp_path):
    """Such files are a text, a pickle, a truncated archive and an archive of other arrays."""
    whole = written(tmp_path).read_bytes()
    other = io.BytesIO()
    np.savez(other, x=POINTS)
    contents = [b"", b"x,y\n", pickle.dumps([1]), whole[: len(whole) // 2], other.getvalue()]
    for content in contents:
        (tmp_path / "field.npz").write_bytes(content)
        with pytest.raises(ValueError, match=r"field\.npz is not a file of a field"):
            fr.load(tmp_path / "field.npz")
    with pytest.raises(FileNotFoundError):
        fr.load(tmp_path / "nowhere.npz")
