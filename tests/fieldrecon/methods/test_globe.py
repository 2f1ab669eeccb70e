"""Methods on the globe: the date line, the poles, rotations and gradients."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fieldrecon as fr
from fieldrecon.methods.globe import OnGlobe, principal, to_unit


def random_points(n, seed):
    """Longitudes and latitudes, uniformly distributed over the sphere."""
    u = fr.datasets.uniform(n, 2, seed)
    return np.column_stack([360 * u[:, 0] - 180, np.degrees(np.arcsin(2 * u[:, 1] - 1))])


def smooth(lonlat):
    """A smooth function of the unit vectors."""
    x, y, z = to_unit(lonlat).T
    return np.sin(3 * x) * y + z**2


SITES = random_points(300, 0)
QUERIES = random_points(80, 1)
MAKERS = {
    "RBF": lambda u: fr.RBF(u, fr.polyharmonic(3)),
    "RBF positive definite": lambda u: fr.RBF(u, fr.wendland(3, 1, 1.0)),
    "PU": fr.PartitionOfUnityRBF,
    "LS": fr.LeastSquares,
    "MLS": lambda u: fr.MovingLeastSquares(u, fr.inverse_square(0.1)),
}
METHODS = {name: OnGlobe(SITES, maker) for name, maker in MAKERS.items()}
each_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


def maker_of(method):
    """The function that the method was made with."""
    return next(maker for name, maker in MAKERS.items() if METHODS[name] is method)


@given(
    lon=st.floats(-1e3, 1e3),
    lat=st.floats(-90, 90),
    turns=st.integers(-3, 3),
)
def test_unit_vectors_and_principal_longitudes(lon, lat, turns):
    """Vectors have length one and do not change with multiples of 360°. Latitudes are recovered."""
    unit = to_unit([lon, lat])
    assert np.linalg.norm(unit) == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(to_unit([lon + 360 * turns, lat]), unit, atol=1e-11)
    np.testing.assert_allclose(to_unit(principal([lon, lat])), unit, atol=1e-11)
    assert -180 <= principal([lon, lat])[0] < 180
    assert np.degrees(np.arcsin(np.clip(unit[2], -1, 1))) == pytest.approx(lat, abs=1e-5)


def test_unit_vectors_at_whole_quarters_are_exact():
    """Also after many turns."""
    quarters = np.arange(-400, 401)
    x, y, z = to_unit(np.column_stack([90.0 * quarters, np.zeros(801)])).T
    assert np.array_equal(x, np.array([1, 0, -1, 0])[quarters % 4])
    assert np.array_equal(y, np.array([0, 1, 0, -1])[quarters % 4])
    assert not z.any()


def test_chords_equal_the_haversine_formula():
    """The distance in space is 2 sin(angle / 2)."""
    (l1, b1), (l2, b2) = np.radians(SITES[:150].T), np.radians(SITES[150:].T)
    haversine = np.sin((b2 - b1) / 2) ** 2 + np.cos(b1) * np.cos(b2) * np.sin((l2 - l1) / 2) ** 2
    chords = np.linalg.norm(to_unit(SITES[:150]) - to_unit(SITES[150:]), axis=1)
    np.testing.assert_allclose(chords, 2 * np.sqrt(haversine), rtol=1e-12)


@each_method
def test_fields_are_periodic_in_longitude(method):
    """Any longitude of the same meridian gives the same result, also across the date line."""
    values = smooth(SITES)
    shifted = SITES + np.outer(SITES[:, 0] < 0, [360, 0])
    other = OnGlobe(shifted, maker_of(method)).field(values)
    field = method.field(values)
    np.testing.assert_allclose(other(QUERIES), field(QUERIES - [720, 0]), rtol=1e-9, atol=1e-9)
    east, west = (
        [[180 - 1e-9, b] for b in range(-80, 90, 20)],
        [[-180 + 1e-9, b] for b in range(-80, 90, 20)],
    )
    np.testing.assert_allclose(field(east), field(west), atol=1e-8)


@each_method
def test_at_a_pole_values_do_not_depend_on_the_longitude(method):
    """The derivative with respect to longitude vanishes there."""
    field = method.field(smooth(SITES))
    for pole in (-90.0, 90.0):
        around = np.column_stack([np.linspace(-180, 180, 13), np.full(13, pole)])
        np.testing.assert_allclose(field(around), field(around[0]), rtol=1e-12)
        np.testing.assert_allclose(field.gradient(around)[:, 0], 0, atol=1e-15)


@each_method
def test_fields_are_equivariant_under_rotations(method):
    """The field of rotated data is the rotated field."""
    rotation = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))

    def rotated(lonlat):
        x, y, z = rotation @ to_unit(lonlat).T
        return np.degrees(np.column_stack([np.arctan2(y, x), np.arcsin(np.clip(z, -1, 1))]))

    values = smooth(SITES)
    there = OnGlobe(rotated(SITES), maker_of(method)).field(values)(rotated(QUERIES))
    tolerance = 1e-4 if isinstance(method.method, fr.PartitionOfUnityRBF) else 1e-8  # boxes differ
    np.testing.assert_allclose(there, method.field(values)(QUERIES), atol=tolerance)


@each_method
def test_gradients_equal_central_differences_per_degree(method):
    """They are derivatives with respect to longitude and latitude in degrees."""
    field, h = method.field(smooth(SITES)), 1e-4
    inner = QUERIES[abs(QUERIES[:, 1]) < 89]
    steps = [(field(inner + e) - field(inner - e)) / (2 * h) for e in h * np.eye(2)]
    np.testing.assert_allclose(field.gradient(inner), np.stack(steps, axis=-1), atol=1e-7)


@each_method
def test_second_derivatives_are_derivatives_of_gradients(method):
    """Against differences of the gradients, by degrees of longitude and latitude."""
    field, h = method.field(smooth(SITES)), 1e-4
    inner = QUERIES[abs(QUERIES[:, 1]) < 89]
    steps = [
        (field.gradient(inner + e) - field.gradient(inner - e)) / (2 * h) for e in h * np.eye(2)
    ]
    np.testing.assert_allclose(field.hessian(inner), np.stack(steps, axis=-1), atol=1e-8)


def test_the_laplacian_is_that_of_the_sphere():
    """Harmonics a.u of degree 1, which are reproduced, have the Laplacian -1 (1 + 1) a.u."""
    field = OnGlobe(SITES, lambda u: fr.RBF(u, fr.polyharmonic(3))).field(to_unit(SITES))
    np.testing.assert_allclose(field.laplacian(QUERIES), -2 * to_unit(QUERIES), atol=1e-8)


@each_method
def test_fields_gradients_and_adjoints_agree_with_the_weights(method):
    """Weights may be dense or sparse."""
    values = np.column_stack([smooth(SITES), SITES[:, 0]])
    field = method.field(values)
    np.testing.assert_allclose(method.weights(QUERIES) @ values, field(QUERIES), atol=1e-7)
    gradients = [g @ values for g in method.gradient_weights(QUERIES)]
    np.testing.assert_allclose(np.stack(gradients, -1), field.gradient(QUERIES), atol=1e-7)
    load = np.cos(QUERIES)
    np.testing.assert_allclose(
        method.adjoint(QUERIES, load), method.weights(QUERIES).T @ load, atol=1e-8
    )


@each_method
def test_leave_one_out_residuals_equal_those_in_space(method):
    """For one site they also equal a refit."""
    values = smooth(SITES)
    residuals = fr.leave_one_out(method, values)
    assert np.array_equal(residuals, fr.leave_one_out(method.method, values))
    if not isinstance(method.method, fr.PartitionOfUnityRBF):
        rest = OnGlobe(SITES[1:], maker_of(method)).field(values[1:])
        assert residuals[0] == pytest.approx(values[0] - rest(SITES[0]), abs=1e-9)


@pytest.mark.parametrize("name", ["RBF", "PU"])
def test_chords_are_more_accurate_than_degrees(name):
    """Near date line and poles the error is a fifth of that of degrees taken as lengths."""
    edge = np.vstack(
        [[[179.9, b] for b in range(-60, 70, 10)], random_points(40, 5) / [1, 45] + [0, 88]]
    )
    edge = edge[abs(edge[:, 1]) <= 90]
    values = smooth(SITES)
    flat = fr.RBF(SITES, fr.polyharmonic(3)).field(values)
    on_globe = METHODS[name].field(values)
    assert abs(on_globe(edge) - smooth(edge)).max() < 0.2 * abs(flat(edge) - smooth(edge)).max()


def test_latitudes_beyond_a_pole_are_refused():
    """Usually longitude and latitude are exchanged, and the message asks about that."""
    with pytest.raises(ValueError, match="within ±90 degrees; got 120 at longitude 10: are they"):
        to_unit([[0.0, 0.0], [10.0, 120.0], [20.0, -100.0]])  # the first is named
    with pytest.raises(ValueError, match="lonlat must have 2 coordinates per point"):
        to_unit([1.0, 2.0, 3.0])
