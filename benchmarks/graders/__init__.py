"""Other graders, each in a separate environment with the versions of its lock file."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.assignments import ROOT, BenchmarkAssignment

HERE = Path(__file__).parent
VENV = ROOT / ".venv" / "graders"


def environment(name: str) -> Path:
    """The folder of the programs of a peer; the environment is created on first use."""
    home, lock = VENV / name, HERE / f"{name}.lock"
    ready = home / "ready"
    if not ready.is_file() or ready.read_text() != lock.read_text():
        uv = (sys.executable, "-m", "uv")
        python = home / "bin" / "python"
        made = (*uv, "venv", "--quiet", "--clear", "--python", sys.executable, home)
        filled = (*uv, "pip", "sync", "--quiet", "--python", python, lock)
        for command in (made, filled):
            subprocess.run(command, check=True)
        ready.write_text(lock.read_text())
    return home / "bin"


def version(name: str) -> str:
    """The version of a peer that its lock file pins."""
    package = {"otter": "otter-grader"}.get(name, name)
    lines = (HERE / f"{name}.lock").read_text().splitlines()
    pinned = next(line.split()[0] for line in lines if line.startswith(f"{package}=="))
    return pinned.partition("==")[2]


def output_of(name: str, *arguments: object, folder: Path) -> str:
    """The output of a program of a peer.

    Notebooks can import the self-checks and use one thread.
    """
    programs = environment(name)
    own = {
        "HOME": str(folder),
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT / "src"),
        "FIELDCHECK_STATIC": "1",
        "MPLBACKEND": "Agg",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "PYDEVD_DISABLE_FILE_VALIDATION": "1",
    }
    command = [str(programs / str(arguments[0])), *map(str, arguments[1:])]
    done = subprocess.run(command, cwd=folder, env=own, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


class Nbgrader:
    """`nbgrader autograde`, one command for all submissions."""

    def __init__(
        self, folder: Path, assignment: BenchmarkAssignment, files: Sequence[bytes]
    ) -> None:
        self.folder, self.files = folder, files
        source = folder / "source" / "ps" / "work.ipynb"
        source.parent.mkdir(parents=True)
        source.write_bytes(assignment.notebook({}))
        config = "c = get_config()\nc.CourseDirectory.course_id = 'course'\n"
        (folder / "nbgrader_config.py").write_text(config + "c.ExecutePreprocessor.timeout = 120\n")
        output_of("nbgrader", "nbgrader", "generate_assignment", "ps", "--create", folder=folder)
        for number, content in enumerate(files):
            file = folder / "submitted" / f"s{number:03}" / "ps" / "work.ipynb"
            file.parent.mkdir(parents=True)
            file.write_bytes(content)

    def grade(self) -> list[set[str]]:
        """Grade, and return the correct questions of each student."""
        command = ("nbgrader", "autograde", "ps", "--create", "--force")
        output_of("nbgrader", *command, folder=self.folder)
        told = output_of("nbgrader", "python", "-c", SCORES, folder=self.folder)
        scores = json.loads(told)
        return [set(scores[f"s{number:03}"]) for number in range(len(self.files))]


SCORES = """
import json
from nbgrader.api import Gradebook
with Gradebook("sqlite:///gradebook.db") as book:
    print(json.dumps({
        s.student.id: [
            g.name.removeprefix("test-").replace("-", ".")
            for n in s.notebooks for g in n.grades if g.auto_score
        ]
        for s in book.assignment_submissions("ps")
    }))
"""


class Otter:
    """`otter run`, one command per submission."""

    def __init__(
        self, folder: Path, assignment: BenchmarkAssignment, files: Sequence[bytes]
    ) -> None:
        self.folder, self.files = folder, files
        tests = folder / "tests"
        tests.mkdir(parents=True)
        for name, code in assignment.tests.items():
            body = code.replace("\n", "\n    ")
            text = TEST.format(name=name, body=body)
            (tests / f"q{name.replace('.', '_')}.py").write_text(text)
        for number, content in enumerate(files):
            (folder / f"s{number:03}.ipynb").write_bytes(content)
        output_of(
            "otter", "otter", "generate", "-t", "tests", "-o", "autograder.zip", folder=folder
        )

    def grade(self) -> list[set[str]]:
        """Grade, and return the correct questions of each student."""
        return [self._one(f"s{number:03}") for number in range(len(self.files))]

    def _one(self, student: str) -> set[str]:
        out = self.folder / f"{student}-out"
        out.mkdir(exist_ok=True)
        command = ("otter", "run", "-a", "autograder.zip", "-o", out, f"{student}.ipynb")
        output_of("otter", *command, folder=self.folder)
        found = json.loads((out / "results.json").read_text())["tests"]
        return {t["name"] for t in found if t.get("max_score") and t["score"] == t["max_score"]}


TEST = """
import numpy as np
from otter.test_files import test_case

OK_FORMAT = False
name = "{name}"
points = 1


@test_case(points=1, hidden=True)
def test(env):
    globals().update({{k: v for k, v in env.items() if not k.startswith("__")}})
    {body}
"""
PEERS = {"nbgrader": Nbgrader, "otter": Otter}
