"""pytest, started for a class: what the command line does, and what a program can do as well."""

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

QUIET = ("-p", "no:terminalreporter")


def grade_class(
    run: GradingRun,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] = lambda *_: None,
    options: Sequence[str] = (),
) -> Grading:
    """Grade a class, and return what was found; its `results` have been written, too.

    Parameters
    ----------
    run : GradingRun
        What is graded, behind which walls, and where the results go.
    executor : Executor, optional
        What does the work: a pool of processes, or ``get_executor()`` of a Dask client whose
        workers see the same folders. Without one there are as many processes as `run` has jobs,
        and for one job a thread.
    progress : callable, optional
        ``progress(done, total)`` is called as submissions are done.
    options : sequence of str, optional
        Options of pytest, which prints what it does then.

    Raises
    ------
    KeyboardInterrupt
        The run was interrupted; what was found by then is kept.
    RuntimeError
        The executor broke down, or results cannot be written.
    ValueError
        There is nothing to be graded, a table or a check is wrong, or so are the options.
    """
    if executor is None and run.jobs > 1:
        prepare(FOR_WORKERS)
    _ = run.taken  # what is wrong with the tables, or with what was handed in, is told first
    grading = Grading(run, executor, progress)
    with one_blas_thread(), by_itself():
        status = pytest.main([*_arguments(run), *(options or QUIET)], plugins=[grading])
    if grading.error:
        raise RuntimeError(f"the grader failed: {grading.error}") from grading.error
    if grading.problems:
        raise ValueError("\n".join(grading.problems))
    if status == pytest.ExitCode.INTERRUPTED:
        raise KeyboardInterrupt
    if status == pytest.ExitCode.USAGE_ERROR:
        raise ValueError(f"pytest does not understand {' '.join(options)}")
    if grading.results is None:
        raise ValueError("nothing was chosen")
    return grading


@contextmanager
def by_itself() -> Iterator[None]:
    """Let pytest not hear of what it is told elsewhere, and leave nothing beside the checks."""
    before, wrote, known = dict(os.environ), sys.dont_write_bytecode, set(sys.modules)
    for name in ("PYTEST_ADDOPTS", "PYTEST_PLUGINS"):
        os.environ.pop(name, None)
    os.environ |= {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True  # nor read an old check that is as long as the new one
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
        sys.dont_write_bytecode = wrote
        for name in [n for n in sys.modules if n not in known and is_check(n)]:
            del sys.modules[name]  # the next run reads it again


def is_check(module: str) -> bool:
    """Whether a module is a file of tests that pytest imported."""
    return module.rpartition(".")[2].startswith(("test_", "conftest"))


def _arguments(run: GradingRun) -> list[str]:
    """Return what pytest is told; processes of pytest-xdist hear of the run by its options."""
    run.out.mkdir(parents=True, exist_ok=True)
    place = run.checks or run.out  # a folder must be named, or conftest.py is looked for here
    told = [
        str(place),
        f"--confcutdir={place}",
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
    told += [f"--class={run.tables}"] if run.tables else []
    told += ["-p", "xdist.plugin"] if find_spec("xdist") else []
    return told + [f"--only={number}" for number in sorted(run.choice.notebooks)]
