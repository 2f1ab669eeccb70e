"""The penalty for late submissions: mathematics of the policy, and the tables it is read from."""

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


@pytest.mark.slow
@given(policies, seconds, st.integers(0, 86400))
def test_the_late_factor_never_grows_with_time(policy, offset, more):
    """The factor is between 1 - m and 1, where m is the largest penalty."""
    assert late_factor(at(offset + more), policy) <= late_factor(at(offset), policy)
    assert 1 - policy.most - 1e-12 <= late_factor(at(offset), policy) <= 1


@given(policies, seconds, seconds)
def test_an_extension_never_lowers_the_late_factor(policy, offset, until):
    """An extension that ends before the deadline has no effect."""
    extended = late_factor(at(offset), policy, at(until))
    assert extended >= late_factor(at(offset), policy)
    if until <= 0:
        assert extended == late_factor(at(offset), policy)


@given(policies, seconds, st.integers(-12, 14))
def test_the_late_factor_does_not_depend_on_the_time_zone(policy, offset, hours):
    elsewhere = at(offset).astimezone(timezone(timedelta(hours=hours)))
    assert late_factor(elsewhere, policy) == late_factor(at(offset), policy)


@given(seconds, st.integers(-5000, 5000))
def test_only_the_time_between_deadline_and_submission_counts(offset, days):
    """Daylight saving time and leap years have no effect."""
    shift = timedelta(days=days)
    assert days_late(at(offset) + shift, DUE + shift) == days_late(at(offset), DUE)


@pytest.mark.parametrize(
    ("offset", "days"),
    [(-1, 0), (0, 0), (1, 1), (86400, 1), (86401, 2), (2 * 86400, 2)],
)
def test_each_started_day_counts(offset, days):
    """One second after the deadline is one day late; the deadline itself is in time."""
    assert days_late(at(offset), DUE) == days


def test_the_grace_period_does_not_move_the_deadline():
    """Within the grace period nothing is late; after it, days count from the deadline."""
    grace = timedelta(minutes=15)
    assert days_late(at(900), DUE, grace) == 0
    assert days_late(at(901), DUE, grace) == 1
    assert days_late(at(86400 + 60), DUE, grace) == 2


def test_without_a_deadline_or_a_submission_time_there_is_no_penalty():
    assert late_factor(None, LatePolicy(DUE, per_day=1.0)) == 1
    assert late_factor(DUE, LatePolicy(None, per_day=1.0)) == 1


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("ceil(over / DAY)", "int(over / DAY)"), ("max(policy.due, until)", "until")],
)
def test_mutants_of_the_late_policy_are_caught(right, wrong):
    """Mutants: completed days instead of started days, and extensions that shorten the time."""
    source = inspect.getsource(late_policy)
    assert right in source
    mutant = {"__name__": late_policy.__name__}
    exec(compile(source.replace(right, wrong), "mutant", "exec"), mutant)
    policy = LatePolicy(DUE, per_day=0.1)
    begun = mutant["days_late"](at(1), DUE) == 1
    unhurt = mutant["late_factor"](at(0), policy, at(-1)) == 1.0
    assert not (begun and unhurt)


def test_a_time_without_a_zone_is_refused():
    """Without a time zone, a time of day is ambiguous."""
    with pytest.raises(ValueError, match=r"has no time zone: write it as .*\+01:00"):
        moment("2026-11-30T23:59")
    with pytest.raises(ValueError, match="a time must be written as 2026-11-30T23:59"):
        moment("30/11/2026")
    assert moment("2026-11-30T23:59Z") == datetime(2026, 11, 30, 23, 59, tzinfo=UTC)


def test_the_longest_of_several_extensions_counts(tmp_path):
    """The order of two lines for one student does not matter."""
    file = tmp_path / "extensions.csv"
    lines = ["ada,1,2026-12-04T12:00Z,ill", "ada,01,2026-12-02T12:00Z,moved"]
    for order in (lines, lines[::-1]):
        file.write_text("\n".join(["student,notebook,until,reason", *order]))
        assert read_extensions(file)["ada", "01"].until == moment("2026-12-04T12:00Z")


def test_all_bad_lines_are_reported_with_their_numbers(tmp_path):
    """All errors of a table are reported at once."""
    file = tmp_path / "extensions.csv"
    file.write_text(
        "student,notebook,until,reason\nada,01,tomorrow,ill\n\nalan,x,2026-12-04T12:00Z,"
    )
    with pytest.raises(
        ValueError, match=r"(?s)extensions.csv:2: a time .*extensions.csv:4: column reason"
    ):
        read_extensions(file)
