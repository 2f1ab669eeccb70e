"""The library and the students' checks work without the modules that Windows lacks.

No Windows machine is needed: a separate Python process has these modules and functions removed
before the first import, reads text in a legacy encoding by default, and runs quick tests.
"""

import io
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from checkout import ROOT
from fieldrecon._core import memory as _memory
from fieldrecon.cli.main import main
from fieldrecon.methods.solvability import refuse_beyond_memory

TAKEN_AWAY = """
import os
import signal
import sys

import multiprocessing.util, shutil, subprocess, tempfile  # those of Linux, as they are

for module in ("fcntl", "grp", "pwd", "resource"):
    sys.modules[module] = None
for function in ("fork", "forkpty", "killpg", "sched_getaffinity", "setsid", "sysconf"):
    delattr(os, function)
for function in ("alarm", "pthread_sigmask", "setitimer", "SIGALRM", "SIGHUP", "SIGKILL"):
    delattr(signal, function)
"""
RUN = """
import pytest

import fieldcheck
import fieldrecon
import fieldrecon.cli

options = ["-qm", "not slow", "--noconftest", "--hypothesis-profile=ci", "-p", "no:cacheprovider"]
sys.exit(pytest.main([*options, *sys.argv[1:]]))
"""
ENVIRONMENT = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
"""Text is ASCII unless the code states its encoding, which is stricter than a code page."""
QUICK = [
    *(f"tests/fieldcheck/test_{name}.py" for name in ("fieldcheck", "drag")),
    *(f"tests/fieldrecon/methods/test_{name}.py" for name in ("least_squares", "globe")),
    *(f"tests/fieldrecon/io/test_{name}.py" for name in ("targets", "saved_fields")),
    "tests/fieldrecon/cli/test_cli.py::test_targets_in_space_may_be_a_grid_points_or_a_mesh",
    "tests/fieldrecon/cli/test_audit_command.py::test_a_boundary_may_be_allowed",
]
NEEDS_AN_ALARM = "tests/fieldcheck/test_fieldcheck.py::test_slow_and_endless_answers_lose_points"


def python(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {k: v for k, v in os.environ.items() if not k.startswith("LC_")} | ENVIRONMENT
    return subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )


@pytest.mark.slow
def test_quick_tests_pass_without_modules_that_windows_lacks():
    """One test is left out: an answer that never returns is interrupted by an alarm signal."""
    run = python(TAKEN_AWAY + RUN, *QUICK, "--deselect", NEEDS_AN_ALARM)
    assert run.returncode == 0, run.stdout[-5000:] + run.stderr[-5000:]
    assert int(re.search(r"^(\d+) passed", run.stdout, flags=re.M)[1]) > 250


@pytest.mark.parametrize("use", ["import fcntl", "import os; os.fork()", "import os; os.sysconf"])
def test_removed_modules_cannot_be_used(use):
    run = python(f"{TAKEN_AWAY}\n{use}")
    assert "ModuleNotFoundError" in run.stderr or "AttributeError" in run.stderr


def test_a_system_without_sysconf_refuses_no_fit(monkeypatch):
    """The memory of the machine is unknown there, and NumPy itself raises MemoryError."""
    monkeypatch.delattr(os, "sysconf")
    monkeypatch.setattr(_memory, "OWN_CGROUPS", Path("nowhere"))
    assert _memory.memory_limit() == math.inf
    refuse_beyond_memory(10**9)


def test_output_redirected_in_a_code_page_raises_no_error(monkeypatch):
    """Characters that cp1252 lacks become question marks, and others are kept."""
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding="cp1252"))
    assert main(["experiments", "show", "epsilon_sweep"]) == 0
    sys.stdout.flush()
    text = written.getvalue().decode("cp1252")
    assert "1/(r² + ?²)" in text
