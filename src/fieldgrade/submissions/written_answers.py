"""Written answers: found in a notebook or a script without running it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fieldgrade.authoring.notebooks import YOUR_WORDS
from fieldgrade.submissions.submission import MARK, Submission, Unreadable, source_of

HEADER = re.compile(r"^# ?%%(?P<header>.*)$", re.MULTILINE)
ANSWER = re.compile(r"""\banswer=["'](?P<question>[\d.]+)["']""")
LONGEST = 20_000
"""Characters of an answer that are shown."""


@dataclass(frozen=True)
class TextCell:
    """A Markdown cell: its text, the question in its metadata, and its identifier."""

    text: str
    answer: str = ""
    identifier: str = ""


def written_answers(submission: Submission, questions: Iterable[str]) -> Mapping[str, str]:
    """Return the written answers, by question; empty answers are left out.

    The answer is the cell whose metadata names the question. If the metadata are lost, it is the
    cell with the original identifier, or else the cells that follow the question itself.

    Parameters
    ----------
    submission : Submission
        The submission.
    questions : iterable of str
        The questions that ask for a written answer.
    """
    try:
        cells = list(_cells(submission))
    except Unreadable:
        return {}
    found = {name: _answer(cells, name) for name in questions}
    return {name: answer[:LONGEST] for name, answer in found.items() if answer}


def _answer(cells: list[TextCell | None], question: str) -> str:
    """Return the answer to a question, by the most reliable sign that is present."""
    texts = [cell for cell in cells if cell]
    marked = [c.text for c in texts if c.answer == question]
    identifier = f"q-{question.replace('.', '-')}"
    named = [c.text for c in texts if c.identifier == identifier or _is_copy(c, identifier)]
    for candidates in (marked, named, [_following(cells, question)]):
        written = dict.fromkeys(text.replace(YOUR_WORDS, "").strip() for text in candidates)
        if any(written):
            return "\n\n".join(filter(None, written))
    return ""


def _is_copy(cell: TextCell, identifier: str) -> bool:
    return re.fullmatch(rf"{identifier}-\d", cell.identifier) is not None


def _following(cells: list[TextCell | None], question: str) -> str:
    """Return the text between a question and the next cell that does not answer it."""
    asked = f"**{question}**"
    start = next((i for i, c in enumerate(cells) if c and c.text.startswith(asked)), len(cells))
    answer = []
    for cell in cells[start + 1 :]:
        if cell is None or cell.text.startswith(("**0", "#")) or cell.answer not in ("", question):
            break
        answer.append(cell.text)
    return "\n\n".join(answer)


def _cells(submission: Submission) -> Iterator[TextCell | None]:
    """Yield the Markdown cells in order, and None for each other cell."""
    if submission.is_script:
        yield from _python_cells(submission.text)
        return
    for cell in submission.notebook_cells:
        yield _text_cell(cell) if cell.get("cell_type") == "markdown" else None


def _text_cell(cell: Mapping[str, Any]) -> TextCell:
    metadata = cell.get("metadata")
    answer = metadata.get("answer") if isinstance(metadata, dict) else ""
    identifier = cell.get("id")
    return TextCell(
        source_of(cell),
        answer if isinstance(answer, str) else "",
        identifier if isinstance(identifier, str) else "",
    )


def _python_cells(text: str) -> Iterator[TextCell | None]:
    """Yield the comments of a script as cells: by its cell markers, or by paragraphs."""
    if not HEADER.search(text):
        for part in re.split(r"\n\s*\n", text):
            is_text = part.lstrip().startswith("# ") and not MARK.match(part.lstrip())
            yield TextCell(_uncommented(part)) if is_text else None
        return
    parts = HEADER.split(text)[1:]
    for header, body in zip(parts[::2], parts[1::2], strict=True):
        marked = ANSWER.search(header)
        is_text = "[markdown]" in header
        yield (
            TextCell(_uncommented(body), marked["question"] if marked else "") if is_text else None
        )


def _uncommented(text: str) -> str:
    return re.sub(r"^# ?", "", text.strip(), flags=re.MULTILINE).strip()
