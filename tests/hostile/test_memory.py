"""The grader's own memory is bounded, whatever is submitted; sandboxes have limits of their own."""

import io
import json
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from grader_memory import peak_memory
from hostile import given
from hostile.case import HERE, as_file, code_cell, notebook
from hostile.test_class import WORKERS, command

MEBIBYTE = 1 << 20
MOST = 1024 * MEBIBYTE
HONEST = ("ada.ipynb", "zoe.ipynb")  # graded before and after the others


def with_cell(code):
    """A notebook with another cell."""
    made = notebook()
    made["cells"].append(code_cell(code))
    return as_file(made)[1]


def with_value(name, value):
    """A notebook with a value in each code cell."""
    made = notebook()
    for cell in made["cells"]:
        if cell["cell_type"] == "code":
            cell[name] = value
    return as_file(made)[1]


def nested(levels):
    """Arrays in arrays."""
    inner = []
    for _ in range(levels - 1):
        inner = [inner]
    return inner


def bomb():
    """A zip file with two files of 60 MiB."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as pack:
        for name in ("a.ipynb", "b.ipynb"):
            pack.writestr(name, b'{"cells": [' + b"{}," * (20 * MEBIBYTE) + b"{}]}")
    return stream.getvalue()


RETURNS_MUCH = """
for name in ("basis_matrix", "fit", "evaluate", "gradient", "rank", "objective"):
    globals()[name] = lambda *arguments: np.zeros(4_000_000)
"""
GREEDY = {
    "objects.ipynb": lambda: b'{"cells": [' + b"{}," * (6 * MEBIBYTE) + b"{}]}",
    "deep.ipynb": lambda: with_value("x", nested(900)),
    "elements.ipynb": lambda: with_value("x", [{}] * 20_000),
    "strings.ipynb": lambda: with_value("x", ["\U0001f600"] * 15_000),
    "outputs.ipynb": lambda: with_value("outputs", [{"text": "x" * (3 * MEBIBYTE)}]),
    "text.ipynb": lambda: json.dumps({"cells": [{"source": "\U0001f600" * 4_000_000}]}).encode(),
    "names.ipynb": lambda: with_cell("if 0: " + "a;" * (126 << 10)),
    "tuple.ipynb": lambda: with_cell("x = (" + "a," * (127 << 10) + ")"),
    "definitions.ipynb": lambda: with_cell("def f():0\n" * (25 << 10)),
    "bomb.zip": bomb,
    "values.ipynb": lambda: with_cell(RETURNS_MUCH),
    "script.py": lambda: b"a;" * (9 * MEBIBYTE),
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_the_graders_own_processes_stay_small(tmp_path):
    """All students but two submit something that is large when it is read or parsed."""
    honest = {name: lambda: as_file(notebook())[1] for name in HONEST}
    for name, make in (GREEDY | honest).items():
        folder = tmp_path / "in" / Path(name).stem
        folder.mkdir(parents=True)
        (folder / name).write_bytes(make())
    program = Path(sys.executable).parent / "fieldrecon"
    options = ["--out", str(tmp_path / "out"), "--tier", HERE[0], "--jobs", "2"]
    status, peak = peak_memory([program, "grade", str(tmp_path / "in"), *options])
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    statuses = {record["student"]: record["status"] for record in results["records"]}
    assert status in (0, 3)
    assert "grader failed" not in statuses.values()
    assert [statuses[Path(name).stem] for name in HONEST] == ["graded", "graded"]
    assert peak < MOST, peak / MEBIBYTE


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_processes_with_right_functions_share_the_memory_of_their_workers(tmp_path):
    """Each of 16 workers has one, since every student has a wrong answer that another one calls."""
    for k in range(WORKERS + 4):
        case = replace(given.HONEST[0], after=f"student = {k}")
        (tmp_path / "in" / f"s{k:02}").mkdir(parents=True)
        (tmp_path / "in" / f"s{k:02}" / "01.ipynb").write_bytes(case.submitted_file({})[1])
    status, peak = peak_memory(command(tmp_path, str(tmp_path / "out")))
    print(f"{WORKERS} workers with right functions: {peak >> 20} MiB")
    assert status == 0
    assert peak < MOST, peak / MEBIBYTE
