"""The targets of make, with a stand-in for the commands that they start."""

import os
import re
import shutil
import subprocess

import pytest

from checkout import ROOT

COMMAND = """#!/bin/sh
echo "$@" >>runs
test ! -e report/broken || exit 3
for name in report.html report.pdf manifest.json; do echo >report/build/$name; done
test ! -e edit || { rm edit; sleep 1; echo >>report/chapters/one.md; }
"""
AGES_AGO = 1_000_000_000


@pytest.fixture
def checkout(tmp_path):
    """A checkout whose environment is ready, in a folder with a space in its name."""
    folder = tmp_path / "the checkout"
    chapters = folder / "report" / "chapters"
    code = folder / "src" / "fieldreport" / "experiments"
    binaries = folder / ".venv" / "bin"
    for place in (chapters, code, binaries, folder / "tools"):
        place.mkdir(parents=True)
    for file in (*ROOT.glob("requirements*.lock"), ROOT / "Makefile", ROOT / "pyproject.toml"):
        shutil.copy(file, folder)
    shutil.copy(ROOT / "src" / "pyproject.toml", folder / "src")
    (folder / "tools" / "setup.sh").touch()
    (chapters / "one.md").touch()
    (chapters / "two.md").touch()
    (code / "one.py").touch()
    (binaries / "python").touch()
    (folder / ".venv" / "ready").write_text(str(folder.resolve()))
    (binaries / "fieldrecon").write_text(COMMAND)
    (binaries / "fieldrecon").chmod(0o755)
    for path in (folder, *folder.rglob("*")):
        os.utime(path, (AGES_AGO, AGES_AGO))
    return folder


def make(folder, *arguments):
    """Run make as from a shell: what the make around these tests was told is not passed on."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    return subprocess.run(
        ["make", *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )


def runs(checkout):
    """How often the report's command runs in one `make report`."""
    (checkout / "runs").write_text("")
    result = make(checkout, "report")
    assert (result.returncode, result.stderr) == (0, "")
    return (checkout / "runs").read_text().splitlines()


def test_a_report_that_is_there_starts_nothing(checkout):
    """The first call runs the command, the second finds nothing to do."""
    assert runs(checkout) == ["report"]
    assert runs(checkout) == []


def change_a_chapter(checkout):
    (checkout / "report" / "chapters" / "one.md").touch()


def add_an_experiment(checkout):
    path = checkout / "src" / "fieldreport" / "experiments" / "two.py"
    path.touch()
    os.utime(path, (AGES_AGO, AGES_AGO))


def remove_a_chapter(checkout):
    (checkout / "report" / "chapters" / "two.md").unlink()


def update_the_lock_file(checkout):
    (checkout / ".venv" / "ready").touch()


def lose_the_pdf(checkout):
    (checkout / "report" / "build" / "report.pdf").unlink()


def lose_the_page(checkout):
    (checkout / "report" / "build" / "report.html").unlink()


def lose_the_manifest(checkout):
    (checkout / "report" / "build" / "manifest.json").unlink()


@pytest.mark.parametrize(
    "change",
    [
        change_a_chapter,
        add_an_experiment,
        remove_a_chapter,
        update_the_lock_file,
        lose_the_pdf,
        lose_the_page,
        lose_the_manifest,
    ],
)
def test_a_change_starts_the_command_once(checkout, change):
    """A source that was edited, added or removed, new packages, an output that is gone."""
    runs(checkout)
    outputs = (checkout / "report" / "build").iterdir()
    for path in (*outputs, *checkout.glob("report/**"), *checkout.glob("src/**")):
        os.utime(path, (AGES_AGO + 9, AGES_AGO + 9))
    change(checkout)
    assert runs(checkout) == ["report"]
    assert runs(checkout) == []


@pytest.mark.slow
def test_what_is_edited_during_a_run_is_seen_by_the_next(checkout):
    """The report on disk is as old as the start of the run that made it."""
    (checkout / "edit").touch()
    assert runs(checkout) == ["report"]
    assert runs(checkout) == ["report"]


def test_a_failure_is_tried_again(checkout):
    """The command's exit status is make's, and nothing looks finished."""
    (checkout / "report" / "broken").touch()
    for _ in range(2):
        assert make(checkout, "report").returncode != 0
    (checkout / "report" / "broken").unlink()
    assert runs(checkout) == ["report"]


def test_help_tells_every_target():
    """Help is what a bare make prints: one line for each target a person types."""
    told = set(re.findall(r"^  make ([a-z-]+) +\S", make(ROOT).stdout, flags=re.M))
    unfolded = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    phony = re.search(r"^\.PHONY:(.*)$", unfolded, flags=re.M)
    assert told == set(phony.group(1).split()) - {"FORCE"}


def test_clean_leaves_the_environment_and_the_sources(checkout):
    """What was built goes; distclean takes the environment as well."""
    runs(checkout)
    (checkout / ".venv" / "pyvenv.cfg").touch()
    assert make(checkout, "clean").returncode == 0
    assert not (checkout / "report" / "build").exists()
    assert (checkout / "report" / "chapters" / "one.md").exists()
    assert (checkout / ".venv" / "bin").exists()
    assert make(checkout, "distclean").returncode == 0
    assert not (checkout / ".venv").exists()


def test_the_makefile_keeps_to_make_3_81():
    """macOS ships that version: no grouped targets, one-shell recipes, != or $(file)."""
    text = (ROOT / "Makefile").read_text()
    rules = "\n".join(line for line in text.splitlines() if not line.startswith(("\t", "#")))
    assert not re.search(r"&:|\.ONESHELL|!=|::=|\$\(file |\$\(let |\$\(intcmp ", rules)
