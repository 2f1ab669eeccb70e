"""What a student answered in words: found in whatever was handed in, without running anything."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fieldgrade.authoring.notebooks import YOUR_WORDS
from fieldgrade.submissions.submission import MARK, Submission, Unreadable, source_of

HEADER = re.compile(r"^# ?%%(?P<header>.*)$", re.MULTILINE)
TOLD = re.compile(r"""\banswer=["'](?P<question>[\d.]+)["']""")
LONGEST = 20_000
"""So many characters of an answer are shown; nobody reads more."""


@dataclass(frozen=True)
class Text:
    """A cell of text: what it says, and by what it says which question it answers."""

    text: str
    answer: str = ""
    identifier: str = ""


def words(submission: Submission, questions: Iterable[str]) -> Mapping[str, str]:
    """Return the answers in words, by question; those not written are left out.

    An answer is the cell that says so in its metadata. Where that is lost it is the one with the
    identifier that was handed out, or the cells that follow the question itself.

    Parameters
    ----------
    submission : Submission
        What was handed in.
    questions : iterable of str
        The questions that ask for words.
    """
    try:
        cells = list(_cells(submission))
    except Unreadable:
        return {}
    found = {name: _answer(cells, name) for name in questions}
    return {name: answer[:LONGEST] for name, answer in found.items() if answer}


def _answer(cells: list[Text | None], question: str) -> str:
    """Return the words for a question, by the surest sign that is there."""
    texts = [cell for cell in cells if cell]
    marked = [c.text for c in texts if c.answer == question]
    identifier = f"q-{question.replace('.', '-')}"
    named = [c.text for c in texts if c.identifier == identifier or _is_copy(c, identifier)]
    for candidates in (marked, named, [_following(cells, question)]):
        written = dict.fromkeys(text.replace(YOUR_WORDS, "").strip() for text in candidates)
        if any(written):
            return "\n\n".join(filter(None, written))
    return ""


def _is_copy(cell: Text, identifier: str) -> bool:
    return re.fullmatch(rf"{identifier}-\d", cell.identifier) is not None


def _following(cells: list[Text | None], question: str) -> str:
    """Return the text between a question and the next thing that is not an answer to it."""
    asked = f"**{question}**"
    start = next((i for i, c in enumerate(cells) if c and c.text.startswith(asked)), len(cells))
    answer = []
    for cell in cells[start + 1 :]:
        if cell is None or cell.text.startswith(("**0", "#")) or cell.answer not in ("", question):
            break
        answer.append(cell.text)
    return "\n\n".join(answer)


def _cells(submission: Submission) -> Iterator[Text | None]:
    """Yield the cells of text in order, and None for each other one."""
    if submission.is_script:
        yield from _python_cells(submission.text)
        return
    for cell in submission.notebook_cells:
        yield _told(cell) if cell.get("cell_type") == "markdown" else None


def _told(cell: Mapping[str, Any]) -> Text:
    metadata = cell.get("metadata")
    answer = metadata.get("answer") if isinstance(metadata, dict) else ""
    identifier = cell.get("id")
    return Text(
        source_of(cell),
        answer if isinstance(answer, str) else "",
        identifier if isinstance(identifier, str) else "",
    )


def _python_cells(text: str) -> Iterator[Text | None]:
    """Yield the comments of a script as cells: by its marks, or paragraph by paragraph."""
    if not HEADER.search(text):
        for part in re.split(r"\n\s*\n", text):
            is_text = part.lstrip().startswith("# ") and not MARK.match(part.lstrip())
            yield Text(_uncommented(part)) if is_text else None
        return
    parts = HEADER.split(text)[1:]
    for header, body in zip(parts[::2], parts[1::2], strict=True):
        told = TOLD.search(header)
        is_text = "[markdown]" in header
        yield Text(_uncommented(body), told["question"] if told else "") if is_text else None


def _uncommented(text: str) -> str:
    return re.sub(r"^# ?", "", text.strip(), flags=re.MULTILINE).strip()
