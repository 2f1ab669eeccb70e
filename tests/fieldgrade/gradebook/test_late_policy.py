"""What a late hand-in costs: the mathematics of the policy, and the tables it is read from."""

import inspect
from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.class_folder import late_policy
from fieldgrade.class_folder.late_policy import (
    LatePolicy,
    days_late,
    late_factor,
    moment,
    read_extensions,
)

DUE = moment("2026-11-30T23:59+01:00")
seconds = st.integers(-10 * 86400, 10 * 86400)
policies = st.builds(
    LatePolicy,
    st.just(DUE),
    st.integers(0, 3600).map(lambda s: timedelta(seconds=s)),
    st.floats(0, 1),
    st.floats(0, 1),
)


def at(offset):
    return DUE + timedelta(seconds=offset)


@given(policies, seconds, st.integers(0, 86400))
def test_later_never_costs_less(policy, offset, more):
    """What is kept does not grow with the time of the hand-in, and lies between 1 - m and 1."""
    assert late_factor(at(offset + more), policy) <= late_factor(at(offset), policy)
    assert 1 - policy.most - 1e-12 <= late_factor(at(offset), policy) <= 1


@given(policies, seconds, seconds)
def test_an_extension_never_hurts(policy, offset, until):
    """With more time as much is kept as without, or more; an earlier date changes nothing."""
    extended = late_factor(at(offset), policy, at(until))
    assert extended >= late_factor(at(offset), policy)
    if until <= 0:
        assert extended == late_factor(at(offset), policy)


@given(policies, seconds, st.integers(-12, 14))
def test_a_moment_is_the_same_in_every_time_zone(policy, offset, hours):
    """The clock on the wall has no say: only the moment has."""
    elsewhere = at(offset).astimezone(timezone(timedelta(hours=hours)))
    assert late_factor(elsewhere, policy) == late_factor(at(offset), policy)


@given(seconds, st.integers(-5000, 5000))
def test_moving_deadline_and_hand_in_together_changes_nothing(offset, days):
    """Only their distance counts: summer time and leap years have no say."""
    shift = timedelta(days=days)
    assert days_late(at(offset) + shift, DUE + shift) == days_late(at(offset), DUE)


@pytest.mark.parametrize(
    ("offset", "days"),
    [(-1, 0), (0, 0), (1, 1), (86400, 1), (86401, 2), (2 * 86400, 2)],
)
def test_each_day_begun_counts(offset, days):
    """A second after the deadline is a day; the deadline itself is in time."""
    assert days_late(at(offset), DUE) == days


def test_the_grace_forgives_and_does_not_move_the_deadline():
    """Within the grace nothing is late; after it the days count from the deadline."""
    grace = timedelta(minutes=15)
    assert days_late(at(900), DUE, grace) == 0
    assert days_late(at(901), DUE, grace) == 1
    assert days_late(at(86400 + 60), DUE, grace) == 2


def test_without_a_deadline_or_a_time_nothing_is_lost():
    """What is not known costs nothing."""
    assert late_factor(None, LatePolicy(DUE, per_day=1.0)) == 1
    assert late_factor(DUE, LatePolicy(None, per_day=1.0)) == 1


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("ceil(over / DAY)", "int(over / DAY)"), ("max(policy.due, until)", "until")],
)
def test_the_laws_catch_a_wrong_policy(right, wrong):
    """Days completed in place of days begun, and extensions that shorten, are found out."""
    source = inspect.getsource(late_policy)
    assert right in source
    mutant = {"__name__": late_policy.__name__}
    exec(compile(source.replace(right, wrong), "mutant", "exec"), mutant)
    policy = LatePolicy(DUE, per_day=0.1)
    begun = mutant["days_late"](at(1), DUE) == 1
    unhurt = mutant["late_factor"](at(0), policy, at(-1)) == 1.0
    assert not (begun and unhurt)


def test_a_time_without_a_zone_is_refused():
    """A time might be any of twenty-four, so the zone is asked for."""
    with pytest.raises(ValueError, match=r"has no time zone: write it as .*\+01:00"):
        moment("2026-11-30T23:59")
    with pytest.raises(ValueError, match="a time must be written as 2026-11-30T23:59"):
        moment("30/11/2026")
    assert moment("2026-11-30T23:59Z") == datetime(2026, 11, 30, 23, 59, tzinfo=UTC)


def test_the_longest_of_several_extensions_counts(tmp_path):
    """Two lines for one student do not depend on their order."""
    file = tmp_path / "extensions.csv"
    lines = ["ada,1,2026-12-04T12:00Z,ill", "ada,01,2026-12-02T12:00Z,moved"]
    for order in (lines, lines[::-1]):
        file.write_text("\n".join(["student,notebook,until,reason", *order]))
        assert read_extensions(file)["ada", "01"].until == moment("2026-12-04T12:00Z")


def test_each_bad_line_is_told_with_its_number(tmp_path):
    """All that is wrong with a table is told at once, line by line."""
    file = tmp_path / "extensions.csv"
    file.write_text(
        "student,notebook,until,reason\nada,01,tomorrow,ill\n\nalan,x,2026-12-04T12:00Z,"
    )
    with pytest.raises(
        ValueError, match=r"(?s)extensions.csv:2: a time .*extensions.csv:4: column reason"
    ):
        read_extensions(file)
