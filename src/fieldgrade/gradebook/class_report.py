"""The report on a class, as HTML and PDF, typeset like the project's report.

It names nobody and quotes no student.
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fieldgrade.checking.results import Results
from fieldgrade.gradebook.grade_sheets import GradeSheet, LineOutcome
from fieldgrade.gradebook.item_analysis import ItemStatistics, items
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon.plotting.figure_files import figure_bytes
from fieldrecon.plotting.style import FULL_WIDTH, figure
from fieldreport.build.screen_figures import light
from fieldreport.build.typesetting import Document

TEXTS = Path(__file__).parent
SHARED = ("filters", "template.html", "template.typ", "style.css", "references.bib")
"""Files of the project's report that the class report uses too."""
WRAPPED = "table.result td { white-space: normal; }\n"
"""The tables of this report contain sentences, not only numbers."""

OUTCOMES: Mapping[LineOutcome, tuple[str, str]] = {
    "right": ("right", "#2a6428"),
    "half": ("in part", "#d7a65f"),
    "wrong": ("wrong", "#a33b00"),
    "missing": ("not written", "#c8ccd2"),
}
"""Words and colours of the outcomes of graded answers."""
SANDBOX = {"bubblewrap": "bubblewrap", "landlock": "Landlock", "none": "none", "": "did not run"}
STATUS = {
    "partly": "graded in part: something broke down",
    "killed: time": "graded in part: too much time",
    "killed: memory": "graded in part: too much memory",
    "killed: output": "graded in part: too much output",
    "grader failed": "not graded: the grader failed",
}


def class_report(
    results: Results,
    sheets: Sequence[GradeSheet],
    titles: Mapping[str, str],
    sentences: Mapping[tuple[str, str], str],
    source: Path,
    out: Path,
) -> list[Path]:
    """Write ``report.html`` and ``report.pdf`` on a class, and return them.

    Parameters
    ----------
    results : Results
        The results of the grader.
    sheets : sequence of GradeSheet
        The final grades.
    titles : mapping
        The titles of the notebooks.
    sentences : mapping
        The sentence of each mistake, by question and name.
    source : Path
        The folder of the project's report, with its templates.
    out : Path
        Where the files go.

    Raises
    ------
    ValueError
        No notebook was graded.
    """
    submitted = [sheet for sheet in sheets if sheet.has_grade]
    if not submitted:
        raise ValueError("there is nothing to report on: no notebook was graded")
    numbers = sorted({sheet.notebook for sheet in submitted})
    by_number = {n: [s for s in submitted if s.notebook == n] for n in numbers}
    values = {"class": _class(results, sheets, by_number, titles)}
    figures = {"class/class_points": _points_figure(by_number)}
    for number, its in by_number.items():
        values[f"notebook_{number}"] = _notebook(number, its, sentences)
        drawn = f"notebook_{number}/notebook_{number}_outcomes"
        figures[drawn] = _outcomes_figure(its)
    for name, content in figures.items():
        write_atomically(out / "experiments" / f"{name}.svg", content)
        write_atomically(out / "screen" / f"{name}.svg", light(content.decode()).encode())
    with TemporaryDirectory() as folder:
        text = Path(folder)
        _lay_out(text, source, values, titles)
        return Document(text, out).compile(values, {})


def _lay_out(
    text: Path, source: Path, values: Mapping[str, Any], titles: Mapping[str, str]
) -> None:
    """Copy chapters, templates and metadata into the folder of the text."""
    for name in SHARED:
        copy = shutil.copytree if (source / name).is_dir() else shutil.copyfile
        copy(source / name, text / name)
    with (text / "style.css").open("a", encoding="utf-8") as style:
        style.write(WRAPPED)
    metadata = "title: Class report\nlang: en-GB\nwithout-provenance: true\n"
    write_atomically(text / "metadata.yaml", metadata.encode())
    for name, chapter in _chapters(values, titles):
        write_atomically(text / "chapters" / f"{name}.md", chapter.encode())


def _chapters(values: Mapping[str, Any], titles: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    yield "00", (TEXTS / "class_report.md").read_text(encoding="utf-8")
    chapter, mistakes_text = (
        Template((TEXTS / f"class_{name}.md").read_text(encoding="utf-8"))
        for name in ("notebook", "mistakes")
    )
    for number in sorted(name[-2:] for name in values if name != "class"):
        has_mistakes = values[f"notebook_{number}"]["tables"]["mistakes"]["rows"]
        mistakes = (
            mistakes_text.substitute(number=number)
            if has_mistakes
            else "No mistake was recognized."
        )
        title = f"Notebook {number}: {titles.get(number, '')}".rstrip(": ")
        yield number, chapter.substitute(number=number, title=title, mistakes=mistakes) + "\n"


def _as_experiment(facts: Mapping[str, Any], figures: list[str], **tables: Any) -> dict[str, Any]:
    """Return facts, tables and figures in the form of an experiment's results."""
    return {
        "title": "",
        "facts": dict(facts),
        "params": {},
        "fields": [],
        "figures": figures,
        "tables": {name: {"columns": c, "rows": rows} for name, (c, rows) in tables.items()},
    }


def _class(
    results: Results,
    sheets: Sequence[GradeSheet],
    by_number: Mapping[str, Sequence[GradeSheet]],
    titles: Mapping[str, str],
) -> dict[str, Any]:
    left = sum(sheet.waiting for its in by_number.values() for sheet in its)
    facts = {
        "students": len({sheet.student["student"] for sheet in sheets}),
        "submitted": len({record.student for record in results.records}),
        "submissions": sum(map(len, by_number.values())),
        "inputs": "Hidden inputs were drawn from a secret."
        if results.secret
        else "Hidden inputs were not secret: anybody could compute them.",
        "left": f"Answers that are not graded yet: {left}; they count as no points here."
        if left
        else "Every answer has been graded.",
    }
    notebooks = [
        (
            number,
            titles.get(number, ""),
            len(its),
            sum(sheet.late_factor < 1 for sheet in its),
            its[0].possible,
            *_middle([sheet.points for sheet in its]),
        )
        for number, its in by_number.items()
    ]
    sandbox = Counter(SANDBOX[record.tier] for record in results.records)
    status = Counter(STATUS.get(record.status, record.status) for record in results.records)
    columns = ("notebook", "title", "submitted", "late", "possible", "mean", "median")
    return _as_experiment(
        facts,
        ["class_points"],
        notebooks=(columns, notebooks),
        sandbox=(("sandbox", "submissions"), sandbox.most_common()),
        status=(("status", "submissions"), status.most_common()),
    )


def _middle(points: Sequence[float]) -> tuple[float, float]:
    return float(np.mean(points)), float(np.median(points))


def _notebook(
    number: str, its: Sequence[GradeSheet], sentences: Mapping[tuple[str, str], str]
) -> dict[str, Any]:
    mistakes = Counter(
        (line.question, line.grade.verdict.mistake)
        for sheet in its
        for line in sheet.lines
        if line.grade and line.grade.verdict.mistake
    )
    rows = [
        (question, count, sentences.get((question, mistake), mistake))
        for (question, mistake), count in sorted(mistakes.items(), key=lambda m: (-m[1], m[0]))
    ]
    return _as_experiment(
        {},
        [f"notebook_{number}_outcomes"],
        items=(
            ("question", "answers", "failed, %", "mean, %", "discrimination"),
            [_item(item) for item in items(its)],
        ),
        mistakes=(("question", "answers", "mistake"), rows),
    )


def _item(item: ItemStatistics) -> tuple[str, int, float, float, float | str]:
    discrimination = "–" if item.discrimination is None else item.discrimination
    name = f"{item.question} {item.title}".strip()
    return name, item.answers, 100 * item.failed, 100 * item.mean, discrimination


def _points_figure(by_number: Mapping[str, Sequence[GradeSheet]]) -> bytes:
    """Draw a dot for each student and notebook, equal points stacked."""
    with figure(FULL_WIDTH, 0.8 + 0.55 * len(by_number)) as (page, axes):
        for row, (_, its) in enumerate(by_number.items()):
            parts = np.sort([sheet.points / (sheet.possible or 1) for sheet in its])
            place = np.round(parts, 2)
            before = np.array([np.sum(place[:k] == p) for k, p in enumerate(place)])
            height = 0.09 * before / max(1.0, before.max() / 6)
            axes.plot(place, row - height, "o", color="#2a78bb", alpha=0.7, markersize=4, mew=0)
            axes.plot([np.median(parts)] * 2, [row - 0.55, row + 0.12], color="#1c1c1c", lw=1)
        axes.set_yticks(range(len(by_number)), list(by_number))
        axes.set_ylim(len(by_number) - 0.6, -0.8)
        axes.set_xlim(-0.02, 1.02)
        axes.set_xlabel("part of the points")
        axes.set_ylabel("notebook")
    return figure_bytes(page, "svg")


def _outcomes_figure(its: Sequence[GradeSheet]) -> bytes:
    """Draw a stacked bar of outcomes for each question."""
    asked = [line.question for line in its[0].lines]
    found = [Counter(sheet.lines[k].outcome for sheet in its) for k in range(len(asked))]
    with figure(FULL_WIDTH, 0.9 + 0.26 * len(asked)) as (page, axes):
        start = np.zeros(len(asked))
        for outcome, (words, color) in OUTCOMES.items():
            counts = np.array([of_question[outcome] for of_question in found])
            axes.barh(asked, counts, left=start, color=color, height=0.7, label=words)
            start = start + counts
        axes.invert_yaxis()
        axes.set_xlabel("answers")
        axes.set_xlim(0, len(its))
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.legend(ncols=len(OUTCOMES), loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.2)
    return figure_bytes(page, "svg")
