"""What interpolates scattered data: the methods compared, by the names in tables and pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks import our_methods as ours
from benchmarks import peer_methods as peers

Interpolant = Callable[[np.ndarray], np.ndarray]
NOISE = ("noisy",)
WITHOUT_NOISE = ("smooth", "front", "clusters", "cube", "terrain")
FLAT = (2,)


@dataclass(frozen=True)
class Contestant:
    """A method, and what it is asked.

    Parameters
    ----------
    name : str
        As it stands in tables and pictures.
    fit : callable
        ``fit(points, values)`` returns a function of queries (m, d).
    most : int
        Beyond so many sites it would not fit into memory, or not end.
    dimensions : tuple of int
        In which it works.
    data : tuple of str
        The sets of data that its settings are for.
    """

    name: str
    fit: Callable[[np.ndarray, np.ndarray], Interpolant]
    most: int = 10**9
    dimensions: tuple[int, ...] = (2, 3)
    data: tuple[str, ...] = WITHOUT_NOISE + NOISE

    def takes(self, data: str, sites: int) -> bool:
        """Whether it is asked about so many sites of these data."""
        d = 3 if data == "cube" else 2
        return sites <= self.most and d in self.dimensions and data in self.data


OURS, SMALL = "fieldrecon patches", "fieldrecon patches of 32"
CONTESTANTS = {
    c.name: c
    for c in (
        Contestant(OURS, ours.patches),
        Contestant(SMALL, ours.patches_of(3, 3, 32), dimensions=FLAT, data=WITHOUT_NOISE),
        Contestant("fieldrecon patches, r⁴ log r", ours.patches_of(4, 2, 120), dimensions=FLAT),
        Contestant(
            "fieldrecon patches, r⁷", ours.patches_of(7, 4, 60), dimensions=FLAT, data=WITHOUT_NOISE
        ),
        Contestant(
            "fieldrecon patches, by leave-one-out",
            ours.patches_by_leave_one_out,
            dimensions=FLAT,
            data=WITHOUT_NOISE,
        ),
        Contestant("fieldrecon MLS, degree 2", ours.moving_least_squares(2)),
        Contestant("fieldrecon RBF", ours.thin_plate, 10**4),
        Contestant(
            "fieldrecon MLS, 200 neighbours",
            ours.moving_least_squares(2, 200),
            dimensions=FLAT,
            data=NOISE,
        ),
        Contestant("fieldrecon RBF, 1000 means", ours.smoothed_means(1000), data=NOISE),
        Contestant("fieldrecon patches, 4000 means", ours.smoothed_means(4000), data=NOISE),
        Contestant("SciPy RBF", peers.scipy_rbf(), 10**4),
        Contestant("SciPy RBF, 30 neighbours", peers.scipy_rbf(neighbors=30)),
        Contestant(
            "SciPy RBF, r³, 40 neighbours",
            peers.scipy_rbf(neighbors=40, kernel="cubic", degree=3),
            dimensions=FLAT,
        ),
        Contestant(
            "SciPy RBF, r³, smoothed",
            peers.scipy_rbf(kernel="cubic", smoothing=1e-3),
            10**4,
            data=NOISE,
        ),
        Contestant(
            "SciPy RBF, 50 neighbours, smoothed",
            peers.scipy_rbf(neighbors=50, smoothing=0.1),
            data=NOISE,
        ),
        Contestant("SciPy LinearND", peers.scipy_linear),
        Contestant("SciPy CloughTocher2D", peers.scipy_clough_tocher, dimensions=FLAT),
        Contestant("ferreus_rbf, thin plate", peers.ferreus("ThinPlateSpline")),
        Contestant("ferreus_rbf, r³", peers.ferreus("Cubic")),
        Contestant("ferreus_rbf, r³, smoothed", peers.ferreus("Cubic", 1e-3), data=NOISE),
        Contestant("wlsqm, degree 2", peers.wlsqm(2, 20), dimensions=FLAT),
        Contestant("wlsqm, degree 4", peers.wlsqm(4, 40), dimensions=FLAT),
        Contestant("wlsqm, 200 neighbours", peers.wlsqm(2, 200), dimensions=FLAT, data=NOISE),
        Contestant("verde Spline", peers.verde(), 4_000, dimensions=FLAT),
        Contestant("verde Spline, 2000 means", peers.verde(2000, 1e-8), 10**5, FLAT, WITHOUT_NOISE),
        Contestant("verde Spline, 2000 means, damped", peers.verde(2000, 1e-4), 10**5, FLAT, NOISE),
        Contestant("scikit-learn GP", peers.gaussian_process(), 1_000, data=WITHOUT_NOISE),
        Contestant(
            "scikit-learn GP, with noise", peers.gaussian_process(noise=True), 1_000, data=NOISE
        ),
    )
}
