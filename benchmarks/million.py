"""A million sites, beside ferreus_rbf and SciPy, with the machine to themselves.

The largest sizes of `peers` once more, and only these: short enough to find a machine at rest.
"""

from __future__ import annotations

from benchmarks import peers
from benchmarks.contestants import OURS, SMALL
from benchmarks.measure import Outcome, Track
from benchmarks.peers import Size

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


def run(size: Size, track: Track) -> Outcome:
    """Run some of the comparison."""
    return peers.run(size, track)
