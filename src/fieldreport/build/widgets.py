"""Living figures: compute the data of those that the chapters name.

A chapter embeds a living figure as ``::: {.widget name=NAME}`` around a figure. Data are computed
by pinned workers, as results are, and written to ``widgets/NAME.json`` in the build folder.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any, Final

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.blas_threads import one_blas_thread
from fieldrecon._core.digests import json_digest
from fieldreport import experiments, widgets
from fieldreport.build import rerun
from fieldreport.build.code_dependencies import code_digests
from fieldreport.build.errors import BuildError
from fieldreport.build.pinned_kernels import pins
from fieldreport.build.rerun import ExperimentJob
from fieldreport.build.step_records import Steps, digests
from fieldreport.build.widget_scripts import data_file
from fieldreport.framework.names import no_such
from fieldreport.framework.result_files import read_result

OPENING: Final = re.compile(r"^:::+ *\{\.widget\b([^}]*)\}")
NAMED: Final = re.compile(r"\bname=\"?(\w+)\"?")


def named_in(chapters: Iterable[Path]) -> list[str]:
    """List the living figures of the chapters, in reading order.

    Raises
    ------
    BuildError
        For a missing or an unknown name, with file and line.
    """
    found: dict[str, None] = {}
    for path in chapters:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if opening := OPENING.match(line):
                name = NAMED.search(opening[1])
                found[_known(name[1] if name else "", f"{path.name}:{number}")] = None
    return list(found)


def _known(name: str, place: str) -> str:
    if name not in widgets.names():
        raise BuildError(f"{place}: {no_such('living figure', name, widgets.names())}")
    return name


def compute(
    names: Sequence[str], jobs: Sequence[ExperimentJob], steps: Steps, progress: Any
) -> list[Path]:
    """Bring the data of living figures up to date; remove those of others; return the files."""
    used = {job.name: job for job in jobs}
    keys = {name: _key(name, [used[other] for other in widgets.uses(name)]) for name in names}
    outdated = [name for name in names if not steps.done(f"widget-{name}", keys[name])]
    if outdated:
        progress.add(len(outdated))
        with rerun.workers(1) as pool:
            for name, future in [(n, _submitted(pool, n, used)) for n in outdated]:
                path = write_atomically(data_file(steps.out, name), as_json(future.result()))
                steps.record(f"widget-{name}", keys[name], [path])
                progress.done(f"computed the living figure {name}")
    steps.keep_only("widget", names)
    return [data_file(steps.out, name) for name in names]


def _key(name: str, used: list[ExperimentJob]) -> str:
    code = code_digests(f"fieldreport.widgets.{name}")
    results = {job.name: digests(job.result_files(), job.folder) for job in used}
    return json_digest({"code": code, "results": results, "pins": pins()})


def _submitted(pool: Executor, name: str, jobs: dict[str, ExperimentJob]) -> Future:
    return pool.submit(_data, name, [jobs[other].folder for other in widgets.uses(name)])


def _data(name: str, folders: list[Path]) -> dict[str, Any]:
    results = [read_result(folder, experiments.get(folder.name)) for folder in folders]
    with one_blas_thread():
        return widgets.data(name, results)


def as_json(data: dict[str, Any]) -> bytes:
    """Return data as the page reads them."""
    return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
