"""pytest, started for a class: what the command line does, and what a program can do as well."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor

import pytest
from threadpoolctl import threadpool_limits

from fieldrecon.course.grading.plugin import Grading
from fieldrecon.course.grading.run import Run

QUIET = ("-p", "no:terminalreporter")


def graded(
    run: Run,
    executor: Executor | None = None,
    told: Callable[[int, int], None] = lambda *_: None,
    options: Sequence[str] = (),
) -> Grading:
    """Grade a class, and return what was found; its `results` have been written, too.

    Parameters
    ----------
    run : Run
        What is graded, behind which walls, and where the results go.
    executor : Executor, optional
        What does the work: a pool of processes, or ``get_executor()`` of a Dask client whose
        workers see the same folders. Without one there are as many threads as `run` has jobs.
    told : callable, optional
        ``told(done, of)`` is called as submissions are done.
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
    _ = run.taken  # what is wrong with the tables, or with what was handed in, is told first
    grading = Grading(run, executor, told)
    with threadpool_limits(1):
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


def _arguments(run: Run) -> list[str]:
    """Return what pytest is told; processes of pytest-xdist hear of the run by its options."""
    told = [
        "-p", "fieldrecon.course.grading.plugin", "-c", os.devnull, "-p", "no:cacheprovider",
        "--rootdir=.", "--import-mode=importlib", "--capture=sys",
        "-W", "ignore:Module already imported",
        f"--submissions={run.submissions}", f"--out={run.out}", f"--root={run.root}",
        f"--question={run.choice.question}", f"--student={run.choice.student}",
        f"--tier={run.tier}", f"--jobs={run.jobs}",
    ]  # fmt: skip
    told += [f"--class={run.tables}"] if run.tables else []
    return told + [f"--only={number}" for number in sorted(run.choice.notebooks)]
