"""Malicious zip files: nothing is written outside, and honest students are graded."""

import io
import json
import stat
import zipfile

import pytest

from fieldgrade.checking.grade_submission import grade
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.intake import Intake
from hostile.case import HERE, POINTS, as_file, notebook

HONEST = as_file(notebook())[1]


def link(target):
    """A zip entry that unpacks to a symbolic link."""
    info = zipfile.ZipInfo("mallory_01.ipynb")
    info.create_system = 3
    info.external_attr = (stat.S_IFLNK | 0o777) << 16
    return [(info, target)]


def nested(content):
    """A zip file in a zip file."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as pack:
        pack.writestr("mallory_01.ipynb", content)
    return buffer.getvalue()


def many_files():
    """A zip file of a student with 21 000 empty files."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as pack:
        for k in range(21_000):
            pack.writestr(f"{k}.txt", b"")
    return buffer.getvalue()


TRICKS = {
    "up": lambda _: [("../../mallory_01.ipynb", HONEST), ("../canary/secret", "hostile")],
    "absolute": lambda places: [(f"{places.canary}/new", "hostile"), ("/tmp/x.ipynb", HONEST)],
    "of another system": lambda _: [("..\\..\\mallory_01.ipynb", HONEST), ("C:\\x.ipynb", HONEST)],
    "a link to a secret": lambda places: link(f"{places.canary}/secret"),
    "a link to a folder, and a file below it": lambda places: [
        *link(str(places.canary)),
        ("mallory_01.ipynb/new", "hostile"),
    ],
    "the results of all": lambda _: [("results.json", '{"points": 100}'), ("gradebook.csv", "x")],
    "the grader's own names": lambda _: [
        ("fieldcheck/__init__.py", "raise SystemExit"),
        ("conftest.py", "raise SystemExit"),
        ("sitecustomize.py", "raise SystemExit"),
    ],
    "a bomb": lambda _: [("mallory.zip", nested(bytes(50 << 20)))],
    "more files than allowed": lambda _: [("mallory.zip", many_files())],
    "a name that is taken": lambda _: [("alice_01.ipynb/alice_01.ipynb", b"{}")],
    "a thousand folders deep": lambda _: [("a/" * 1000 + "mallory_01.ipynb", HONEST)],
    "odd names": lambda _: [("mallory\x00\x1b[2J\n_01.ipynb", HONEST), ("\udc80.ipynb", b"{}")],
}


@pytest.mark.slow
@pytest.mark.parametrize("trick", TRICKS)
def test_a_malicious_zip_file_does_not_affect_other_submissions(
    trick, tmp_path, course, servers, places, watchdog
):
    """The submissions beside it get their points, and all messages are printable text."""
    server = servers(HERE[0])
    watchdog(server)
    pack = tmp_path / "class.zip"
    with zipfile.ZipFile(pack, "w") as file:
        file.writestr("alice_01.ipynb", HONEST)
        file.writestr("bob_01.ipynb", HONEST)
        for name, content in TRICKS[trick](places):
            try:
                file.writestr(name, content)
            except UnicodeEncodeError:
                continue
    before = sorted(tmp_path.iterdir())

    archive = Archive(tmp_path / "received")
    intake = Intake(archive, course.functions())
    handed = intake.take(pack)
    records = [grade(course, server, one.submission(archive)) for one in handed]

    honest = [r for r in records if r.points == sum(POINTS["01"].values())]
    assert {"alice", "bob"} <= {record.student for record in honest}
    for record in records:
        repr(record).encode()
        assert places.secret not in repr(record)
    json.dumps([intake.strays, [h.notes for h in handed], [h.problem for h in handed]])
    assert places.reached() == []
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "received"])
