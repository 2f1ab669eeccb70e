"""A small class for tests of the grader: submissions, and a run that grades them."""

import json
import shutil

from checkout import ROOT
from fieldgrade.authoring.build import all_sources
from fieldgrade.grading.run import Choice, GradingRun
from fieldgrade.isolation.server import tiers
from submission_files import notebook, write_files

TIER = tiers()[0]
SOURCES = {source.number: source for source in all_sources(ROOT)}


def right(number="01"):
    """The cells of a solution that define answers, without its pictures."""
    cells = SOURCES[number].cells
    return [c.text for c in cells if c.question or (c.is_setup and c.kind == "code")]


SHIFTED = """
def fit(points, values):
    matrix = basis_matrix(points)
    return np.linalg.lstsq(matrix, values + 1, rcond=None)[0]
"""
STUB = "def rank(points):\n    raise NotImplementedError\n"


def class_files():
    """A right and a wrong submission, one with an unwritten answer, and an unreadable file."""
    return {
        "ada/01.ipynb": notebook(*right()),
        "ada/02.ipynb": notebook(*right("02")),
        "bob/01.ipynb": notebook(*right(), SHIFTED),
        "cai/01.ipynb": notebook(*(c for c in right() if "def rank" not in c), STUB),
        "dan/01.ipynb": notebook(*right())[:-200],
    }


def run(folder, files=None, root=ROOT, tables=None, jobs=1, **choice):
    """A grading run on these files in a folder."""
    write_files(folder / "in", class_files() if files is None else files)
    return GradingRun(folder / "in", folder / "out", root, tables, TIER, jobs, Choice(**choice))


def checkout(folder, *numbers):
    """A copy of the files of a checkout that the grader reads, to be changed."""
    for file in (ROOT / "solutions").rglob("*.py"):
        if file.name[:2] in numbers:
            copy = folder / file.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
    return folder


def ledger(out):
    """The entries of the ledger in order: a student and the checked questions."""
    file = out / "ledger.jsonl"
    lines = file.read_text().splitlines() if file.exists() else []
    return [(line["student"], *line["made_by"]) for line in map(json.loads, lines)]


def points(results):
    """The points of each answer, by student and question."""
    return {(r.student, g.question): g.points for r in results.records for g in r.grades}
