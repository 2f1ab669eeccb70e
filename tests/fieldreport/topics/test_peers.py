"""The comparison with other libraries: covered runs, losses, and their presentation."""

from dataclasses import replace

import pytest

from fieldreport.experiments import get
from fieldreport.experiments.methods.peers import LIBRARIES, NONE, MethodRun, looks, run, uncovered

PARAMS = get("peers").defaults


def timed(method, seconds, error, sites=1000):
    return MethodRun(
        "smooth", sites, method, seconds / 2, seconds / 2, seconds, seconds, error, 0, 100
    )


OURS = [timed("fieldrecon patches", 1.0, 1e-6), timed("fieldrecon MLS", 0.5, 1e-4)]


@pytest.mark.parametrize(
    ("seconds", "error", "is_lost"),
    [
        (1.1, 1.1e-6, False),
        (1.0, 1e-6, False),
        (1.0, 1e-6 * (1 - 1e-12), False),
        (0.9, 1e-5, True),
        (0.4, 1e-3, True),
        (9.0, 9e-7, True),
        (0.6, 1e-3, False),
    ],
)
def test_a_peer_is_covered_by_what_is_both_as_fast_and_as_accurate(seconds, error, is_lost):
    """Faster by one method of ours and more accurate by another does not cover."""
    peer = timed("SciPy RBF", seconds, error)
    assert uncovered([*OURS, peer]) == [peer] * is_lost


def test_other_sizes_do_not_cover():
    """What is fast on fewer sites says nothing about more."""
    peer = timed("SciPy RBF", 2.0, 1e-3, sites=10_000)
    assert uncovered([*OURS, peer]) == [peer]


def test_every_run_is_covered_or_told():
    """The table of losses and what is covered make up all runs of peers; each row is a loss."""
    result = run(PARAMS)
    runs = [MethodRun(*row) for row in result.tables["runs"].rows]
    lost = result.tables["lost"]
    assert len(lost.rows) == result.facts["lost"]
    for error, ours in zip(lost.column("its error"), lost.column("our error by then"), strict=True):
        assert ours == NONE or ours > error
    for took, ours in zip(
        lost.column("its seconds"), lost.column("our seconds to that error"), strict=True
    ):
        assert ours == NONE or ours > took
    covered = sum(
        any(o.covers(r) for o in runs if o.ours and o[:2] == r[:2]) for r in runs if not r.ours
    )
    assert covered + len(lost.rows) == result.facts["peers_runs"]


def test_larger_clouds_are_counted_from_where_the_parameter_says():
    """With a bound above all sizes there is nothing to lose."""
    facts = run(replace(PARAMS, large=10**9)).facts
    assert facts["lost_large"] == facts["peers_runs_large"] == 0


def test_no_two_methods_look_alike():
    """Colour and marker together tell every method of the comparison from all others."""
    methods = dict.fromkeys(get("peers").run().tables["runs"].column("method"))
    drawn = looks(methods).values()
    assert len({(look["color"], look["marker"]) for look in drawn}) == len(methods)
    assert len({color for color, _ in LIBRARIES.values()}) == len(LIBRARIES)
