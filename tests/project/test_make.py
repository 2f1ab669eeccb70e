"""The targets of make; a stand-in replaces the commands that they start."""

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
    """Run make as from a shell, without the settings of a make that runs these tests."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    return subprocess.run(
        ["make", *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )


def runs(checkout):
    """The calls of the report command in one `make report`."""
    (checkout / "runs").write_text("")
    result = make(checkout, "report")
    assert (result.returncode, result.stderr) == (0, "")
    return (checkout / "runs").read_text().splitlines()


def test_an_existing_report_is_not_built_again(checkout):
    """The first call runs the command, the second one does not."""
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
def test_a_change_rebuilds_the_report_once(checkout, change):
    """A source was edited, added or removed, the lock file changed, or an output is missing."""
    runs(checkout)
    outputs = (checkout / "report" / "build").iterdir()
    for path in (*outputs, *checkout.glob("report/**"), *checkout.glob("src/**")):
        os.utime(path, (AGES_AGO + 9, AGES_AGO + 9))
    change(checkout)
    assert runs(checkout) == ["report"]
    assert runs(checkout) == []


@pytest.mark.slow
def test_an_edit_during_a_build_triggers_the_next_build(checkout):
    """The manifest is dated to the start of its build."""
    (checkout / "edit").touch()
    assert runs(checkout) == ["report"]
    assert runs(checkout) == ["report"]


def test_a_failed_build_is_repeated(checkout):
    """make returns the exit status of the command, and no output looks finished."""
    (checkout / "report" / "broken").touch()
    for _ in range(2):
        assert make(checkout, "report").returncode != 0
    (checkout / "report" / "broken").unlink()
    assert runs(checkout) == ["report"]


def test_help_lists_every_target():
    """`make` without a target prints one line for each public target."""
    listed = set(re.findall(r"^  make ([a-z-]+) +\S", make(ROOT).stdout, flags=re.M))
    unfolded = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    phony = re.search(r"^\.PHONY:(.*)$", unfolded, flags=re.M)
    assert listed == set(phony.group(1).split()) - {"FORCE"}


def test_clean_keeps_the_environment_and_the_sources(checkout):
    """clean removes build outputs, and distclean also removes the environment."""
    runs(checkout)
    (checkout / ".venv" / "pyvenv.cfg").touch()
    assert make(checkout, "clean").returncode == 0
    assert not (checkout / "report" / "build").exists()
    assert (checkout / "report" / "chapters" / "one.md").exists()
    assert (checkout / ".venv" / "bin").exists()
    assert make(checkout, "distclean").returncode == 0
    assert not (checkout / ".venv").exists()


def test_the_makefile_is_compatible_with_make_3_81():
    """macOS ships this version, without grouped targets, one-shell recipes, != and $(file)."""
    text = (ROOT / "Makefile").read_text()
    rules = "\n".join(line for line in text.splitlines() if not line.startswith(("\t", "#")))
    assert not re.search(r"&:|\.ONESHELL|!=|::=|\$\(file |\$\(let |\$\(intcmp ", rules)


@pytest.mark.parametrize(("status", "is_success"), [(3, True), (1, False)])
def test_submissions_that_need_eyes_are_no_failure_of_make(checkout, status, is_success):
    """The exit status 3 of the command is a success; after the others its message is shown."""
    command = f"#!/bin/sh\necho 'what to do' >&2\nexit {status}\n"
    (checkout / ".venv" / "bin" / "fieldrecon").write_text(command)
    result = make(checkout, "grade", "SUBMISSIONS=in")
    assert (result.returncode == 0) == is_success
    assert result.stderr.startswith("what to do\n")
