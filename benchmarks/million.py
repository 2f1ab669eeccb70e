"""A million sites, compared with ferreus_rbf and SciPy on an idle machine.

These are the largest sizes of `peers` only, so that they can wait until the machine is idle. Their
ratios are stated here only. In each of three rounds every method has its turn, in a new process.
"""

from __future__ import annotations

from benchmarks import peers
from benchmarks.compared_methods import OURS
from benchmarks.peers import LARGEST, LARGEST_METHODS, Size
from benchmarks.timing import BenchmarkResult, Track

SITES = tuple((data, (sites,)) for data, sites in LARGEST)
FULL = Size(SITES, repeats=1, rounds=3, methods=LARGEST_METHODS)
QUICK = Size((("smooth", (10**3,)), ("cube", (10**3,))), repeats=1, methods=LARGEST_METHODS)
TOY = Size((("smooth", (60,)),), repeats=1, rounds=2, methods=(OURS,))


def run(size: Size, track: Track) -> BenchmarkResult:
    """Run a part of the comparison."""
    return peers.run(size, track)
