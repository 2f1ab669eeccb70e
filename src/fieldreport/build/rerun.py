"""Run the experiments whose parameters or code changed, and redraw the figures that changed.

Workers compute and draw; only this process writes, under the lock of the build. Workers end with
this process, so that a killed build leaves no processes behind.
"""

from __future__ import annotations

import multiprocessing
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.blas_threads import one_blas_thread
from fieldrecon._core.digests import json_digest
from fieldrecon._core.worker_processes import WorkerPool
from fieldrecon.plotting.figure_files import figure_bytes
from fieldreport import experiments
from fieldreport.build import pinned_kernels
from fieldreport.build.code_dependencies import code_digests
from fieldreport.build.errors import BuildError
from fieldreport.build.pinned_kernels import pins
from fieldreport.build.step_records import Steps, content_digest, digests
from fieldreport.framework.experiment import Experiment, ExperimentError, Result
from fieldreport.framework.names import no_such
from fieldreport.framework.parameters import replace_parameters
from fieldreport.framework.result_files import TABLES, read_result, result_files, write_result

RUN_NAMES = ("DIGITS", "Params", "run")
FORMAT = "svg"

Say = Callable[[str], None]


@dataclass(frozen=True)
class ExperimentJob:
    """An experiment of the report with its parameters."""

    experiment: Experiment
    params: Any
    folder: Path

    @property
    def name(self) -> str:
        """The experiment's name."""
        return self.experiment.name

    def run_key(self) -> str:
        """Return the digest of what the result depends on."""
        code = code_digests(self.experiment.module.__name__, RUN_NAMES)
        params = asdict(self.params)
        for name, path in self.experiment.inputs(self.params).items():
            params[name] = content_digest(path)
        files = {"name": self.name, "tables": TABLES}
        return json_digest(files | {"params": params, "code": code, "pins": pins()})

    def figure_key(self, plot: Callable[[Result], Any]) -> str:
        """Return the digest of what a figure depends on: its code and the files of the run."""
        code = code_digests(self.experiment.module.__name__, [plot.__name__])
        result = digests(self.result_files(), self.folder)
        return json_digest({"code": code, "result": result, "pins": pins()})

    def inputs(self) -> list[Path]:
        """List the files that the parameters name."""
        return list(self.experiment.inputs(self.params).values())

    def result_files(self) -> list[Path]:
        """List the files of the run."""
        return result_files(self.folder)

    def figure_file(self, figure: str) -> Path:
        """Return the path of a figure."""
        return self.folder / f"{figure}.{FORMAT}"


def jobs_of(settings: Mapping[str, Mapping[str, Any]], folder: Path) -> list[ExperimentJob]:
    """List the experiments of the report, in the order of the settings, then by name.

    Raises
    ------
    BuildError
        If the settings name an experiment or a parameter that does not exist.
    """
    known = experiments.names()
    for name in settings:
        if name not in known:
            raise BuildError(f"experiments.toml: {no_such('experiment', name, known)}")
    order = [*settings, *(name for name in known if name not in settings)]
    return [_job(name, settings.get(name, {}), folder) for name in order]


def _job(name: str, changes: Mapping[str, Any], folder: Path) -> ExperimentJob:
    experiment = experiments.get(name)
    try:
        params = replace_parameters(experiment.defaults, changes)
    except ValueError as error:
        raise BuildError(f"experiments.toml, [{name}]: {error}") from error
    return ExperimentJob(experiment, params, folder / name)


def compute(jobs: list[ExperimentJob], steps: Steps, processes: int, progress: Any) -> None:
    """Bring results and figures of all jobs up to date.

    Parameters
    ----------
    jobs : list of ExperimentJob
        In the order in which they start.
    steps : Steps
        The records of the steps that are up to date.
    processes : int
        The number of workers.
    progress : object
        An object with the methods ``add(count)`` and ``done(text)``.
    """
    with workers(processes) as pool:
        work: dict[Future, Callable[[Any], dict]] = {}
        for job in jobs:
            work |= _start(job, steps, pool, progress)
        while work:
            finished, _ = wait(work, return_when=FIRST_COMPLETED)
            for future in [one for one in work if one in finished]:
                work |= work.pop(future)(future)


def _start(job: ExperimentJob, steps: Steps, pool: Executor, progress: Any) -> dict:
    """Submit the run of a job or, if the run is up to date, its figures."""
    key = job.run_key()
    if steps.done(f"run-{job.name}", key):
        return _start_figures(job, steps, pool, progress)

    def finish(future: Future) -> dict:
        parts = _outcome(future, f"experiment {job.name}")
        files = write_result(Result(job.params, *parts), job.folder)
        steps.record(f"run-{job.name}", key, files)
        progress.done(f"ran {job.name}")
        return _start_figures(job, steps, pool, progress)

    progress.add(1)
    return {pool.submit(_run, job.name, job.params): finish}


def _start_figures(job: ExperimentJob, steps: Steps, pool: Executor, progress: Any) -> dict:
    """Submit the figures of a job that changed."""
    work = {}
    for figure, plot in job.experiment.plots.items():
        key = job.figure_key(plot)
        if not steps.done(f"draw-{figure}", key):
            progress.add(1)
            future = pool.submit(_draw, job.folder, figure)
            work[future] = _finish_figure(job, figure, key, steps, progress)
    return work


def _finish_figure(
    job: ExperimentJob, figure: str, key: str, steps: Steps, progress: Any
) -> Callable:
    def finish(future: Future) -> dict:
        path = job.figure_file(figure)
        write_atomically(path, _outcome(future, f"figure {figure}"))
        steps.record(f"draw-{figure}", key, [path])
        progress.done(f"drew {figure}")
        return {}

    return finish


def _run(name: str, params: Any) -> tuple[dict, dict, dict]:
    """Run an experiment; return tables, facts and arrays in a form that can be pickled."""
    result = experiments.get(name).run(params)
    return dict(result.tables), dict(result.facts), dict(result.arrays)


def _draw(folder: Path, figure: str) -> bytes:
    experiment = experiments.get(folder.name)
    result = read_result(folder, experiment)
    with one_blas_thread():
        return figure_bytes(experiment.plots[figure](result), FORMAT)


def _outcome(future: Future, what: str) -> Any:
    """Return the result of a worker, or raise its error with the traceback."""
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise BuildError(f"{what}: the worker died (out of memory?)") from error
    except (BuildError, OSError):
        raise
    except ExperimentError as error:
        raise BuildError(str(error)) from error
    except Exception as error:
        trace = "".join(traceback.format_exception(error))
        raise BuildError(f"{what} failed\n{trace}") from error


class PinnedProcesses(WorkerPool):
    """Processes whose OpenBLAS and NumPy use the pinned kernels in every environment of the caller.

    They are spawned: a fork server would keep the environment in which it was started.

    Parameters
    ----------
    count : int
        The largest number of processes.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count, context=multiprocessing.get_context("spawn"))
        self._pins = pinned_kernels.pins()

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """Submit a call; a process is started if none is free."""
        with pinned_kernels.environment(self._pins):
            return super().submit(pinned_kernels.run_pinned, self._pins, fn, *args, **kwargs)


@contextmanager
def workers(count: int) -> Iterator[Executor]:
    """Yield an executor whose processes are terminated if an error leaves the ``with``.

    Parameters
    ----------
    count : int
        The number of processes.
    """
    pool = PinnedProcesses(count)
    try:
        yield pool
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
