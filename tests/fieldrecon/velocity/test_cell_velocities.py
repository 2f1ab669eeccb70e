"""Velocities of cells: least squares, closed form, defect, and reconstruction at vertices."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.cells import cell_velocities, raviart_thomas
from fieldrecon.velocity.cells_to_vertices import circumcenter_weights, vertex_velocities_from_cells
from fieldrecon.velocity.vertices import divergence, normal_velocities
from laws import assert_close
from meshes import MESHES, abc_flow, affine, jittered_mesh, order, rms, taylor_green

EXACT = 1e-11


@pytest.fixture(params=MESHES, scope="module")
def mesh(request) -> SimplexMesh:
    return MESHES[request.param]


def random_data(mesh: SimplexMesh, seed: int = 5) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(len(mesh.faces))


def outward(mesh: SimplexMesh, c: int) -> np.ndarray:
    """Outward unit normals of the faces of cell c."""
    return mesh.cell_face_signs[c][:, None] * mesh.face_normals[mesh.cell_faces[c]]


def triangle(seed: int) -> SimplexMesh:
    return SimplexMesh(np.random.default_rng(seed).uniform(-1, 1, (3, 2)), [[0, 1, 2]])


def fat_triangles() -> list[SimplexMesh]:
    """Five hundred random triangles with an area of at least 0.02."""
    made = (triangle(seed) for seed in range(2000))
    return [m for m in made if m.cell_measures[0] > 0.02][:500]


# --- least squares ------------------------------------------------------------------------------


def velocities_are_least_squares_solutions(velocities, mesh: SimplexMesh) -> None:
    """argmin |N u - v|² in each cell must equal numpy.linalg.lstsq for random data."""
    v = random_data(mesh)
    found = velocities(mesh, v)
    for c in range(0, len(mesh.cells), 5):
        faces = mesh.cell_faces[c]
        u = np.linalg.lstsq(mesh.face_normals[faces], v[faces], rcond=None)[0]
        assert_close(found[c] / np.abs(u).max(), u / np.abs(u).max(), 1e-9)


def test_cell_velocities_equal_the_least_squares_solution_of_numpy(mesh):
    """The closed form equals N⁺v, in the plane and in space."""
    velocities_are_least_squares_solutions(lambda m, v: cell_velocities(m, v).values, mesh)


def at_the_circumcenter(mesh, v):
    """Mutant: the Raviart-Thomas field at the circumcentre instead of the symmedian point."""
    return raviart_thomas(mesh, v)


def inward_too(mesh, v):
    """Mutant: each normal treated as outward for its second cell, too."""
    return cell_velocities(mesh, np.abs(v)).values


@pytest.mark.parametrize("mutant", [at_the_circumcenter, inward_too])
def test_other_formulas_are_not_least_squares_solutions(mutant):
    with pytest.raises(AssertionError, match="deviates"):
        velocities_are_least_squares_solutions(mutant, MESHES["random 2-D"])


def test_cell_velocities_equal_the_raviart_thomas_field_at_the_symmedian_point(mesh):
    """K = Σ l_a² q_a / Σ l_a² with l_a the measure of the face opposite q_a, in any dimension."""
    v = random_data(mesh)
    squared = (mesh.face_measures**2)[mesh.cell_faces][..., None]
    k = (squared * mesh.points[mesh.cells]).sum(axis=1) / squared.sum(axis=1)
    u = cell_velocities(mesh, v).values
    size = np.abs(u).max(axis=1, keepdims=True)
    assert_close(raviart_thomas(mesh, v, k) / size, u / size, 1e-8)


@pytest.mark.slow
def test_distances_of_the_symmedian_point_are_proportional_to_the_sides():
    """Therefore the residual of the least-squares fit is proportional to l."""
    for mesh in fat_triangles()[:50]:
        l = mesh.face_measures[mesh.cell_faces[0]]  # noqa: E741 - the letter of the slides
        q = mesh.points[mesh.cells[0]]
        k = (l**2 @ q) / (l @ l)
        distance = np.einsum("ad,ad->a", outward(mesh, 0), np.roll(q, -1, axis=0) - k)
        assert_close(distance / distance.sum(), l / l.sum(), 1e-10)


@pytest.mark.slow
def test_cell_velocities_of_affine_fields_equal_the_closed_form():
    """u_LS = u(O) + s(K - O) + ½(σ h̄ - σ̄ q₁q₂q₃/R²) for G = sI + ωJ + S, in complex numbers.

    O is the circumcentre, q_a the vertices relative to O, h their sum, R their length, and S z = σ
    z̄.
    """
    rng = np.random.default_rng(6)
    for mesh in fat_triangles():
        s, w = rng.uniform(-1, 1, 2)
        sigma = complex(*rng.uniform(-1, 1, 2))
        g = np.array([[s + sigma.real, sigma.imag - w], [sigma.imag + w, s - sigma.real]])
        o = mesh.circumcenters[0]
        q = (mesh.points[mesh.cells[0]] - o) @ [1, 1j]
        l2 = mesh.face_measures[mesh.cell_faces[0]] ** 2
        k = (l2 @ q) / l2.sum()
        wanted = (
            s * k + (sigma * q.sum().conj() - sigma.conjugate() * q.prod() / abs(q[0]) ** 2) / 2
        )
        wanted += (g @ o) @ [1, 1j]
        found = cell_velocities(mesh, normal_velocities(mesh, mesh.points @ g.T)).values[0]
        assert found @ [1, 1j] == pytest.approx(wanted, abs=1e-10 * (1 + abs(q[0])))


def test_constant_fields_are_reproduced(mesh):
    """This holds in every cell, also in almost flat ones."""
    d = mesh.points.shape[1]
    u = np.arange(1.0, d + 1)
    v = normal_velocities(mesh, np.tile(u, (len(mesh.points), 1)))
    found = cell_velocities(mesh, v)
    assert_close(found.values, np.tile(u, (len(mesh.cells), 1)), 1e-9)
    assert found.defect.max() < 1e-13


@pytest.mark.parametrize("unit", [1e-100, 1e100])
def test_cell_velocities_do_not_depend_on_unit_and_origin(mesh, unit):
    v = random_data(mesh)
    u = cell_velocities(mesh, v)
    size = np.abs(u.values).max(axis=1, keepdims=True)
    for points, tolerance in ((mesh.points * unit, 1e-9), (mesh.points + 1024.0, 1e-6)):
        other = cell_velocities(SimplexMesh(points, mesh.cells), v)
        assert_close(other.values / size, u.values / size, tolerance)
        assert_close(other.defect, u.defect, tolerance)


# --- rotation, expansion, strain ----------------------------------------------------------------


def test_a_rotation_is_exact_at_the_circumcentre_only():
    """p_a - O is parallel to n_a, so the data do not depend on a rotation about O."""
    mesh = MESHES["jittered 2-D"]
    m = mesh.points.mean(axis=0)
    rotation = lambda x: (x - m) @ np.array([[0.0, 1.0], [-1.0, 0.0]])  # noqa: E731
    found = cell_velocities(mesh, normal_velocities(mesh, rotation(mesh.points)))
    assert_close(found.values, rotation(mesh.circumcenters), EXACT)
    assert np.abs(found.values - rotation(mesh.cell_centers)).max() > 1e-3
    assert found.defect.max() < 1e-13


def test_a_rotation_in_space_needs_the_circumcentres_of_the_faces():
    """In space the circumcentre of a face is not its centroid.

    With data at the circumcentres of the faces the rotation is exact.
    """
    mesh = MESHES["jittered 3-D"]
    rotation = np.cross([0.3, -1.0, 0.7], mesh.face_circumcenters)
    v = np.einsum("fd,fd->f", mesh.face_normals, rotation)
    wanted = np.cross([0.3, -1.0, 0.7], mesh.circumcenters)
    assert_close(cell_velocities(mesh, v).values, wanted, EXACT)
    at_centroids = normal_velocities(mesh, np.cross([0.3, -1.0, 0.7], mesh.points))
    assert np.abs(cell_velocities(mesh, at_centroids).values - wanted).max() > 1e-3


def test_raviart_thomas_reproduces_expansions_and_rotations_at_the_circumcentre():
    """For an expansion the least-squares velocity is exact at the symmedian point instead."""
    mesh = MESHES["jittered 2-D"]
    u = lambda x: 2.0 * x + x @ np.array([[0.0, 3.0], [-3.0, 0.0]])  # noqa: E731
    v = normal_velocities(mesh, u(mesh.points))
    assert_close(raviart_thomas(mesh, v), u(mesh.circumcenters), EXACT)
    assert np.abs(cell_velocities(mesh, v).values - u(mesh.circumcenters)).max() > 1e-3


def test_raviart_thomas_reproduces_expansions_everywhere(mesh):
    """u = c + s x is in the Raviart-Thomas space, in the plane and in space."""
    u = lambda x: 2.0 * x + 1.0  # noqa: E731
    v = normal_velocities(mesh, u(mesh.points))
    assert_close(raviart_thomas(mesh, v, mesh.cell_centers), u(mesh.cell_centers), 1e-9)


def test_raviart_thomas_interpolates_the_normal_velocities(mesh):
    """n_a · u = v_a on face a, from both cells."""
    v = random_data(mesh)
    for k in range(mesh.points.shape[1] + 1):
        faces = mesh.cell_faces[:, k]
        on_face = raviart_thomas(mesh, v, mesh.face_centers[faces])
        flow = np.einsum("cd,cd->c", on_face, mesh.face_normals[faces])
        size = np.abs(on_face).max(axis=1)
        assert (np.abs(flow - v[faces]) / size).max() < 1e-8


def test_strain_has_no_defect_and_is_not_reproduced():
    """Divergence and defect are zero, but the error in an equilateral triangle is ½|σ|R."""
    q = np.exp(2j * np.pi * np.arange(3) / 3)
    mesh = SimplexMesh(np.column_stack([q.real, q.imag]), [[0, 1, 2]])
    found = cell_velocities(mesh, normal_velocities(mesh, mesh.points * [1, -1]))
    assert found.defect[0] < 1e-15
    assert np.linalg.norm(found.values[0]) == pytest.approx(0.5, abs=1e-14)


# --- the defect ---------------------------------------------------------------------------------


def test_the_defect_is_the_norm_of_the_residual(mesh):
    """r = l (l·v)/|l|², so |r| = |l·v|/|l| is the divergence in units of velocity."""
    v = random_data(mesh)
    found = cell_velocities(mesh, v)
    l = mesh.face_measures[mesh.cell_faces]  # noqa: E741
    div = divergence(mesh, v) * mesh.cell_measures / np.linalg.norm(l, axis=1)
    assert_close(found.defect, np.abs(div), 1e-11)
    normal = np.einsum("cad,cd->ca", mesh.face_normals[mesh.cell_faces], found.values)
    residual = np.linalg.norm(normal - v[mesh.cell_faces], axis=1)
    size = 1 + np.abs(found.values).max(axis=1)
    assert (np.abs(found.defect - residual) / size).max() < 1e-9


@pytest.mark.slow
def test_the_divergent_part_of_the_data_does_not_affect_the_velocity():
    """N⁺l = 0: adding a multiple of l to the data changes the defect only."""
    for mesh in fat_triangles()[:50]:
        v = random_data(mesh)
        more = np.empty(3)
        signs, faces = mesh.cell_face_signs[0], mesh.cell_faces[0]
        more[faces] = v[faces] + 5 * signs * mesh.face_measures[faces]
        one, other = cell_velocities(mesh, v), cell_velocities(mesh, more)
        assert_close(other.values, one.values, 1e-9)
        assert abs(other.defect[0] - one.defect[0]) > 1e-3


@pytest.mark.slow
@given(st.integers(0, 10**6), st.integers(2, 3))
def test_the_normal_equations_hold_in_any_simplex(seed, d):
    """Nᵀ(Nu - v) = 0, however flat the cell is."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (d + 1, d)) * 10.0 ** rng.integers(-3, 1, d)
    mesh = SimplexMesh(points, [range(d + 1)])
    v = random_data(mesh, seed)
    u = cell_velocities(mesh, v).values[0]
    n = mesh.face_normals
    assert np.abs(n.T @ (n @ u - v)).max() <= 1e-9 * (1 + np.abs(u).max())


def test_data_may_have_several_axes_and_be_complex():
    """The axes of the data are kept; the components come last."""
    mesh = MESHES["random 3-D"]
    v = np.random.default_rng(7).standard_normal((len(mesh.faces), 2, 4)) * (1 + 2j)
    found = cell_velocities(mesh, v)
    one = cell_velocities(mesh, v[:, 1, 2])
    assert found.values.shape == (len(mesh.cells), 2, 4, 3)
    assert_close(found.values[:, 1, 2], one.values, 1e-10)
    assert_close(found.defect[:, 1, 2], one.defect, 1e-10)
    assert_close(raviart_thomas(mesh, v)[:, 1, 2], raviart_thomas(mesh, v[:, 1, 2]), 1e-10)
    assert cell_velocities(mesh, v[:, :0]).values.shape == (len(mesh.cells), 0, 4, 3)


@pytest.mark.parametrize(("u", "d", "sides"), [(taylor_green, 2, (16, 64)), (abc_flow, 3, (6, 12))])
def test_cell_velocities_of_smooth_fields_are_of_first_order(u, d, sides):
    """The error at the circumcentre is O(h), because strain is not reproduced."""
    errors = []
    for side in sides:
        mesh = jittered_mesh(side, d, 8)
        found = cell_velocities(mesh, normal_velocities(mesh, u(mesh.points)))
        errors.append(np.median(np.linalg.norm(found.values - u(mesh.circumcenters), axis=1)))
    assert 0.8 < order(*errors, sides[1] / sides[0]) < 1.5


# --- from cells to vertices ---------------------------------------------------------------------


def linear_fields_are_reproduced(weights, mesh: SimplexMesh, tolerance: float) -> None:
    """The rows must sum to one, and their product with the circumcentres must be x_i."""
    w = weights(mesh)
    assert_close(w.sum(axis=1), np.ones(len(mesh.points)), tolerance)
    assert_close(w @ mesh.circumcenters, mesh.points, tolerance)


def test_affine_fields_are_reproduced_at_the_vertices(mesh):
    """Interior weights are Voronoi coordinates; boundary weights are least-squares fits."""
    linear_fields_are_reproduced(circumcenter_weights, mesh, EXACT)
    u = affine(mesh, 9)
    found = vertex_velocities_from_cells(mesh, u(mesh.circumcenters))
    size = np.abs(u(mesh.circumcenters)).max()  # far circumcentres have large values
    assert_close(found / size, u(mesh.points) / size, EXACT)


def voronoi_everywhere(mesh: SimplexMesh):
    """Mutant: the formula for closed cells, also at the boundary."""
    incidence = mesh.vertex_cell_incidence.tocoo()
    w = []
    for i, c in zip(*incidence.coords, strict=True):
        others = mesh.cells[c][mesh.cells[c] != i]
        squared = ((mesh.points[others] - mesh.points[i]) ** 2).sum(axis=1)
        w.append(mesh.cell_measures[c] / squared.prod())
    matrix = incidence.astype(float)
    matrix.data = np.array(w)
    total = matrix.sum(axis=1)
    matrix.data = matrix.data / total[matrix.coords[0]]
    return matrix.tocsr()


def test_the_voronoi_formula_is_wrong_at_the_boundary():
    """The star of a boundary vertex is open, and the weights do not reproduce the vertex."""
    with pytest.raises(AssertionError, match="deviates"):
        linear_fields_are_reproduced(voronoi_everywhere, MESHES["jittered 2-D"], 0.01)


def test_interior_weights_equal_the_formula_of_the_slides(mesh):
    """V_a / Π l_ib², positive, on the cells of the vertex only."""
    w, slides = circumcenter_weights(mesh), voronoi_everywhere(mesh)
    inside = np.flatnonzero(~mesh.boundary_vertices)
    assert_close(w[inside].toarray(), slides[inside].toarray(), 1e-12)
    assert w[inside].data.min() > 0


def test_boundary_weights_are_those_of_a_moving_least_squares_fit(mesh):
    """Of an affine function to the circumcentres that count, with the weight 1/(r² + ρ²)."""
    vertices = np.flatnonzero(mesh.boundary_vertices)[::20]
    weights = circumcenter_weights(mesh, vertices)
    for k, i in enumerate(vertices):
        row = weights[[k]]
        away = mesh.circumcenters[row.indices] - mesh.points[i]
        r = np.linalg.norm(away, axis=1)
        w = 1 / (r**2 + r.min() ** 2)
        b = np.column_stack([np.ones(len(r)), away / np.median(r)])
        assert_close(row.data, (np.linalg.pinv(w[:, None] * b) * w)[0], 1e-9)
        assert set(np.flatnonzero((mesh.cells == i).any(axis=1))) <= set(row.indices)


@pytest.mark.parametrize("unit", [1e-100, 1e100])
def test_the_weights_do_not_depend_on_the_unit(mesh, unit):
    """Squares of lengths do not overflow or underflow."""
    scaled = SimplexMesh(mesh.points * unit, mesh.cells)
    assert_close(circumcenter_weights(scaled).toarray(), circumcenter_weights(mesh).toarray(), 1e-8)


def test_weights_have_the_order_of_the_requested_vertices(mesh):
    """Interior and boundary vertices are mixed, and one is requested twice."""
    some = np.random.default_rng(10).integers(0, len(mesh.points), 30)
    wanted = circumcenter_weights(mesh)[some].toarray()
    assert_close(circumcenter_weights(mesh, some).toarray(), wanted, 1e-11)
    assert circumcenter_weights(mesh, []).shape == (0, len(mesh.cells))


@pytest.mark.slow
@pytest.mark.parametrize(("u", "d", "sides"), [(taylor_green, 2, (16, 64)), (abc_flow, 3, (8, 16))])
def test_vertex_velocities_of_smooth_fields_are_of_second_order(u, d, sides):
    """This holds at interior and at boundary vertices."""
    errors = []
    for side in sides:
        mesh = jittered_mesh(side, d, 11)
        error = vertex_velocities_from_cells(mesh, u(mesh.circumcenters)) - u(mesh.points)
        edge = mesh.boundary_vertices
        errors.append((rms(error[~edge]), np.median(np.linalg.norm(error[edge], axis=1))))
    for coarse, fine in zip(*errors, strict=True):
        assert 1.7 < order(coarse, fine, sides[1] / sides[0]) < 2.7


# --- refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: cell_velocities(m, np.zeros(7)), "v must have one entry for each face"),
        (lambda m: raviart_thomas(m, np.zeros(len(m.faces)), [[0, 0]]), "x must be one point for"),
        (lambda m: vertex_velocities_from_cells(m, np.zeros((5, 2))), "entry for each cell"),
        (
            lambda m: vertex_velocities_from_cells(m, np.zeros(len(m.cells))),
            "u must have 2 components for each cell",
        ),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call(MESHES["random 2-D"])


def test_one_cell_does_not_determine_an_affine_field():
    """The message names the vertex."""
    mesh = SimplexMesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]])
    words = "the 1 circumcentres that count about vertex 0 do not determine an affine field"
    with pytest.raises(np.linalg.LinAlgError, match=words):
        vertex_velocities_from_cells(mesh, np.zeros((1, 2)))


def test_a_number_for_each_of_two_cells_in_the_plane_is_no_velocity():
    """There are as many numbers as a velocity has components."""
    square = SimplexMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(ValueError, match="u must have 2 components for each cell"):
        vertex_velocities_from_cells(square, [1.0, 2.0])
