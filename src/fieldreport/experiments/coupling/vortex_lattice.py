"""Thin wings in a steady subsonic flow: a lattice of horseshoe vortices in the wing's plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.linalg import lu_factor, lu_solve

from fieldrecon._core import validation as valid
from fieldrecon._core.blas_threads import blas_threads_for


class VortexLattice:
    """A thin, nearly flat wing in a uniform stream along x, and its mirror image at y < 0.

    The wing is cut into panels. On each, a horseshoe vortex of circulation Γ lies at a quarter of
    the panel's chord and trails to infinity; at three quarters of the chord, at mid-span of the
    panel, the total flow is tangential to the wing: with γ = Γ / U,

        A γ = -θ,   θ = incidence, nose up.

    Subsonic compressible flow equals incompressible flow about the wing stretched along the
    stream by 1 / √(1 - M²), with the same slopes and the same circulations (Prandtl, Glauert,
    Göthert). A panel of width Δy carries the force 2 q γ Δy, with q the dynamic pressure.

    Parameters
    ----------
    corners : (a + 1, b + 1, 2) array_like
        Corners of the panels in the plane: a panels from front to back, b from the root at y = 0
        to the tip. The corners of each column have the same y.
    mach : float
        Mach number M of the stream, below one.

    Attributes
    ----------
    points : (m, 2) ndarray
        The corners, m = (a + 1) (b + 1).
    spans : (a, b) ndarray
        Widths Δy of the panels.
    chords : (a, b) ndarray
        Mean lengths of the panels along the stream.
    area : float
        Area of the half wing.

    Raises
    ------
    ValueError
        If an argument has the wrong form, panels are inverted, or the flow is not subsonic.

    Notes
    -----
    Small disturbances: incidences and Mach numbers at which no shock appears. Without friction.

    References
    ----------
    Katz and Plotkin, Low-Speed Aerodynamics (2001); James (1972), for
    the quarters.

    Examples
    --------
    >>> import numpy as np
    >>> x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 500, 9), indexing="ij")
    >>> lattice = VortexLattice(np.stack([x, y], axis=-1))  # so long that it is nearly 2-D
    >>> gamma = lattice.circulations(np.full((4, 8), 0.1))
    >>> round(float(lattice.lift_coefficient(gamma) / 0.1 / (2 * np.pi)), 2)
    1.0
    """

    def __init__(self, corners: ArrayLike, mach: float = 0.0) -> None:
        grid = np.array(corners, dtype=float)
        if grid.ndim != 3 or grid.shape[2] != 2 or min(grid.shape[:2]) < 2:
            raise ValueError(f"corners must have the shape (a + 1, b + 1, 2); got {grid.shape}")
        if not 0 <= mach < 1:
            raise ValueError(f"mach must be 0 or more, and less than 1; got {mach!r}")
        self.points = valid.as_points(grid.reshape(-1, 2), "corners")
        self.shape = (grid.shape[0] - 1, grid.shape[1] - 1)
        self.spans, sides = _sizes(grid)
        self.chords = (sides[:, 1:] + sides[:, :-1]) / 2
        self.area = float((self.spans * self.chords).sum())
        self._slopes = _slope_operator(sides)
        self._bound = _corner_weights(self.shape, front=3 / 4)
        stretched = grid / [np.sqrt(1 - mach**2), 1.0]
        with blas_threads_for(2 * self.spans.size**3 / 3):
            self._factor = lu_factor(_downwash(stretched))

    def incidences(self, heights: ArrayLike) -> np.ndarray:
        """Incidences -∂z/∂x (a, b, ...) of the panels, from the heights (m, ...) of the corners."""
        z = valid.as_values(heights, len(self.points), "heights", "corner")
        return (self._slopes @ z.reshape(len(z), -1)).reshape(*self.shape, *z.shape[1:])

    def circulations(self, incidences: ArrayLike) -> np.ndarray:
        """Circulations γ = Γ / U (a, b, ...), lengths, at incidences (a, b, ...) in radians."""
        theta = np.asarray(incidences, dtype=float)
        if theta.shape[:2] != self.shape or not np.isfinite(theta).all():
            raise ValueError(
                f"incidences must be finite numbers of the shape {(*self.shape, '...')}; "
                f"got the shape {theta.shape}"
            )
        panels = theta.reshape(self.spans.size, -1)
        return lu_solve(self._factor, -panels).reshape(theta.shape)

    def forces(self, circulations: ArrayLike) -> np.ndarray:
        """Forces upwards at the corners (m, ...), divided by the dynamic pressure.

        Each panel's 2 γ Δy acts at the midpoint of its vortex and is distributed to its corners by
        the transpose of the interpolation between them, which conserves force, moment and work.
        """
        gamma = np.asarray(circulations, dtype=float)
        tail = gamma.shape[2:]
        panels = gamma.reshape(self.spans.size, -1) * 2 * self.spans.reshape(-1, 1)
        return (self._bound.T @ panels).reshape(len(self.points), *tail)

    def pressures(self, circulations: ArrayLike) -> np.ndarray:
        """Pressure below less pressure above, over the dynamic pressure: 2 γ / Δx, (a, b)."""
        return 2 * np.asarray(circulations, dtype=float) / self.chords

    def lift_coefficient(self, circulations: ArrayLike) -> float:
        """Lift over dynamic pressure and area."""
        return float(2 * (np.asarray(circulations, dtype=float) * self.spans).sum() / self.area)


def _sizes(grid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Widths (a, b) of the panels, and lengths (a, b + 1) of their sides along the stream."""
    sides = np.diff(grid[..., 0], axis=0)
    widths = np.diff(grid[..., 1], axis=1)
    if not (sides > 0).all() or not (widths > 0).all():
        raise ValueError("corners must run from front to back, and from the root to the tip")
    if np.ptp(grid[..., 1], axis=0).max() > 1e-9 * np.ptp(grid[..., 1]) or grid[0, 0, 1] != 0:
        raise ValueError("corners must have one y in each column, and y = 0 in the first")
    return (widths[1:] + widths[:-1]) / 2, sides


def _corner_numbers(shape: tuple[int, int]) -> np.ndarray:
    """Corners (a b, 4) of the panels: front left, front right, back left, back right."""
    a, b = shape
    number = np.arange((a + 1) * (b + 1)).reshape(a + 1, b + 1)
    four = (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])
    return np.stack([corner.ravel() for corner in four], axis=1)


def _on_corners(shape: tuple[int, int], entries: np.ndarray) -> sparse.csr_array:
    """Matrix (a b, m) with four entries for each panel."""
    columns = _corner_numbers(shape)
    rows = np.repeat(np.arange(len(columns)), 4)
    m = (shape[0] + 1) * (shape[1] + 1)
    return sparse.csr_array((entries.ravel(), (rows, columns.ravel())), shape=(len(columns), m))


def _corner_weights(shape: tuple[int, int], front: float) -> sparse.csr_array:
    """Interpolation to a part of the chord of the panels, in their middle."""
    weights = np.array([front, front, 1 - front, 1 - front]) / 2
    return _on_corners(shape, np.tile(weights, (shape[0] * shape[1], 1)))


def _slope_operator(sides: np.ndarray) -> sparse.csr_array:
    """Mean over both sides of a panel of how much it falls from front to back."""
    left, right = 1 / sides[:, :-1].ravel(), 1 / sides[:, 1:].ravel()
    shape = (sides.shape[0], sides.shape[1] - 1)
    return _on_corners(shape, np.stack([left, right, -left, -right], axis=1) / 2)


def _downwash(grid: np.ndarray) -> np.ndarray:
    """Velocities upwards (p, p) at the panels by horseshoes of circulation one, and mirrored."""
    bound = 3 / 4 * grid[:-1] + 1 / 4 * grid[1:]
    left, right = (side.reshape(-1, 2) for side in (bound[:, :-1], bound[:, 1:]))
    rear = 1 / 4 * grid[:-1] + 3 / 4 * grid[1:]
    control = ((rear[:, :-1] + rear[:, 1:]) / 2).reshape(-1, 1, 2)
    return _horseshoe(control, left, right) + _horseshoe(control * [1, -1], left, right)


def _horseshoe(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Velocity upwards at p of a vortex from behind to a, to b, and back, by Biot and Savart."""
    to_a, to_b = p - a, p - b
    far_a, far_b = np.linalg.norm(to_a, axis=-1), np.linalg.norm(to_b, axis=-1)
    across = to_a[..., 0] * to_b[..., 1] - to_a[..., 1] * to_b[..., 0]
    along = to_a / far_a[..., None] - to_b / far_b[..., None]
    bound = ((b - a) * along).sum(axis=-1) / across
    trailing = [(1 + r[..., 0] / far) / r[..., 1] for r, far in ((to_b, far_b), (to_a, far_a))]
    return (bound + trailing[0] - trailing[1]) / (4 * np.pi)
