"""Model answers with rubrics for self-assessment: a page that the instructor releases.

It is not part of the bundle for students: publish the page of a notebook after its deadline.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fieldgrade.authoring.sources import Source
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.class_folder.manual_grading import WrittenQuestion, written_questions
from fieldrecon._core.atomic_files import write_if_changed

INSTRUCTION = """\
First write your own answer to each question. Then compare it with the rubric, point by point, and
only then read the model answer. An answer in other words, or by another argument, earns the same
points."""


def write_self_assessment(source: Source, out: Path) -> Iterator[Path]:
    """Write the page of a notebook as Markdown and as HTML, and yield the files."""
    from fieldgrade.html_pages import page, rendered

    text = self_assessment(source)
    yield write_if_changed(out / f"{source.name}.md", f"# {_title(source)}\n\n{text}".encode())
    html = page(_title(source), "Model answers and rubrics", rendered(text))
    yield write_if_changed(out / f"{source.name}.html", html.encode())


def self_assessment(source: Source) -> str:
    """Return the questions in words with points, rubrics and model answers, as Markdown."""
    asked = written_questions(source)
    total = sum(question.points for question in asked)
    head = f"{INSTRUCTION} The questions in words have {short(total)} points together."
    return "\n\n".join([head, *map(_section, asked)]) + "\n"


def _title(source: Source) -> str:
    return f"Self-assessment, {source.number} {source.title}"


def _section(question: WrittenQuestion) -> str:
    return "\n\n".join(
        [
            f"## {question.name} ({short(question.points)} points)",
            question.asked,
            "### Rubric",
            question.rubric,
            "### Model answer",
            question.answer,
        ]
    )
