"""The comparison with other libraries: which runs of peers are not matched, and how it is shown."""

from dataclasses import replace

import pytest

from fieldreport.experiments import get
from fieldreport.experiments.methods.peers import (
    CHOSEN,
    KRIGING,
    LIBRARIES,
    LINEAR,
    NONE,
    MethodRun,
    looks,
    on_surveys,
    run,
    uncovered,
)

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
def test_a_peer_is_covered_by_a_method_that_is_as_fast_and_as_accurate(seconds, error, is_lost):
    """A faster method and another more accurate one do not cover it together."""
    peer = timed("SciPy RBF", seconds, error)
    assert uncovered([*OURS, peer]) == [peer] * is_lost


def test_other_sizes_do_not_cover():
    """A fast run on fewer sites implies nothing about more sites."""
    peer = timed("SciPy RBF", 2.0, 1e-3, sites=10_000)
    assert uncovered([*OURS, peer]) == [peer]


def test_every_run_of_a_peer_is_covered_or_listed_as_a_loss():
    """Losses and covered runs together are all runs of peers, and each row is a loss."""
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


def test_large_point_clouds_are_counted_from_the_given_size():
    """With a bound above all sizes no run counts as large."""
    facts = run(replace(PARAMS, large=10**9)).facts
    assert facts["lost_large"] == facts["peers_runs_large"] == 0


def test_each_method_has_its_own_colour_and_marker():
    """Each library has a colour of its own."""
    methods = dict.fromkeys(get("peers").run().tables["runs"].column("method"))
    drawn = looks(methods).values()
    assert len({(look["color"], look["marker"]) for look in drawn}) == len(methods)
    assert len({color for color, _ in LIBRARIES.values()}) == len(LIBRARIES)


def test_on_a_survey_the_chosen_method_is_compared_with_the_best_complete_run():
    """Other methods of ours and runs that leave out queries are not the best peer."""
    small = {CHOSEN: 2.0, KRIGING: 3.0, "SciPy RBF": 1.5, LINEAR: 1.2, "fieldrecon RBF": 1.0}
    large = {CHOSEN: 4.0, "SciPy RBF": 5.0}
    runs = [
        timed(method, 0.5, error, sites)._replace(
            data=f"survey {sites}", left_out=7 * (method == LINEAR)
        )
        for sites, errors in ((100, small), (9999, large))
        for method, error in errors.items()
    ]
    assert on_surveys(runs).rows == (
        ("survey 100", 100, 2.0, 0.5, "SciPy RBF", 0.75, 0.6, 1.5),
        ("survey 9999", 9999, 4.0, 0.5, "SciPy RBF", 1.25, NONE, NONE),
    )
