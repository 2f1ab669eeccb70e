"""A million sites, compared with ferreus_rbf and SciPy on an idle machine.

These are the largest sizes of `peers` only, so that they can wait until the machine is idle. Their
ratios are stated here only.
"""

from __future__ import annotations

from benchmarks import peers
from benchmarks.compared_methods import OURS
from benchmarks.peers import LARGEST, LARGEST_METHODS, Size
from benchmarks.timing import BenchmarkResult, Track

FULL = Size(tuple((data, (sites,)) for data, sites in LARGEST), methods=LARGEST_METHODS)
QUICK = Size((("smooth", (10**3,)), ("cube", (10**3,))), 1, LARGEST_METHODS)
TOY = Size((("smooth", (60,)),), 1, (OURS,))


def run(size: Size, track: Track) -> BenchmarkResult:
    """Run a part of the comparison."""
    return peers.run(size, track)
