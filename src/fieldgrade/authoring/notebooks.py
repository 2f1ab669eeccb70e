"""Build notebooks from a source: the student's notebook with stubs, and the executed solution.

Both are reproducible byte for byte: identifiers of cells are computed from their content, and no
time is recorded.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from tempfile import TemporaryDirectory
from typing import Any

import nbformat

from fieldgrade.authoring.orientation import with_orientation
from fieldgrade.authoring.outline import Outline
from fieldgrade.authoring.sources import REGION, Cell, Source
from fieldrecon._core.digests import bytes_digest
from fieldreport.build.pinned_kernels import pins, with_pins

KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
KEPT_METADATA = ("question", "answer", "rubric")
DRAWS = re.compile(r"^@dra(w|g)\(", re.MULTILINE)
"""The decorators of pictures, whose code JupyterLab folds."""
YOUR_WORDS = "*Write your answer here.*"
SECONDS_PER_CELL = 120
"""Time limit of a cell of a solution; the text promises less than ten seconds."""


def stub(cell: Cell) -> str:
    """Return the cell for students: the solution is replaced by a placeholder."""
    placeholder = (
        r"\g<indent># Write your answer here, in place of the next line.\n"
        rf'\g<indent>raise NotImplementedError("{cell.question} is not written yet")\n'
    )
    return REGION.sub(placeholder, cell.text + "\n").rstrip("\n")


def student_notebook(source: Source) -> nbformat.NotebookNode:
    """Return the notebook for students, without solutions, rubrics and outputs."""
    return _notebook(source, _student_cells(source))


def solved_notebook(source: Source) -> nbformat.NotebookNode:
    """Return the notebook with the solutions, not executed yet."""
    return _notebook(source, ((cell, cell.text) for cell in source.cells))


def execute(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Run a notebook in an empty folder, without a student's name, and return it with outputs.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        A cell stops with an error.
    """
    from nbclient import NotebookClient

    with TemporaryDirectory() as folder:
        NotebookClient(
            notebook,
            timeout=SECONDS_PER_CELL,
            kernel_name="python3",
            record_timing=False,
            coalesce_streams=True,  # a busy kernel sends one text in several pieces
            resources={"metadata": {"path": folder}},
            extra_arguments=["--log-level=ERROR"],
        ).execute(env=with_pins(pins()) | ENVIRONMENT)
    notebook.metadata = _metadata(notebook.metadata["course"]["source"])
    return notebook


ENVIRONMENT = {
    "FIELDCHECK_STATIC": "1",
    "PYDEVD_DISABLE_FILE_VALIDATION": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
}


def to_text(notebook: nbformat.NotebookNode) -> str:
    """Return a notebook as the text of its file."""
    nbformat.validate(notebook)
    return str(nbformat.writes(notebook)).rstrip("\n") + "\n"


def _student_cells(source: Source) -> Iterator[tuple[Cell, str]]:
    for cell in source.cells:
        if cell.rubric:
            continue
        yield cell, YOUR_WORDS if cell.answer else stub(cell) if cell.question else cell.text


def _notebook(source: Source, cells: Any) -> nbformat.NotebookNode:
    make = {"markdown": nbformat.v4.new_markdown_cell, "code": nbformat.v4.new_code_cell}
    made: list[nbformat.NotebookNode] = []
    seen: set[str] = set()
    outline = Outline(source)
    for cell, plain in cells:
        text = with_orientation(outline, cell, plain)
        node = make[cell.kind](text)
        node["id"] = _identifier(source, cell, text, seen)
        node["metadata"] = nbformat.from_dict(_cell_metadata(cell))
        made.append(node)
    notebook = nbformat.v4.new_notebook(cells=made, metadata=_metadata(source.name))
    notebook["nbformat_minor"] = 5
    return notebook


def _metadata(name: str) -> nbformat.NotebookNode:
    return nbformat.from_dict(
        {"course": {"source": name}, "kernelspec": KERNEL, "language_info": {"name": "python"}}
    )


def _cell_metadata(cell: Cell) -> dict[str, Any]:
    """Return the metadata of a cell: its question, and folding of code that draws."""
    metadata = {key: value for key, value in cell.metadata.items() if key in KEPT_METADATA}
    return metadata | ({"jupyter": {"source_hidden": True}} if DRAWS.search(cell.text) else {})


def _identifier(source: Source, cell: Cell, text: str, seen: set[str]) -> str:
    """Return the question's name, or a hash of the content, with a number if it occurs again."""
    name = cell.question or cell.answer
    digest = bytes_digest(f"{source.name}\0{cell.kind}\0{text}".encode())[:12]
    wanted = f"q-{name.replace('.', '-')}" if name else digest
    identifier, copy = wanted, 1
    while identifier in seen:
        copy += 1
        identifier = f"{wanted}-{copy}"
    seen.add(identifier)
    return identifier
