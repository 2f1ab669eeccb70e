"""Methods in the plane for a region of the globe: projection, derivatives, rotations."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.methods import OnTangentPlane, to_unit
from fieldrecon.methods.tangent_plane import in_tangent_plane, mean_direction
from fieldrecon.selection.models import MODELS


def region(n, seed, turn=0.0):
    """Longitudes and latitudes within 15 degrees of (turn + 20, 70)."""
    u = fr.datasets.uniform(n, 2, seed)
    return np.column_stack([turn + 20 + 40 * (u[:, 0] - 0.5), 70 + 30 * (u[:, 1] - 0.5)])


def smooth(lonlat):
    x, y, z = to_unit(lonlat).T
    return np.sin(3 * x) * y + z**2


SITES, QUERIES = region(200, 0), region(30, 1)
MAKERS = {
    "LS": lambda p: fr.LeastSquares(p, degree=4),
    "MLS": lambda p: fr.MovingLeastSquares(p, fr.wendland(3, 2), 2, 24),
    "RBF": lambda p: fr.RBF(p, fr.polyharmonic(3)),
    "PU": fr.PartitionOfUnityRBF,
}
METHODS = {
    name: fr.OnGlobe(SITES, lambda u, maker=maker: OnTangentPlane(u, maker))
    for name, maker in MAKERS.items()
}
each_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


def test_the_projection_keeps_areas_and_distances_from_the_pole():
    """Lambert's projection: the distance from the pole is the chord, and areas do not change."""
    units = to_unit(SITES)
    pole = mean_direction(units)
    flat = in_tangent_plane(units, pole)
    chords = np.linalg.norm(units - pole, axis=1)
    np.testing.assert_allclose(np.linalg.norm(flat, axis=1), chords, atol=1e-14)
    h = 1e-4
    corners = [in_tangent_plane(to_unit(SITES + e), pole) for e in h * np.eye(2)]
    first, second = (corner - flat for corner in corners)
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    on_sphere = np.radians(h) ** 2 * np.cos(np.radians(SITES[:, 1]))
    np.testing.assert_allclose(area, on_sphere, rtol=1e-4)


@pytest.mark.parametrize("pole", [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
def test_the_pole_may_be_one_of_the_earth(pole):
    """There every direction is to the south or to the north."""
    near = np.array(pole) + 0.1 * np.roll(pole, 1)
    near /= np.linalg.norm(near)
    flat = in_tangent_plane(np.array([pole, near]), np.array(pole))
    np.testing.assert_allclose(flat[0], 0, atol=1e-15)
    assert np.linalg.norm(flat[1]) == pytest.approx(np.linalg.norm(near - pole))


def test_every_point_but_the_antipode_of_the_pole_has_a_projection():
    """At any distance the chord is kept; the antipode would be a circle and is finite."""
    pole, t = to_unit([10.0, 50.0]), np.linspace(0.0, 3.1, 32)[:, None]
    units = np.cos(t) * pole + np.sin(t) * to_unit([100.0, 0.0])
    chords = np.linalg.norm(units - pole, axis=1)
    flat = in_tangent_plane(units, pole)
    np.testing.assert_allclose(np.linalg.norm(flat, axis=1), chords, atol=1e-12)
    assert np.isfinite(in_tangent_plane(-np.eye(3)[2:], np.eye(3)[2])).all()


@each_method
def test_derivatives_equal_differences(method):
    """Gradients and second derivatives by degrees; the Laplacian is the one on the sphere."""
    field, h = method.field(smooth(SITES)), 1e-4
    steps = [(field(QUERIES + e) - field(QUERIES - e)) / (2 * h) for e in h * np.eye(2)]
    np.testing.assert_allclose(field.gradient(QUERIES), np.stack(steps, -1), atol=1e-7)
    steps = [
        (field.gradient(QUERIES + e) - field.gradient(QUERIES - e)) / (2 * h) for e in h * np.eye(2)
    ]
    np.testing.assert_allclose(field.hessian(QUERIES), np.stack(steps, -1), atol=1e-7)
    lat, (by_lon, by_lat) = np.radians(QUERIES[:, 1]), field.gradient(QUERIES).T
    hessian = np.degrees(np.degrees(field.hessian(QUERIES)))
    beltrami = hessian[:, 0, 0] / np.cos(lat) ** 2 + hessian[:, 1, 1]
    beltrami -= np.tan(lat) * np.degrees(by_lat)
    np.testing.assert_allclose(field.laplacian(QUERIES), beltrami, rtol=1e-6, atol=1e-6)
    assert by_lon.any()


@each_method
def test_weights_adjoints_and_residuals_agree_with_the_field(method):
    """The routes are those of the method in the plane."""
    values = smooth(SITES)
    field = method.field(values)
    np.testing.assert_allclose(method.weights(QUERIES) @ values, field(QUERIES), atol=1e-7)
    gradients = [g @ values for g in method.gradient_weights(QUERIES)]
    np.testing.assert_allclose(np.stack(gradients, -1), field.gradient(QUERIES), atol=1e-6)
    load = np.cos(QUERIES)
    expected = method.weights(QUERIES).T @ load
    np.testing.assert_allclose(method.adjoint(QUERIES, load), expected, atol=1e-8)
    inner = method.method
    assert np.array_equal(fr.leave_one_out(method, values), fr.leave_one_out(inner.method, values))


@each_method
def test_fields_are_saved_and_made_again(tmp_path, method):
    """With the pole, which the points alone would not give without one of them."""
    field = method.field(smooth(SITES))
    fr.save(tmp_path / "f.npz", field)
    assert np.array_equal(fr.load(tmp_path / "f.npz")(QUERIES), field(QUERIES))
    again = OnTangentPlane(to_unit(SITES[1:]), method.method.method, method.method.pole)
    assert np.array_equal(again.pole, method.method.pole)


def test_the_region_may_lie_across_the_date_line():
    """The field turns with its sites."""
    values = smooth(SITES)
    there = METHODS["RBF"].field(values)
    turned = fr.OnGlobe(region(200, 0, 160.0), lambda u: OnTangentPlane(u, MAKERS["RBF"]))
    found = turned.field(values)(QUERIES + np.array([160.0, 0.0]))
    np.testing.assert_allclose(found, there(QUERIES), atol=1e-9)


def test_polynomials_of_the_plane_are_determined():
    """In space, a region is nearly flat, and the same model has no field there."""
    units = to_unit([10.0, 50.0] + 0.1 * fr.datasets.uniform(60, 2, seed=0))
    with pytest.raises(np.linalg.LinAlgError, match="do not determine a polynomial"):
        fr.LeastSquares(units, degree=2)
    model = MODELS["ls2"].on_tangent_plane(mean_direction(units))
    ((maker,),) = model.makers(units)
    assert maker(units).method.degree == 2
    with pytest.raises(ValueError, match=r"points must be unit vectors \(n, 3\); got \(60, 2\)"):
        OnTangentPlane(units[:, :2], fr.LeastSquares)


def test_points_and_poles_of_another_length_are_refused():
    """Their projections would mean nothing; six decimals of a file are enough."""
    units = to_unit(SITES)
    assert OnTangentPlane(units.round(6), fr.LeastSquares, pole=units[0].round(6)).degree == 0
    with pytest.raises(ValueError, match=r"points must be of length one, .* is of length 3$"):
        OnTangentPlane(np.vstack([units, 3 * units[:1]]), fr.LeastSquares)
    with pytest.raises(ValueError, match=r"pole must be of length one, .* is of length 1.00001$"):
        OnTangentPlane(units, fr.LeastSquares, pole=1.00001 * units[0])
    with pytest.raises(ValueError, match=r"pole must be .* \(1, 2, 3\) is of length 3.74166$"):
        OnTangentPlane(units, fr.LeastSquares, pole=[1, 2, 3])
    with pytest.raises(ValueError, match=r"pole must be one unit vector \(3,\); got .* \(1, 3\)"):
        OnTangentPlane(units, fr.LeastSquares, pole=units[:1])
