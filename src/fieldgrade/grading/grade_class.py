"""Grade a class from Python: start pytest with the plugin."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from importlib.util import find_spec

import pytest

from fieldgrade.grading import FOR_WORKERS
from fieldgrade.grading.pytest_plugin import Grading
from fieldgrade.grading.run import GradingRun
from fieldrecon._core.blas_threads import one_blas_thread
from fieldrecon._core.worker_processes import prepare

QUIET = ("terminalreporter",)
UNUSED = ("logging", "warnings", "threadexception", "unraisableexception")
"""Plugins of pytest that take time for every item, and that only checks of instructors may use."""


def grade_class(
    run: GradingRun,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] = lambda *_: None,
    options: Sequence[str] = (),
) -> Grading:
    """Grade a class, write the results, and return the plugin, which has them as `results`.

    Parameters
    ----------
    run : GradingRun
        The submissions, the tier of the sandbox, and where the results go.
    executor : Executor, optional
        A pool of processes, or ``get_executor()`` of a Dask client whose
        workers see the same folders. Without one there are as many processes as `run` has jobs,
        and for one job a thread.
    progress : callable, optional
        ``progress(done, total)`` is called when a submission is completed.
    options : sequence of str, optional
        Options of pytest, which then prints its output.

    Raises
    ------
    KeyboardInterrupt
        The run was interrupted; what was found by then is kept.
    RuntimeError
        The executor broke down, or results cannot be written.
    ValueError
        There is nothing to be graded, a table or a check is wrong, or so are the options.
    """
    quiet = _without(QUIET if run.checks else (*QUIET, *UNUSED))
    if executor is None and run.jobs > 1:
        prepare(FOR_WORKERS)
    _ = run.taken  # errors in tables and submissions are reported first
    grading = Grading(run, executor, progress)
    with one_blas_thread(), isolated_pytest():
        status = pytest.main([*_arguments(run), *(options or quiet)], plugins=[grading])
    if grading.error:
        raise RuntimeError(f"the grader failed: {grading.error}") from grading.error
    if grading.problems:
        raise ValueError("\n".join(grading.problems))
    if status == pytest.ExitCode.INTERRUPTED:
        raise KeyboardInterrupt
    if status == pytest.ExitCode.USAGE_ERROR:
        raise ValueError(f"pytest does not understand {' '.join(options)}")
    if grading.results is None:
        raise ValueError("no check was selected")
    return grading


def _without(plugins: Sequence[str]) -> list[str]:
    """Return the options of pytest that switch off plugins."""
    return [option for name in plugins for option in ("-p", f"no:{name}")]


@contextmanager
def isolated_pytest() -> Iterator[None]:
    """Run pytest without configuration from outside, and without files beside the checks."""
    before, wrote, known = dict(os.environ), sys.dont_write_bytecode, set(sys.modules)
    for name in ("PYTEST_ADDOPTS", "PYTEST_PLUGINS"):
        os.environ.pop(name, None)
    os.environ |= {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True  # a stale .pyc could be read for a check of equal length
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
        sys.dont_write_bytecode = wrote
        for name in [n for n in sys.modules if n not in known and is_check(n)]:
            del sys.modules[name]  # the next run imports it again


def is_check(module: str) -> bool:
    """Whether a module is a file of tests that pytest imported."""
    return module.rpartition(".")[2].startswith(("test_", "conftest"))


def _arguments(run: GradingRun) -> list[str]:
    """Return the arguments of pytest; processes of pytest-xdist get the run from its options."""
    run.out.mkdir(parents=True, exist_ok=True)
    folder = run.checks or run.out  # without a folder pytest would look for conftest.py here
    arguments = [
        str(folder),
        f"--confcutdir={folder}",
        "--rootdir=.",
        "-c",
        os.devnull,
        "-p",
        "fieldgrade.grading.pytest_plugin",
        "-p",
        "no:cacheprovider",
        "--import-mode=importlib",
        "--capture=sys",
        "-W",
        "ignore:Module already imported",
        f"--submissions={run.submissions}",
        f"--out={run.out}",
        f"--root={run.root}",
        f"--question={run.choice.question}",
        f"--student={run.choice.student}",
        f"--tier={run.tier}",
        f"--jobs={run.jobs}",
    ]
    arguments += [f"--class={run.tables}"] if run.tables else []
    arguments += ["-p", "xdist.plugin"] if find_spec("xdist") else []
    return arguments + [f"--only={number}" for number in sorted(run.choice.notebooks)]
