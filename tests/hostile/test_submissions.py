"""Each case on each tier: the fair grade, nothing reached, nothing left, and the next is graded."""

import os
import sys
from pathlib import Path

import pytest

from fieldgrade.checking.grade_submission import grade
from fieldgrade.submissions.submission import Submission
from hostile import breakdowns, cheats, damage, oddities, trespass
from hostile.case import HERE, POINTS, Case, as_file, notebook

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
}
HONEST = as_file(notebook())


def cases():
    """All cases on all tiers of this machine; one of each family, on the safest, is not slow."""
    for family, its in FAMILIES.items():
        for index, case in enumerate(its):
            for tier in (tier for tier in HERE if tier in case.tiers):
                quick = index == 0 and tier == HERE[0]
                marks = () if quick else (pytest.mark.slow,)
                yield pytest.param(case, tier, id=f"{family}: {case.name}, {tier}", marks=marks)


def test_there_are_cases_enough():
    """At least sixty, each with a name of its own."""
    names = [case.name for its in FAMILIES.values() for case in its]
    assert len(names) == len(set(names)) >= 60


def test_the_tiers_that_are_asked_for_are_there():
    """Continuous integration asks for those that it installed; a test on no tier proves nothing."""
    missing = [tier for tier in REQUIRED if tier not in HERE]
    assert not missing, (
        f"this machine does not offer {', '.join(missing)}, so nothing was tried on it: is "
        "bubblewrap installed, may it make user namespaces, does the kernel have Landlock?"
    )


TELL_TALES = {
    "UDP": "network",
    "sockets of this machine": "network",
    "TCP": "network",
    "a secret file told in an error": "secret",
    "secrets of the grader's environment": "secret",
}


if sys.platform == "linux":

    @pytest.mark.parametrize("name", TELL_TALES)
    def test_what_is_reached_is_seen(name, course, servers, places, watchdog):
        """Without walls these cases reach what they try, and it does not go unnoticed."""
        server = servers("none")
        watchdog(server)
        case = next(c for its in FAMILIES.values() for c in its if c.name == name)
        record = grade(course, server, Submission("hostile", *case.handed_in(places.told)))
        told = "secret" if places.secret in repr(record) else " ".join(places.reached())
        assert TELL_TALES[name] in told


def points(record):
    return {grade.question: grade.points for grade in record.grades}


def running(server):
    """The processes that a server made, itself included, and those that call themselves so."""
    scratch, found = str(server._scratch), []
    for entry in Path("/proc").iterdir() if Path("/proc/self").exists() else ():
        if entry.name.isdigit():
            try:
                told = (entry / "cmdline").read_bytes().decode(errors="replace")
            except OSError:
                continue
            if scratch in told or f"9999{server.mark}" in told:
                found.append(int(entry.name))
    return sorted(found)


def judged(case, server, course, places):
    """Grade a case, then an honest submission, and look around."""
    server.mark = places.token
    if server._process is None or server._process.poll() is not None:
        grade(course, server, Submission("first", *HONEST))
    process, alone = server._process, running(server)
    name, content = case.handed_in(places.told)

    record = grade(course, server, Submission("hostile", name, content))

    expected = {} if record.status == "unreadable" else case.fair()
    assert points(record) == expected, (record.notes, record.status)
    assert not case.status or record.status == case.status, record.notes
    assert case.notes in " ".join(record.notes)
    assert places.secret not in repr(record)
    repr(record).encode()
    assert places.reached() == []
    assert running(server) == alone
    assert server._process is process
    assert process.poll() is None
    assert list((server._scratch / "homes").iterdir()) == []

    honest = grade(course, server, Submission("honest", *HONEST))
    assert points(honest) == POINTS["01"]
    assert honest.status == "graded"
    assert honest.notes == ()


@pytest.mark.slow
@pytest.mark.parametrize(("case", "tier"), list(cases()))
def test_a_submission(case: Case, tier, course, servers, places, watchdog):
    """The grade of each question is fair, and nobody and nothing else is concerned."""
    watchdog(servers(tier))
    judged(case, servers(tier), course, places)


if "bubblewrap" in HERE:

    @pytest.mark.slow
    @pytest.mark.parametrize("case", trespass.CASES, ids=lambda case: case.name)
    def test_bubblewrap_holds_without_landlock(case, course, servers, places, watchdog):
        """On a kernel that has no Landlock the walls of bubblewrap are enough."""
        server = servers("bubblewrap", landlocked=False)
        watchdog(server)
        judged(case, server, course, places)
