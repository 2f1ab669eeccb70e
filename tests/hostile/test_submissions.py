"""Hostile cases are graded fairly and affect nothing outside, on each tier where they differ."""

import os
import sys
from pathlib import Path

import pytest

from fieldgrade.checking.grade_submission import grade
from fieldgrade.submissions.submission import Submission
from hostile import (
    beside,
    blocks,
    breakdowns,
    cheats,
    damage,
    fallbacks,
    given,
    oddities,
    running,
    trespass,
)
from hostile.case import EVERYTHING, HERE, POINTS, SANDBOXED, Case, as_file, notebook

REQUIRED = [tier for tier in os.environ.get("FIELDRECON_REQUIRE_TIERS", "").split(",") if tier]

FAMILIES = {
    "cheat": cheats.CASES,
    "loop": breakdowns.LOOPS,
    "crash": breakdowns.CRASHES,
    "memory": breakdowns.MEMORY,
    "flood": breakdowns.FLOODS,
    "leftover": trespass.LEFTOVERS,
    "files": trespass.FILES,
    "network": trespass.NETWORK,
    "environment": trespass.ENVIRONMENT,
    "poison": trespass.POISON,
    "damage": damage.CASES,
    "oddity": oddities.CASES,
    "import": running.IMPORTED,
    "helper": running.HELPERS,
    "name": running.NAMES,
    "stub": running.STUBS,
    "Jupyter": running.JUPYTER,
    "beside": beside.SUBMITTED,
    "no file": beside.NOT_SUBMITTED,
    "font": beside.FONTS,
    "fallback": fallbacks.CASES,
    "block": blocks.BLOCKS,
    "not reached": blocks.NOT_REACHED,
    "scratch": running.SCRATCH,
    "given": given.CASES,
}
# How a file is read, which of its definitions are answers, and what the grader makes of replies and
# requests: the same code on all tiers. Of each family the first case is tried on all.
SAME_ON_ALL_TIERS = ("damage", "name", "stub", "block", "not reached", "cheat", "given", "oddity")
# Limits of time, memory and output are enforced by the server in the same way on all tiers; three
# cases of each family show that they are enforced on each.
LIMITED = ("loop", "memory", "flood")
# What code may read and import is restricted by sandboxes only, by each in its own way.
RESTRICTED = ("import", "helper", "Jupyter", "beside", "no file", "font", "fallback", "scratch")
HONEST = as_file(notebook())
EMPTY_HOME = """
import os
assert os.listdir(".") == [] and os.listdir("..") == [os.path.basename(os.getcwd())]
"""
HONEST_IN_AN_EMPTY_HOME = Case("an empty home", before=EMPTY_HOME).submitted_file({})
ASKED_AFTERWARDS = EVERYTHING[0], EVERYTHING[-1]
"""All cells of the honest submission run, and these questions are asked, which takes less time."""


def tiers_of(family, index):
    """The tiers of this machine on which a case of a family is tried."""
    if index == 0:
        return HERE
    if family in SAME_ON_ALL_TIERS or (family in LIMITED and index > 2):
        return HERE[:1]
    return [t for t in HERE if t in SANDBOXED] or HERE if family in RESTRICTED else HERE


def cases():
    """All cases on the tiers of this machine, marked slow except one of each family."""
    for family, its in FAMILIES.items():
        for index, case in enumerate(its):
            for tier in (tier for tier in tiers_of(family, index) if tier in case.tiers):
                quick = index == 0 and tier == HERE[0]
                marks = () if quick else (pytest.mark.slow,)
                yield pytest.param(case, tier, id=f"{family}: {case.name}, {tier}", marks=marks)


def test_there_are_at_least_sixty_distinct_cases():
    """The names of the cases are distinct."""
    names = [case.name for its in FAMILIES.values() for case in its]
    assert len(names) == len(set(names)) >= 60


def test_the_required_tiers_are_available():
    """Continuous integration requires the tiers that it installed."""
    missing = [tier for tier in REQUIRED if tier not in HERE]
    assert not missing, (
        f"this machine does not offer {', '.join(missing)}, so nothing was tried on it: is "
        "bubblewrap installed, may it make user namespaces, does the kernel have Landlock?"
    )


TRACES = {
    "UDP": "network",
    "sockets of this machine": "network",
    "TCP": "network",
    "a secret file told in an error": "secret",
    "secrets of the grader's environment": "secret",
}


if sys.platform == "linux":

    @pytest.mark.slow
    @pytest.mark.parametrize("name", TRACES)
    def test_access_without_a_sandbox_is_detected(name, course, servers, places, watchdog):
        """Without a sandbox these cases reach their targets, and the checks detect it."""
        server = servers("none")
        watchdog(server)
        case = next(c for its in FAMILIES.values() for c in its if c.name == name)
        record = grade(course, server, case.submission(places.values))
        detected = "secret" if places.secret in repr(record) else " ".join(places.reached())
        assert TRACES[name] in detected


HONEST_KINDS = ("import", "helper", "name", "stub", "Jupyter", "beside", "font", "block", "scratch")


@pytest.mark.slow
def test_what_runs_in_jupyter_is_graded_in_full(course, servers):
    """One case of each kind, without a sandbox; the others are cases of the test below."""
    for case in (FAMILIES[kind][0] for kind in HONEST_KINDS):
        record = grade(course, servers("none"), case.submission({}))
        assert points(record) == case.fair_points(), (case.name, record.notes)
        assert " ".join(record.missing.modules) == case.missing
        assert case.notes in " ".join(record.notes)


def points(record):
    return {grade.question: grade.points for grade in record.grades}


def running(server):
    """The processes started by a server, including itself, and those that carry its mark."""
    scratch, found = str(server._scratch.folder), []
    for entry in Path("/proc").iterdir() if Path("/proc/self").exists() else ():
        if entry.name.isdigit():
            try:
                command = (entry / "cmdline").read_bytes().decode(errors="replace")
            except OSError:
                continue
            if scratch in command or f"9999{server.mark}" in command:
                found.append(int(entry.name))
    return sorted(found)


def check_case(case, server, course, places):
    """Grade a case, then an honest submission, and check that nothing else has changed."""
    server.mark = places.token
    if server._process is None or server._process.poll() is not None:
        grade(course, server, Submission("first", *HONEST))
    process, alone = server._process, running(server)

    record = grade(course, server, case.submission(places.values))

    expected = {} if case.status == "unreadable" else case.fair_points()
    verdicts = [(g.question, g.verdict) for g in record.grades]
    assert points(record) == expected, (record.notes, record.status, verdicts)
    assert not case.status or record.status == case.status, record.notes
    assert case.notes in " ".join(record.notes)
    assert " ".join(record.missing.modules) == case.missing
    # a file outside the sandbox is missing in one sandbox and forbidden in another
    files = tuple(name for name in record.missing.files if not Path(name).is_absolute())
    assert (files, record.missing.fonts) == (case.missing_files, case.missing_fonts)
    assert places.secret not in repr(record)
    repr(record).encode()
    assert places.reached() == []
    assert running(server) == alone
    assert server._process is process
    assert process.poll() is None

    after = Submission("honest", *HONEST_IN_AN_EMPTY_HOME)
    honest = grade(course, server, after, ASKED_AFTERWARDS)
    assert points(honest) == {question: POINTS["01"][question] for question in ASKED_AFTERWARDS}
    assert honest.status == "graded"
    assert honest.notes == ()


@pytest.mark.slow
@pytest.mark.parametrize(("case", "tier"), list(cases()))
def test_a_hostile_submission_is_graded_fairly_and_contained(
    case: Case, tier, course, servers, places, watchdog
):
    """Each question gets a fair grade; no other file, process or submission is affected."""
    watchdog(servers(tier))
    check_case(case, servers(tier), course, places)


WITHOUT_MOUNTS = [*trespass.CASES, *breakdowns.FLOODS]


@pytest.mark.slow
@pytest.mark.parametrize("case", WITHOUT_MOUNTS, ids=lambda case: case.name)
@pytest.mark.parametrize("tier", [tier for tier in HERE if tier in SANDBOXED][:1])
def test_hostile_submissions_are_contained_where_mounts_are_forbidden(
    case, tier, course, servers, places, watchdog
):
    """Some systems forbid namespaces; then homes are folders on the disk."""
    server = servers(tier, own_mounts=False)
    watchdog(server)
    check_case(case, server, course, places)


if "bubblewrap" in HERE:

    @pytest.mark.slow
    @pytest.mark.parametrize("case", trespass.CASES, ids=lambda case: case.name)
    def test_bubblewrap_alone_contains_hostile_submissions(case, course, servers, places, watchdog):
        """The kernel is made to appear without Landlock."""
        server = servers("bubblewrap", landlocked=False)
        watchdog(server)
        check_case(case, server, course, places)
