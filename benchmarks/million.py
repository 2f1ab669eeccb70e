"""A million sites, compared with ferreus_rbf and SciPy on an idle machine.

These are the largest sizes of `peers` only, so that they can wait until the machine is idle.
"""

from __future__ import annotations

from benchmarks import peers
from benchmarks.compared_methods import OURS, SMALL
from benchmarks.peers import Size
from benchmarks.timing import BenchmarkResult, Track

METHODS = (
    OURS,
    SMALL,
    "fieldrecon MLS, degree 2",
    "SciPy RBF, r³, 40 neighbours",
    "ferreus_rbf, thin plate",
)
FULL = Size((("smooth", (10**6,)), ("cube", (2 * 10**5,))), methods=METHODS)
QUICK = Size((("smooth", (10**3,)), ("cube", (10**3,))), 1, METHODS)
TOY = Size((("smooth", (60,)),), 1, (OURS,))


def run(size: Size, track: Track) -> BenchmarkResult:
    """Run a part of the comparison."""
    return peers.run(size, track)
