"""Variational implicit functions and shape transformations: data, symmetry and errors."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldreport.experiments.surfaces.variational_implicits import (
    ball,
    ellipsoid,
    on_ellipsoid,
    ring,
    star_shape,
    two_discs,
)


@pytest.mark.parametrize("offset", [None, 0.05])
def test_the_implicit_function_interpolates_its_data(offset):
    """The data are zeros at the points and slopes along the normals, or values inside."""
    p, n = ellipsoid(60)
    f = fr.surfaces.variational_implicit(p, 3 * n, offset=offset)
    np.testing.assert_allclose(f(p), 0, atol=1e-10)
    if offset is None:
        np.testing.assert_allclose(np.einsum("ij,ij->i", f.gradient(p), n), -1, atol=1e-8)
    else:
        np.testing.assert_allclose(f(p - offset * n), offset, atol=1e-10)
    assert f([0, 0, 0]) > 0 > f([3, 0, 0])


def test_an_ellipsoid_is_reconstructed_with_third_order():
    """The distance of the zeros from the ellipsoid has order three or more.

    The volume agrees to 0.1 %.
    """
    (coarse, _), (fine, volume) = on_ellipsoid(100, (40, None)), on_ellipsoid(100, (160, None))
    assert np.log2(coarse / fine) > 3
    assert volume == pytest.approx(4 / 3 * np.pi * 1.5 * 0.7, rel=1e-3)


@pytest.mark.parametrize(("first", "second"), [(star_shape, two_discs), (ring, ball)])
def test_a_transformation_begins_and_ends_with_the_shapes(first, second):
    """The points and normals of both shapes are interpolated, in the plane and in space."""
    shapes = first(24), second(24)
    transformation = fr.surfaces.ShapeTransformation(shapes, [2.0, 3.0])
    for (p, n), time in zip(shapes, (2.0, 3.0), strict=True):
        at = transformation.at(time)
        unit = n / np.linalg.norm(n, axis=1, keepdims=True)
        np.testing.assert_allclose(at(p), 0, atol=1e-9)
        np.testing.assert_allclose(np.einsum("ij,ij->i", at.gradient(p), unit), -1, atol=1e-7)


def test_a_transformation_is_symmetric_in_time():
    """Exchanging the shapes and reversing the time gives the same functions."""
    a, b = star_shape(30), two_discs(30)
    forward, backward = (
        fr.surfaces.ShapeTransformation([a, b], [0, 1]),
        fr.surfaces.ShapeTransformation([b, a], [0, 1]),
    )
    x = np.random.default_rng(1).normal(size=(50, 2))
    for time in (0.2, 0.5, 0.9):
        np.testing.assert_allclose(forward.at(time)(x), backward.at(1 - time)(x), atol=1e-9)
    assert np.abs(forward.at(0.2)(x) - backward.at(0.2)(x)).max() > 0.1


def test_gradients_of_slices_equal_central_differences():
    """The slice at a fixed time has the gradient with respect to the space variables."""
    at = fr.surfaces.ShapeTransformation([star_shape(30), two_discs(30)], [0, 1]).at(0.4)
    x, h = np.random.default_rng(2).normal(size=(20, 2)), 1e-6
    slopes = [(at(x + h * e) - at(x - h * e)) / (2 * h) for e in np.eye(2)]
    np.testing.assert_allclose(at.gradient(x), np.stack(slopes, axis=1), atol=1e-6)


def test_invalid_shapes_and_times_are_refused():
    """Normals must have the shape of the points and not vanish; times must differ."""
    p, n = star_shape(12)
    with pytest.raises(ValueError, match="the shape of the points"):
        fr.surfaces.variational_implicit(p, n[:5])
    with pytest.raises(ValueError, match="must not vanish; that of point 3 does"):
        fr.surfaces.variational_implicit(p, n * (np.arange(12) != 3)[:, None])
    with pytest.raises(ValueError, match="one for each of two or more shapes"):
        fr.surfaces.ShapeTransformation([(p, n), (p, n)], [0.0, 0.0])
    with pytest.raises(ValueError, match="offset must be a positive"):
        fr.surfaces.variational_implicit(p, n, offset=0.0)
