"""Each notebook states the time and the points of its questions, and what it builds on."""

import ast
import re
import shutil

import nbformat
import pytest

import fieldcheck
from checkout import ROOT
from fieldcheck.notebook import Progress, optional_questions
from fieldcheck.questions import questions
from fieldgrade.authoring import build, notebooks
from fieldgrade.authoring.minutes import STEP, number_of_words, suggested_minutes
from fieldgrade.authoring.orientation import effort
from fieldgrade.authoring.outline import MOST_CORE_MINUTES, Outline, minutes, points
from fieldgrade.authoring.sources import Source

SOURCES = build.all_sources(ROOT)
each_source = pytest.mark.parametrize("source", SOURCES, ids=[s.name for s in SOURCES])


@each_source
def test_every_outline_is_complete_and_its_core_fits_into_one_sitting(source):
    outline = Outline(source)
    assert not outline.problems()
    assert 0 < minutes(outline.core) <= MOST_CORE_MINUTES
    assert outline.builds_on or source.number == "01"
    assert {item.question for item in outline.items} == set(source.headers)


@each_source
def test_headers_alone_give_the_metadata_of_the_cells(source):
    """Reading the headers is faster than reading the whole notebook and gives the same numbers."""
    for cell in source.cells:
        if name := cell.question or cell.answer:
            header = source.headers[name]
            numbers = {
                k: v for k, v in cell.metadata.items() if k in ("points", "minutes", "words")
            }
            assert header.numbers == numbers
            assert header.is_optional == ("optional" in cell.metadata)
            assert header.is_in_words == bool(cell.answer)


@each_source
def test_the_minutes_agree_with_the_length_of_text_and_solution(source):
    """An author may round and adjust: each question by a factor of two, the sum by a third."""
    outline = Outline(source)
    suggested = suggested_minutes(outline)
    for item in outline.items:
        assert abs(item.minutes - suggested[item.question]) <= max(10, suggested[item.question])
        assert item.minutes >= suggested[item.question] / 2 - STEP
    total = sum(suggested.values())
    assert 2 / 3 * total <= minutes(outline.items) <= 4 / 3 * total


BEYOND = "*Beyond the question.*"
LETTERED = re.compile(r"(?<![\w$])\([a-c]\) ")
CREDITED = re.compile(r"(?:^|[.:] )One(?= point|:| for)")


@each_source
def test_a_model_answer_has_no_more_words_than_stated(source):
    """The last paragraph may go beyond the question; it is not counted."""
    stated = {item.question: item.words for item in Outline(source).items}
    for cell in source.cells:
        if cell.answer:
            answer = cell.text.partition(BEYOND)[0]
            assert number_of_words(answer) <= stated[cell.answer], cell.answer


def test_a_question_in_words_asks_one_thing_and_its_rubric_has_a_sentence_for_each_point():
    """There are no lettered parts, and at most one question mark."""
    for cells in (source.cells for source in SOURCES):
        for before, cell, rubric in zip(cells, cells[1:], cells[2:], strict=False):
            if cell.answer:
                asked = before.text.partition(f"**{cell.answer}** ")[2].partition("<details>")[0]
                assert asked.count("?") <= 1, cell.answer
                lettered = map(LETTERED.search, (asked, cell.text, rubric.text))
                assert not any(lettered), cell.answer
                points = CREDITED.findall(" ".join(rubric.text.split()))
                assert len(points) == cell.metadata["points"], cell.answer


@pytest.mark.slow
@each_source
def test_each_question_shows_its_effort_once_in_both_notebooks(source):
    outline = Outline(source)
    for notebook in (notebooks.student_notebook(source), notebooks.solved_notebook(source)):
        text = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
        for item in outline.items:
            heading = rf"^#+ {item.question} .*\n\n\*{re.escape(effort(item))}\*$"
            bold = rf"^\*\*{item.question}\*\* \*\({re.escape(effort(item))}\)\*"
            assert len(re.findall(f"{heading}|{bold}", text, re.MULTILINE)) == 1
        assert notebook.cells[0].source.count("**Builds on**") == 1
        assert f"about {minutes(outline.core)} minutes" in notebook.cells[0].source


@each_source
def test_no_answer_of_the_core_calls_an_optional_function(source):
    """Students who skip the optional questions can answer all others."""
    outline, cells = Outline(source), source.answer_cells()
    optional = {item.function for item in outline.optional if item.function}
    for item in outline.core:
        if item.function:
            names = {
                n.id
                for n in ast.walk(ast.parse(cells[item.question].text))
                if isinstance(n, ast.Name)
            }
            assert not names & optional, item.question


def test_the_packaged_outline_is_up_to_date_with_the_sources():
    file = ROOT / "src/fieldcheck/outline.json"
    assert file.read_text(encoding="utf-8") == build.outline_file(ROOT)


# What is missing or contradictory is reported, and nothing is built.


@pytest.fixture
def second(tmp_path):
    """A copy of the source of notebook 02, with all that its outline needs."""
    for name in ("solutions/01_least_squares.py", "solutions/02_moving_least_squares.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    shutil.copytree(ROOT / "report/chapters", tmp_path / "report/chapters")
    return Source(tmp_path / "solutions/02_moving_least_squares.py")


def edited(source, pattern, replacement):
    text = source.path.read_text(encoding="utf-8")
    changed, count = re.subn(pattern, replacement, text, count=1)
    assert count == 1
    source.path.write_text(changed, encoding="utf-8")
    return Source(source.path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pattern", "replacement", "problem"),
    [
        (r'(question="02.1") minutes=\d+', r"\1", "02.1 has no minutes"),
        (r'(answer="02.3".*) words=\d+', r"\1", "02.3 has no words"),
        (r'(answer="02.3") points=\d+', r"\1", "02.3 has no points"),
        (r'(question="02.1") minutes=\d+', r"\1 minutes=151", "more than 150"),
        (r"#     pages: .*\n", "", "no pages"),
        (r"#     chapters: .*\n", "", "no chapters"),
    ],
)
def test_an_incomplete_outline_is_refused(second, pattern, replacement, problem):
    build.require_outline(second)
    with pytest.raises(ValueError, match=problem):
        build.require_outline(edited(second, pattern, replacement))


def test_an_optional_question_does_not_count_for_the_core(second):
    """Only the core is limited to one sitting."""
    core, everything = points(Outline(second).core), points(Outline(second).items)
    long = edited(second, r'(question="02.1") minutes=\d+', r"\1 minutes=151 optional")
    build.require_outline(long)
    assert core - points(Outline(long).core) == questions()["02.1"].points
    assert points(Outline(long).items) == everything


def test_a_notebook_builds_on_earlier_notebooks_and_existing_chapters_only(second):
    later = edited(second, r'"01": ', r'"02": ')
    with pytest.raises(ValueError, match="no earlier notebook"):
        notebooks.student_notebook(later)
    unknown = edited(second, r"12-moving-least-squares\]", "03-nothing]")
    with pytest.raises(ValueError, match="does not exist"):
        _ = Outline(unknown).chapters


# The rule for the minutes.


def suggestion(source, question):
    return suggested_minutes(Outline(source))[question]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pattern", "replacement", "question", "more"),
    [
        (r"(### 02.1 The weights\n)", r"\1#\n# " + 1300 * "word " + "\n", "02.1", 10),
        (r"(### 02.1 The weights\n)", r"\1#\n# " + 10 * "$$ x $$ " + "\n", "02.1", 10),
        (r'(question="02.1"(?s:.*?)# BEGIN SOLUTION\n)', r"\1" + 10 * "    x = 1\n", "02.1", 20),
        (r'(answer="02.3" points)=\d+', r"\1=14", "02.3", 20),
        (r'(answer="02.3".* words)=\d+', r"\1=290", "02.3", 10),
    ],
)
def test_more_text_or_a_longer_answer_takes_longer(second, pattern, replacement, question, more):
    """The time of the other questions remains the same."""
    before = suggested_minutes(Outline(second))
    after = suggested_minutes(Outline(edited(second, pattern, replacement)))
    assert abs(after.pop(question) - before.pop(question) - more) <= STEP
    assert after == before


# Progress.


def test_progress_adds_core_and_optional_points_separately():
    """A right answer to an optional question does not change the points of the core."""
    begun = [q for q in questions().values() if q.notebook == "12"]
    optional = {q.name for q in begun} & optional_questions()
    assert optional
    shown = Progress({q.name: "right" for q in begun})
    assert shown.earned == shown.possible == sum(q.points for q in begun if q.name not in optional)
    assert Progress(dict.fromkeys(optional, "right")).earned == 0
    lines = repr(shown).splitlines()
    worth = sum(q.points for q in begun if q.name in optional)
    assert lines[-1] == f"{worth} of {worth} points"
    core = f"{shown.possible} of {shown.possible} points for functions; "
    assert any(line.startswith(core) for line in lines)
    assert "Notebook 12, optional" in lines
    assert shown._repr_html_().count("<table>") == 2


def test_progress_without_optional_questions_has_one_sum():
    shown = Progress({"01.1": "right"})
    total = repr(shown).splitlines()[-1]
    assert total.startswith(f"{shown.earned:g} of {shown.possible} points for functions; ")
    assert shown._repr_html_().count("<table>") == 1
    assert fieldcheck.Progress is Progress


@pytest.mark.slow
def test_the_solved_notebook_shows_the_whole_outline():
    """Executed notebooks contain the table of the outline as it is now."""
    for source in SOURCES:
        notebook = nbformat.read(build.solved_file(ROOT, source), as_version=4)
        assert notebook.cells[0].source == notebooks.solved_notebook(source).cells[0].source
