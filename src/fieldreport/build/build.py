"""Bring the whole report up to date: run what is out of date, draw, typeset, write the manifest."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fieldrecon._core.atomic_files import TEMPORARY, write_atomically
from fieldrecon._core.digests import json_digest
from fieldrecon.cli.progress import Bar
from fieldreport.build import screen_files, up_to_date, widgets
from fieldreport.build.chapter_checks import Quotable, errors_in
from fieldreport.build.chapter_pages import write_pages
from fieldreport.build.code_dependencies import code_digests, statement_cache
from fieldreport.build.errors import BuildError
from fieldreport.build.lock import only_build_in
from fieldreport.build.manifest import manifest, versions
from fieldreport.build.rerun import ExperimentJob, compute, jobs_of
from fieldreport.build.source_date import source_date
from fieldreport.build.step_records import Steps, content_digest, digests
from fieldreport.build.typesetting import Document, unquoted_facts
from fieldreport.framework.names import no_such
from fieldreport.framework.result_files import fact_names, read_result, table_columns


def build(arguments: argparse.Namespace) -> None:
    """Run, draw, typeset and write the manifest, each only if it is out of date."""
    source, out = arguments.source, arguments.out or arguments.source / "build"
    key = up_to_date.key(
        arguments
    )  # before anything is read, so that edits during the build are noticed
    document = Document(source, out)
    if not document.chapters:
        raise BuildError(f"there are no chapters in {source / 'chapters'}; is this the checkout?")
    living = widgets.named_in(document.chapters)
    settings = _settings(up_to_date.settings_file(arguments))
    with (
        Bar() as progress,
        only_build_in(out, progress.say),
        statement_cache(out / ".state/code.json"),
    ):
        _sweep(out)
        steps = Steps(out)
        jobs = jobs_of(settings, out / "experiments")
        _check_chapters(document, jobs, steps)
        read = {path: content_digest(path) for job in jobs for path in job.inputs()}
        chosen = _chosen(jobs, arguments.only)
        compute(chosen, steps, max(1, min(arguments.jobs, len(chosen))), progress)
        if not arguments.only:
            _remove_others(jobs, steps)
            shown = screen_files.compute(jobs, steps, max(1, arguments.jobs), progress)
            shown += widgets.compute(living, jobs, steps, progress)
            _finish(document, jobs, shown, steps, progress)
            up_to_date.record(steps, key, read)


def _check_chapters(document: Document, jobs: list[ExperimentJob], steps: Steps) -> None:
    """Stop the build at typing errors in the chapters, before an experiment runs.

    The facts and the tables of an experiment are known if its result is up to date.
    """
    done = [job for job in jobs if steps.done(f"run-{job.name}", job.run_key())]
    quotable = Quotable(
        values={job.name: _quotable(job, job in done) for job in jobs},
        tables={job.name: table_columns(job.folder) for job in done},
        figures={figure for job in jobs for figure in job.experiment.plots},
    )
    references = document.source / "references.bib"
    if not references.is_file():
        raise BuildError(f"there is no {references}")
    found = list(errors_in(document.chapters, references, quotable))
    if found:
        raise BuildError("\n".join(f"{document.source.name}/{line}" for line in found))


def _quotable(job: ExperimentJob, done: bool) -> set[str]:
    params = {f"params.{name}" for name in asdict(job.params)}
    return params | (fact_names(job.folder) if done else set())


def _finish(
    document: Document, jobs: list[ExperimentJob], shown: list[Path], steps: Steps, progress: Bar
) -> None:
    """Typeset the text with the figures for the screen, and write the manifest."""
    values = {job.name: _values(job) for job in jobs}
    results = [*_results(jobs), *shown]
    made = [*results, document.out / "report.html", document.out / "report.pdf"]
    metadata = {"version": versions()["fieldrecon"], "date": source_date(document.source)}
    key = json_digest(
        {
            "metadata": metadata,
            "text": digests(document.inputs, document.source),
            "results": digests(results, document.out),
            "values": values,
            "versions": versions(),
            "code": code_digests("fieldreport.build.typesetting"),
        }
    )
    if not steps.done("document", key):
        progress.add(1)
        document.compile(values, metadata)
        steps.record("document", key, [*made[-2:], document.page])
        progress.done("set the text")
        _report_unquoted(document, values, progress)
    _write_pages(document, jobs, steps, key, progress)
    pages = sorted(steps.made("pages"))
    content = manifest(values, [*made, *pages], document.out)
    path = document.out / "manifest.json"
    if not path.exists() or path.read_bytes() != content:
        write_atomically(path, content)
    progress.say(f"{made[-2]} and {made[-1]} are up to date")


def _write_pages(
    document: Document, jobs: list[ExperimentJob], steps: Steps, key: str, progress: Bar
) -> None:
    """Write the chapters for the site of the documentation, and remove those of earlier texts."""
    key = json_digest([key, code_digests("fieldreport.build.chapter_pages")])
    if not steps.done("pages", key):
        progress.add(1)
        made = write_pages(document, jobs)
        steps.remove_others("pages", made)
        steps.record("pages", key, made)
        progress.done("wrote the chapters")


def _values(job: ExperimentJob) -> dict[str, Any]:
    """Return what the text may quote from an experiment."""
    result = read_result(job.folder, job.experiment)
    meanings = job.experiment.meanings
    return {
        "title": job.experiment.title,
        "facts": dict(result.facts),
        "params": asdict(result.params),
        "fields": [{"name": name, "meaning": text} for name, text in meanings.items()],
        "tables": {
            name: {"columns": table.columns, "rows": table.rows}
            for name, table in result.tables.items()
        },
        "figures": list(job.experiment.plots),
    }


def _results(jobs: list[ExperimentJob]) -> list[Path]:
    return [
        path
        for job in jobs
        for path in [*job.result_files(), *map(job.figure_file, job.experiment.plots)]
    ]


def _report_unquoted(document: Document, values: Mapping[str, Any], progress: Bar) -> None:
    for name, facts in unquoted_facts(document.chapters, values).items():
        progress.say(f"no chapter quotes these facts of {name}: {', '.join(facts)}")


def _settings(path: Path) -> dict[str, dict[str, Any]]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise BuildError(f"there is no {path}") from error
    except tomllib.TOMLDecodeError as error:
        raise BuildError(f"{path}: {error}") from error


def _chosen(jobs: list[ExperimentJob], only: list[str]) -> list[ExperimentJob]:
    known = [job.name for job in jobs]
    for name in only:
        if name not in known:
            raise BuildError(no_such("experiment", name, known))
    return [job for job in jobs if not only or job.name in only]


def _sweep(out: Path) -> None:
    """Remove the temporary files of a build that was killed."""
    kinds = ("experiments", "pages", "screen")
    folders = [folder for kind in kinds for folder in (out / kind).glob("*/")]
    for folder in (out, out / ".state", out / "pages", *folders):
        for path in folder.glob(".*"):
            if TEMPORARY.fullmatch(path.name):
                path.unlink()


def _remove_others(jobs: list[ExperimentJob], steps: Steps) -> None:
    """Remove the results and figures that earlier builds made and this one does not."""
    figures = [figure for job in jobs for figure in job.experiment.plots]
    steps.keep_only("run", [job.name for job in jobs])
    steps.keep_only("draw", figures)
    steps.keep_only("screen", figures)
