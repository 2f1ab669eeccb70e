"""Cases: every method with sites, queries and tolerances, to which the laws are applied."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from zlib import crc32

import numpy as np
from scipy.stats import ortho_group

from fieldrecon._core import validation as valid
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.functionals import values_at
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.mean import Mean
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.tangent_plane import OnTangentPlane
from fieldrecon.polynomials import dimension
from fieldrecon.reconstruction import Reconstruction
from polytopes import POLYTOPES, voronoi_cell

EXACT = 1e-10
"""Tolerance for answers of size one, for well-conditioned cases."""

FLAT = 1e-7
"""Tolerance for kernels so smooth that their matrix loses nine digits."""

DRAWN = 3
"""Number of arrangements on which a case is tried, each case on others."""

SITES = {1: 24, 2: 45, 3: 70, 5: 120}
EXTREME_UNITS = (1e-150, 3.0, 1e150)
# A smoothing parameter scales with a power of the unit, which must not overflow.
SMOOTHED_UNITS = (1e-40, 3.0, 1e40)


@dataclass(frozen=True)
class Case:
    """A method with its sites and queries.

    `make(points, unit)` constructs it with lengths in multiples of the unit. `distinguishable` says
    whether the residuals of a method that does not interpolate exceed rounding. `removable` says
    whether the method is defined without one of its sites, and `argument` is the name of the
    argument for the sites.
    `arrangements` are those of `ARRANGEMENTS` that the case is tried on, three of them by default,
    and `refuses` says whether the method may refuse such sites.
    """

    name: str
    make: Callable[[np.ndarray, float], Reconstruction]
    d: int
    n: int
    exact: float = EXACT
    distinguishable: bool = True
    units: tuple[float, ...] = EXTREME_UNITS
    removable: bool = True
    argument: str = "points"
    arrangements: tuple[str, ...] = ()
    refuses: bool = True

    @cached_property
    def sites(self) -> np.ndarray:
        """Sites (n, d) in the unit cube, almost equidistant for d = 1."""
        x = np.random.default_rng(self.d).random((self.n, self.d))
        if self.d == 1:
            x = (np.arange(self.n)[:, None] + 0.2 + 0.6 * x) / self.n
        return on_a_lattice(x)

    @cached_property
    def queries(self) -> np.ndarray:
        """Seven queries in the unit cube and one outside."""
        inside = np.random.default_rng(40 + self.d).random((7, self.d))
        outside = np.where(np.arange(self.d) == 0, -0.1, 0.5)
        return on_a_lattice(np.vstack([inside, outside]))

    @cached_property
    def method(self) -> Reconstruction:
        """The method on the sites, with unit 1."""
        return self.make(self.sites, 1.0)

    @cached_property
    def data(self) -> np.ndarray:
        """Smooth data (n,) of size one that are not polynomial."""
        return np.cos(self.sites @ np.linspace(1.0, 3.0, self.d)) + self.sites[:, 0] ** 4

    @property
    def turn(self) -> np.ndarray:
        """An orthogonal matrix (d, d) under which the method is equivariant."""
        return ortho_group.rvs(self.d, random_state=5) if self.d > 1 else -np.eye(1)

    def arranged(self) -> Iterator[tuple[str, np.ndarray]]:
        """Name and sites of each arrangement on which the method is tried."""
        names = [name for name, a in ARRANGEMENTS.items() if self.d >= a.d]
        drawn = np.random.default_rng(crc32(self.name.encode())).permutation(names)[:DRAWN]
        for name in self.arrangements or drawn:
            for sites in ARRANGEMENTS[name].clouds(np.random.default_rng(7), self.n, self.d):
                yield f"{name}, {len(sites)} sites", sites

    @staticmethod
    def around(sites: np.ndarray) -> np.ndarray:
        """Queries beside sites, between two of them, and in a box that is wider than theirs."""
        rng, (n, d) = np.random.default_rng(8), sites.shape
        low, extent = sites.min(axis=0), max(np.ptp(sites, axis=0).max(), 1e-9)
        near = sites[rng.integers(0, n, 4)] + 0.02 * extent * rng.normal(size=(4, d))
        between = (sites[rng.integers(0, n, 3)] + sites[rng.integers(0, n, 3)]) / 2
        return np.vstack([near, between, low + extent * (1.6 * rng.random((6, d)) - 0.3)])

    def without(self, i: int) -> float:
        """The value at site i of the field of the other data."""
        others = np.arange(self.n) != i
        refit = self.make(self.sites[others], 1.0).field(self.data[others])
        return refit(self.sites[i])


@dataclass(frozen=True)
class CornersCase(Case):
    """A method on the corners of a polytope."""

    corners: tuple[tuple[float, ...], ...] = ()
    removable: bool = False
    refuses: bool = False

    @cached_property
    def sites(self) -> np.ndarray:
        """The corners, near or in the unit cube."""
        return on_a_lattice(np.array(self.corners))

    def arranged(self) -> Iterator[tuple[str, np.ndarray]]:
        """The corners mapped to polytopes with the same faces."""
        first, last = np.eye(self.d)[[0, -1]]
        mapped = {
            "thin along the last axis": self.sites * (1 - (1 - 2.0**-20) * last),
            "thin along the first axis": self.sites * (1 - (1 - 2.0**-20) * first),
            "sheared": self.sites + 2.0**10 * self.sites[:, -1:] * first,
            "far away": self.sites + 2.0**20,
        }
        yield from ((name, mapped[name]) for name in self.arrangements or mapped)

    @staticmethod
    def around(sites: np.ndarray) -> np.ndarray:
        """Queries inside, many of them near a corner or a face."""
        return np.random.default_rng(8).dirichlet(np.full(len(sites), 0.3), 13) @ sites


@dataclass(frozen=True)
class PatchesCase(Case):
    """A method on patches with sites (n, d) of any distribution.

    Its boxes are parallel to the axes.
    """

    exact: float = FLAT
    refuses: bool = False
    cloud: Callable[[np.random.Generator, int, int], np.ndarray] | None = None

    @cached_property
    def sites(self) -> np.ndarray:
        """The point set, in the unit cube."""
        if self.cloud is None:
            return super().sites
        return on_a_lattice(self.cloud(np.random.default_rng(self.d), self.n, self.d))

    @property
    def turn(self) -> np.ndarray:
        """A permutation of the axes."""
        return np.roll(np.eye(self.d), 1, axis=0)

    def without(self, i: int) -> float:
        """The blend of radial basis functions on the patches of site i, each fitted without it."""
        total = weights = 0.0
        level = self.method._levels[0]
        for j in range(len(level.patches)):
            systems = level.systems[level.group[j]]
            own = level.sites[systems.sites[level.member[j]]]
            here = self.method._frame.local(self.sites[i])
            weight = level.patches.weights(np.array([j]), here[None, None])[0, 0]
            if i in own and weight > 0:
                frame, others = self.method._frame, own[own != i]
                x = flattened(frame.scaled(self.sites[own]) * frame.scale)
                smoothing = np.broadcast_to(self.method.smoothing, self.n)[others]
                refit = RBF(x[own != i], self.method.kernel, systems.degree, smoothing)
                s = refit.field(self.data[others])
                total += weight * s(x[own == i][0])
                weights += weight
        return total / weights


@dataclass(frozen=True)
class MeanCase(Case):
    """The mean of the methods of several cases on the same sites."""

    parts: tuple[Case, ...] = ()

    @property
    def turn(self) -> np.ndarray:
        """That of one of the parts."""
        return self.parts[0].turn

    def without(self, i: int) -> float:
        """The mean of the values of the parts."""
        return sum(part.without(i) for part in self.parts) / len(self.parts)


def flattened(x: np.ndarray) -> np.ndarray:
    """The same points in coordinates of their affine span."""
    y = x - x.mean(axis=0)
    sigma, vt = np.linalg.svd(y, full_matrices=False)[1:]
    return y @ vt[sigma > 1e-9 * sigma[0]].T


def on_a_lattice(x: np.ndarray) -> np.ndarray:
    """Points with twenty binary digits, so that an offset of 2^20 causes no rounding."""
    return np.round(x * 2.0**20) / 2.0**20


@dataclass(frozen=True)
class Arrangement:
    """Clouds of distinct sites, in at least d variables, that are not in general position."""

    clouds: Callable[[np.random.Generator, int, int], Iterable[np.ndarray]]
    d: int = 1


def one_line(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Across the axes."""
    yield np.sort(rng.random((n, 1)), axis=0) * np.linspace(1.0, 0.3, d)


def two_lines(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Parallel to the first axis, half a unit apart."""
    x = np.zeros((n, d))
    x[:, 0], x[::2, 1] = rng.random(n), 0.5
    yield x


def circle(_: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """About the middle, in the plane of the first two axes."""
    t = 2 * np.pi * np.arange(n) / n
    x = np.full((n, d), 0.5)
    x[:, :2] += np.column_stack([np.cos(t), np.sin(t)]) / 2
    yield x


def on_a_sphere(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """About the middle."""
    x = rng.normal(size=(n, d))
    yield 0.5 + x / np.linalg.norm(x, axis=1)[:, None] / 2


def two_planes(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Across the last axis."""
    x = rng.random((n, d))
    x[:, -1] = np.arange(n) % 2
    yield x


def flight_lines(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Three lines, fifty times as far apart as the sites on them: straight ones, and flown ones."""
    k = np.arange(n)
    x = np.zeros((n, d))
    x[:, 0], x[:, 1] = k // 3, 50 * (k % 3)
    x[:, 2:] = 50 * (k % 3 == 2)[:, None]
    yield x / n
    yield (x + 0.05 * rng.normal(size=x.shape)) / n


def tiny_clusters(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Clusters, 1e-6 wide: eight of them, and two."""
    for k in (8, 2):
        yield rng.random((k, d))[np.arange(n) % k] + 1e-6 * rng.random((n, d))


def an_outlier(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """One site is 1e5 spacings away from the cloud."""
    x = rng.random((n, d))
    x[n // 2] += 1e5 * n ** (-1 / d) * np.linspace(0.3, 0.9, d)
    yield x


def few_sites(rng: np.random.Generator, _: int, d: int) -> Iterator[np.ndarray]:
    """One site to twelve."""
    yield from (rng.random((n, d)) for n in range(1, 13))


def merged_duplicates(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """What is left of sites on a coarse lattice, many of which coincide."""
    yield np.unique(rng.integers(0, 6, (n, d)), axis=0) / 6


def lattice(rng: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """A square lattice, and the same in another order."""
    m = max(2, round(n ** (1 / d)))
    x = np.stack(np.meshgrid(*[np.arange(m) / m] * d), axis=-1).reshape(-1, d)
    yield x
    yield x[rng.permutation(len(x))]


def touching_circles(_: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Beside one of the two, a weight that decreases fast counts points of one conic only."""
    t = 2 * np.pi * (np.arange(n // 2) + 0.5) / (n // 2)
    x = np.full((2 * len(t), d), 0.5)
    x[:, 0] = 2 * np.concatenate([np.cos(t) - 1, 1 - np.cos(t)])
    x[:, 1] = 2 * np.tile(np.sin(t), 2)
    yield x


def helix(_: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """Two turns about the third axis."""
    t = np.linspace(0, 4 * np.pi, n)
    x = np.full((n, d), 0.5)
    x[:, :3] = np.column_stack([np.cos(t), np.sin(t), t / 4])
    yield x


def parabola(_: np.random.Generator, n: int, d: int) -> Iterator[np.ndarray]:
    """In the plane of the first two axes."""
    x = np.full((n, d), 0.5)
    x[:, 0] = np.linspace(-1, 1, n)
    x[:, 1] = x[:, 0] ** 2
    yield x


ARRANGEMENTS = {
    "one line": Arrangement(one_line),
    "two lines": Arrangement(two_lines, 2),
    "circle": Arrangement(circle, 2),
    "sphere": Arrangement(on_a_sphere, 3),
    "two parallel planes": Arrangement(two_planes, 2),
    "flight lines": Arrangement(flight_lines, 2),
    "clusters": Arrangement(tiny_clusters),
    "outlier": Arrangement(an_outlier),
    "few sites": Arrangement(few_sites),
    "merged duplicates": Arrangement(merged_duplicates),
    "lattice": Arrangement(lattice),
    "touching circles": Arrangement(touching_circles, 2),
    "helix": Arrangement(helix, 3),
    "parabola": Arrangement(parabola, 2),
}


def least_squares_cases() -> Iterator[Case]:
    for d in (1, 2, 3, 5):
        for degree in range(4):
            yield Case(
                f"LS degree {degree} in {d}-D",
                lambda p, _, degree=degree: LeastSquares(p, degree),
                d,
                SITES[d],
            )
    for d, degree in ((1, 3), (2, 2), (3, 1)):
        yield Case(
            f"LS as many sites as coefficients, degree {degree} in {d}-D",
            lambda p, _, degree=degree: LeastSquares(p, degree),
            d,
            dimension(d, degree),
            exact=FLAT,
        )


WEIGHTS: dict[str, Callable[[float], Radial]] = {
    "ε = 0": lambda _: inverse_square(0.0),
    "ε = 1e-8": lambda u: inverse_square(1e-8 * u),
    "ε = 0.1": lambda u: inverse_square(0.1 * u),
    "ε = 1": lambda u: inverse_square(u),
    "gaussian": lambda u: gaussian(0.4 * u),
    "inverse multiquadric": lambda u: inverse_multiquadric(0.2 * u),
    "wendland within a radius": lambda u: wendland(3, 1, 0.95 * u),
}
NEAREST_WEIGHTS = {
    "wendland": wendland(3, 2),
    "ε = 0": inverse_square(0.0),
    "gaussian": gaussian(0.6),
}


def moving_cases() -> Iterator[Case]:
    for name, weight in WEIGHTS.items():
        for d, degree in [(2, 0), (2, 1), (2, 2), (2, 3), (1, 1), (1, 3), (3, 1), (3, 2)]:
            yield Case(
                f"MLS {name}, degree {degree} in {d}-D",
                lambda p, u, w=weight, degree=degree: MovingLeastSquares(p, w(u), degree),
                d,
                SITES[d],
                exact=1e-9,
                distinguishable=name != "ε = 1e-8",
            )
    for name, near in NEAREST_WEIGHTS.items():
        for d, degree in [(2, 0), (2, 1), (2, 2), (1, 1), (3, 1), (3, 2)]:
            k = 2 * dimension(d, degree) + d
            yield Case(
                f"MLS {name} on {k} nearest, degree {degree} in {d}-D",
                lambda p, _, w=near, degree=degree, k=k: MovingLeastSquares(p, w, degree, k),
                d,
                SITES[d],
                exact=1e-9,
            )
    yield Case(
        "MLS gaussian on 100 nearest, degree 1 in 5-D",
        lambda p, _: MovingLeastSquares(p, gaussian(0.6), 1, 100),
        5,
        SITES[5],
    )
    yield Case(
        "MLS as many nearest as coefficients",
        lambda p, _: MovingLeastSquares(p, gaussian(1.0), 1, 2),
        1,
        SITES[1],
    )


KERNELS: dict[str, Callable[[float], Radial]] = {
    "thin plate": lambda _: thin_plate_spline(),
    "r": lambda _: polyharmonic(1),
    "r² log r": lambda _: polyharmonic(2),
    "r³": lambda _: polyharmonic(3),
    "r⁴ log r": lambda _: polyharmonic(4),
    "r⁵": lambda _: polyharmonic(5),
    "multiquadric": lambda u: multiquadric(0.2 * u),
    "inverse multiquadric": lambda u: inverse_multiquadric(0.2 * u),
    "gaussian": lambda u: gaussian(0.2 * u),
    "exponential": lambda u: matern(0.5, 0.4 * u),
    "Matérn 3/2": lambda u: matern(1.5, 0.3 * u),
    "Matérn 5/2": lambda u: matern(2.5, 0.2 * u),
    "Wendland 0": lambda u: wendland(3, 0, 0.8 * u),
    "Wendland 1": lambda u: wendland(3, 1, 0.8 * u),
    "Wendland 2": lambda u: wendland(3, 2, 0.8 * u),
    "Wendland 3": lambda u: wendland(3, 3, 0.8 * u),
    "ε = 0.3": lambda u: inverse_square(0.3 * u),
}


def rbf_cases() -> Iterator[Case]:
    for name, kernel in KERNELS.items():
        for d, spread in ((1, 0.4), (2, 1.0), (3, 1.0)):
            yield Case(
                f"RBF {name} in {d}-D",
                lambda p, u, kernel=kernel, spread=spread: RBF(p, kernel(spread * u)),
                d,
                SITES[d],
                exact=FLAT,
            )
        power = kernel(1.0).homogeneity
        yield Case(
            f"RBF {name}, one degree more, smoothed, in 2-D",
            lambda p, u, kernel=kernel, power=power: RBF(
                p, kernel(u), kernel(u).order, 1e-3 * u**power
            ),
            2,
            SITES[2],
            units=SMOOTHED_UNITS,
        )
    for name, degree, smoothing in (("", None, 0.0), (", a plane and smoothing", 1, 1e-3)):
        yield Case(
            f"RBF Wendland 2 on near pairs{name}, in 2-D",
            lambda p, u, degree=degree, smoothing=smoothing: RBF(
                p, wendland(3, 2, 0.1 * u), degree, smoothing
            ),
            2,
            400,
            exact=FLAT,
            units=EXTREME_UNITS if smoothing == 0 else SMOOTHED_UNITS,
        )
    yield Case("RBF r³ with cubics in 2-D", lambda p, _: RBF(p, polyharmonic(3), 3), 2, SITES[2])


def hermite_cases() -> Iterator[Case]:
    """Hermite interpolation of values only, which the laws can treat like any other method."""
    kernels = ("r³", "r⁴ log r", "gaussian", "Wendland 2")
    for name, d in product(kernels, (1, 2, 3)):
        spread = 0.4 if d == 1 else 1.0
        yield Case(
            f"Hermite {name} in {d}-D",
            lambda p, u, kernel=KERNELS[name], spread=spread: HermiteRBF(
                values_at(p), kernel(spread * u)
            ),
            d,
            SITES[d],
            exact=FLAT,
        )


class SplineWithAxis(NaturalCubicSpline):
    """The spline with the interface of the other methods: points (n, 1), queries (..., 1)."""

    _queries = Reconstruction._queries
    field = Reconstruction.field
    _made = classmethod(lambda cls, points, **how: cls(points, **how))

    def __init__(self, points, *, executor=None, progress=None):
        super().__init__(valid.as_points(points)[:, 0], executor=executor, progress=progress)


def spline_cases() -> Iterator[Case]:
    def make(p, _):
        return SplineWithAxis(p)

    yield Case("natural spline", make, 1, SITES[1])
    yield Case("natural spline on four sites", make, 1, 4)


def polytope_cases() -> Iterator[Case]:
    for name, corners in POLYTOPES.items():
        n, d = corners.shape
        shape = {"d": d, "n": n, "corners": tuple(map(tuple, corners.tolist()))}
        yield CornersCase(
            f"coordinates of the {name}",
            lambda p, _: BarycentricCoordinates(p),
            argument="vertices",
            **shape,
        )
        # the computation of the circumcentres loses a digit or two, and of thin cells all
        yield CornersCase(
            f"Voronoi cell, a {name}",
            lambda p, _: voronoi_cell(p),
            exact=1e-9,
            arrangements=("far away",),
            **shape,
        )


def clusters(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Half of the sites lie in a cube of side 1/20."""
    x = rng.random((n, d))
    x[::2] = 0.3 + 0.05 * x[::2]
    return x


def hole(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """No site lies within 0.3 of the centre."""
    x = 2 * rng.random((8 * n, d)) - 1
    return 0.5 + x[np.linalg.norm(x, axis=1) > 0.6][:n] / 2


def line(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Sites on the diagonal of the cube."""
    t = on_a_lattice(((np.arange(n) + 0.2 + 0.6 * rng.random(n)) / n)[:, None])
    return np.repeat(t, d, axis=1)


def plane(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """The last coordinate is the sum of the others."""
    x = on_a_lattice(rng.random((n, d - 1)) / (d - 1))
    return np.column_stack([x, x.sum(axis=1)])


def sphere(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Sites on a sphere about the centre of the cube, rounded to the lattice."""
    x = rng.normal(size=(n, d))
    return 0.5 + x / np.linalg.norm(x, axis=1)[:, None] / 2


def tracks(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Dense sites along distant scan lines."""
    along = (np.arange(n // 8) + 0.5) / (n // 8)
    across = (np.arange(8) + 0.5) / 8
    x = np.stack(np.meshgrid(along, across), axis=-1).reshape(-1, 2)
    return x + 1e-4 * rng.random((n, d))


def partition_cases() -> Iterator[Case]:
    sizes = {1: (80, 10), 2: (130, 16), 3: (180, 25), 4: (200, 30), 6: (260, 60)}
    for d, (n, k) in sizes.items():
        for name, degree in (("r³", 1), ("r⁵", 2), ("r³", 3)):
            if d <= 3 or degree == 1:
                yield PatchesCase(
                    f"PU {name} on {k} sites, degree {degree} in {d}-D",
                    lambda p, u, kernel=KERNELS[name], degree=degree, k=k: PartitionOfUnityRBF(
                        p, kernel(u), degree, k
                    ),
                    d,
                    n,
                )
    for name in ("thin plate", "r⁴ log r", "gaussian", "inverse multiquadric", "Wendland 2"):
        degree = max(1, KERNELS[name](1.0).order - 1)
        yield PatchesCase(
            f"PU {name} in 2-D",
            lambda p, u, kernel=KERNELS[name], degree=degree: PartitionOfUnityRBF(
                p, kernel(u), degree, 16
            ),
            2,
            130,
        )
    for cloud, d, n in (
        (clusters, 2, 150),
        (hole, 2, 150),
        (line, 3, 90),
        (plane, 3, 150),
        (sphere, 3, 180),
        (tracks, 2, 160),
    ):
        yield PatchesCase(
            f"PU, {cloud.__name__} in {d}-D",
            lambda p, _: PartitionOfUnityRBF(p, polyharmonic(3), 1, 14),
            d,
            n,
            cloud=cloud,
        )
    yield PatchesCase(
        "PU r³ smoothed in 2-D",
        lambda p, u: PartitionOfUnityRBF(p, polyharmonic(3), 1, 16, 1e-3 * u**3),
        2,
        130,
        units=SMOOTHED_UNITS,
    )
    for d in (1, 2, 3):
        yield PatchesCase(
            f"PU with one patch in {d}-D", lambda p, _: PartitionOfUnityRBF(p), d, SITES[d]
        )


@dataclass(frozen=True)
class MetricCase(Case):
    """A method with a metric, whose axes only the symmetries of the metric may turn."""

    symmetry: tuple[tuple[float, ...], ...] = ()

    @property
    def turn(self) -> np.ndarray:
        """An orthogonal matrix (d, d) that leaves the metric as it is."""
        return np.array(self.symmetry)


@dataclass(frozen=True)
class MetricPatchesCase(PatchesCase, MetricCase):
    """Patches with a metric."""

    @property
    def turn(self) -> np.ndarray:
        """A permutation of the axes that leaves the metric as it is."""
        return np.array(self.symmetry)


def metric_cases() -> Iterator[Case]:
    oblique, swap = [[2.0, 1.0], [1.0, 2.0]], ((0.0, 1.0), (1.0, 0.0))
    yield MetricCase(
        "RBF gaussian with a metric in 2-D",
        lambda p, u: RBF(p, gaussian(0.3 * u), 1, metric=oblique),
        2,
        SITES[2],
        exact=FLAT,
        symmetry=swap,
    )
    yield MetricCase(
        "MLS wendland on 8 nearest, degree 1, with a metric in 2-D",
        lambda p, _: MovingLeastSquares(p, wendland(3, 2), 1, 8, metric=oblique),
        2,
        SITES[2],
        exact=1e-9,
        symmetry=swap,
    )
    yield MetricPatchesCase(
        "PU r³ on 16 sites, degree 1, with scales in 3-D",
        lambda p, _: PartitionOfUnityRBF(p, polyharmonic(3), 1, 16, metric=[1.5, 0.4, 0.4]),
        3,
        130,
        symmetry=((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    )


def mean_of(*parts: Case, units: tuple[float, ...] = EXTREME_UNITS) -> MeanCase:
    def make(p: np.ndarray, unit: float) -> Mean:
        return Mean(p, [lambda q, part=part: part.make(q, unit) for part in parts])

    names = ", ".join(part.name for part in parts)
    return MeanCase(
        f"mean of {names}", make, parts[0].d, parts[0].n, exact=FLAT, units=units, parts=parts
    )


def mean_cases() -> Iterator[Case]:
    """Means of methods of equal and of different degrees, with dense and with sparse weights."""
    plane = Case("LS degree 1", lambda p, _: LeastSquares(p, 1), 2, SITES[2])
    cubic = Case("RBF r³", lambda p, _: RBF(p, polyharmonic(3), 2), 2, SITES[2])
    yield mean_of(cubic, plane)
    n = 180
    patches = PatchesCase(
        "PU r³", lambda p, _: PartitionOfUnityRBF(p, polyharmonic(3), 1, 25), 3, n
    )
    moving = Case("MLS", lambda p, _: MovingLeastSquares(p, wendland(3, 1), 1, 10), 3, n)
    yield mean_of(patches, moving)
    rough = PatchesCase(
        "PU r smoothed",
        lambda p, u: PartitionOfUnityRBF(p, polyharmonic(1), 0, 16, 1e-3 * u),
        2,
        130,
    )
    plates = PatchesCase(
        "PU plates smoothed",
        lambda p, u: PartitionOfUnityRBF(p, thin_plate_spline(), 1, 16, 1e-3 * u**2),
        2,
        130,
    )
    yield mean_of(rough, plates, units=SMOOTHED_UNITS)


@dataclass(frozen=True)
class GlobeCase(Case):
    """A method at longitudes and latitudes, which the laws about points of a space are not for."""

    def arranged(self) -> Iterator[tuple[str, np.ndarray]]:
        """The arrangements in the plane, in a region of forty degrees across the date line."""
        for name, sites in super().arranged():
            extent = max(np.ptp(sites, axis=0).max(), 1e-9)
            yield name, 40 * (sites - sites.min(axis=0)) / extent + [160.0, 35.0]


def globe_cases() -> Iterator[Case]:
    """Methods in space, and in the tangent plane of the region."""

    def case(name: str, make: Callable[[np.ndarray], Reconstruction], refuses: bool) -> Case:
        return GlobeCase(name, lambda p, _: OnGlobe(p, make), 2, SITES[2], refuses=refuses)

    yield case("globe RBF r³", lambda u: RBF(u, polyharmonic(3)), True)
    yield case("globe MLS", lambda u: MovingLeastSquares(u, inverse_square(0.1), 1), True)
    yield case("globe PU", PartitionOfUnityRBF, False)
    for name, make, refuses in (
        ("LS", lambda q: LeastSquares(q, 2), True),
        ("PU", PartitionOfUnityRBF, False),
    ):
        yield case(f"tangent plane {name}", lambda u, m=make: OnTangentPlane(u, m), refuses)


GLOBE_CASES = [*globe_cases()]

CASES = [
    *least_squares_cases(),
    *moving_cases(),
    *rbf_cases(),
    *hermite_cases(),
    *spline_cases(),
    *partition_cases(),
    *metric_cases(),
    *mean_cases(),
    *polytope_cases(),
]


def case(name: str) -> Case:
    """The case with this name."""
    return next(c for c in CASES if c.name == name)
