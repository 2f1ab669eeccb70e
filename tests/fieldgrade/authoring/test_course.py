"""Notebooks match their sources, solutions do not leak to students, and the graders are proved."""

import ast
import json
import re
import shutil
import subprocess
import sys
import zipfile

import nbformat
import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.calls import Call
from fieldcheck.questions import questions
from fieldcheck.seeds import PUBLIC_SALT
from fieldgrade.authoring import (
    build,
    bundle,
    catalogue,
    leaks,
    notebooks,
    secret_salt,
)
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.known_answers import answers_file, same_answers
from fieldgrade.authoring.publish import publish
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import trials
from fieldgrade.grader_validation import blas_kernels, known_verdicts, mutants
from fieldrecon.cli.main import main

SOURCES = build.all_sources(ROOT)
each_source = pytest.mark.parametrize("source", SOURCES, ids=[s.name for s in SOURCES])
LONG = ("02", "04", "05", "11", "13", "14")
each_source_long_ones_slow = pytest.mark.parametrize(
    "source",
    [
        pytest.param(s, id=s.name, marks=pytest.mark.slow if s.number in LONG else ())
        for s in SOURCES
    ],
)


@each_source
def test_the_student_notebook_is_up_to_date_with_its_source(source):
    """`make notebooks` was run after the last change, and it always writes the same bytes."""
    file = ROOT / "exercises" / f"{source.name}.ipynb"
    made = notebooks.to_text(notebooks.student_notebook(source))
    assert made == notebooks.to_text(notebooks.student_notebook(Source(source.path)))
    assert file.read_text(encoding="utf-8") == made


@each_source
def test_cell_headers_alone_give_the_written_questions(source):
    """Reading the headers is faster than reading the whole notebook and gives the same points."""
    reported = {c.answer: float(c.metadata.get("points", 0)) for c in source.cells if c.answer}
    assert source.written_points == reported
    assert reported


@each_source_long_ones_slow
def test_the_known_answers_are_up_to_date_with_the_source(source):
    """The packaged numbers are those of the solution and the mistakes today, up to rounding."""
    kept = (ROOT / f"src/fieldcheck/answers/{source.number}.json").read_text(encoding="utf-8")
    assert same_answers(kept, answers_file(source))


def test_the_stubs_are_up_to_date_with_the_sources():
    """`start_over` restores the cell that students received."""
    handed_out = (ROOT / "src/fieldcheck/stubs.json").read_text(encoding="utf-8")
    assert handed_out == build.stubs_file(ROOT)


LIST = re.compile(r"\s*([-+*>#]|\d+[.)])\s|\s*(=+|-+)\s*$")


@each_source
def test_no_line_of_a_formula_looks_like_a_list_item(source):
    """Some editors parse lists before formulas, so no line of a formula may look like a list."""
    text = "\n".join(cell.text for cell in source.cells if cell.kind == "markdown")
    lines = [
        line
        for formula in re.findall(r"\$\$.*?\$\$", text, re.DOTALL)
        for line in formula.splitlines()
    ]
    assert lines
    assert not [line for line in lines if LIST.match(line)]
    assert all(LIST.match(line) for line in ("   + b", "- b", "2. b", "==="))


@each_source
def test_drawing_cells_are_folded_and_question_cells_are_not(source):
    """An editor that does not support folding merely shows the code of the picture."""
    cells = notebooks.student_notebook(source).cells
    folded = [c for c in cells if c.metadata.get("jupyter", {}).get("source_hidden")]
    assert folded
    assert all("@draw(" in c.source or "@drag(" in c.source for c in folded)
    assert not any("question" in c.metadata for c in folded)
    assert not any(c.source.startswith("@dra") for c in cells if c not in folded)


@each_source
def test_every_notebook_imports_start_over(source):
    """`start_over` restores the empty cell of a question."""
    setup = [cell.text for cell in source.cells if cell.is_setup]
    assert any("start_over" in text for text in setup)


@each_source
def test_the_executed_solution_is_current_and_free_of_errors(source):
    """The executed notebook was made from the present source, and none of its cells failed."""
    assert build.is_solved(ROOT, source)
    notebook = nbformat.read(build.solved_file(ROOT, source), as_version=4)
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert not [output for output in outputs if output["output_type"] == "error"]
    checks = [cell for cell in notebook.cells if cell.source.startswith("check(")]
    reported = [output["data"]["text/plain"] for cell in checks for output in cell.outputs]
    assert len(reported) == len(source.answer_cells())
    assert all("— right" in text and "slow" not in text for text in reported), reported
    assert "waits for" not in str(outputs)
    assert "cannot be drawn" not in str(outputs)


OTHER_CLOCK = """\
import time
now, counter = time.time, time.perf_counter
time.time, time.perf_counter = lambda: now() + 3e7, lambda: 3 * counter()
"""
"""A start file of Python: a year later, and every call takes three times as long."""


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """Other surroundings: clock, folders, time zone, language, and seed of the hashes."""

    def go():
        (tmp_path / "sitecustomize.py").write_text(OTHER_CLOCK)
        (tmp_path / "a long way off").mkdir()
        monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "a long way off"))
        changed = {"PYTHONHASHSEED": "2", "TZ": "Pacific/Auckland", "LC_ALL": "C", "COLUMNS": "200"}
        for name, value in (changed | {"PYTHONPATH": str(tmp_path)}).items():
            monkeypatch.setenv(name, value)

    return go


@pytest.mark.slow
@each_source
def test_executing_a_solution_elsewhere_gives_what_is_kept(source, elsewhere):
    """With equal versions of the packages, when, where and how fast makes no difference.

    The executed notebook of the checkout may be made with other versions. It has the same cells,
    kinds of outputs, and verdicts.
    """
    here = build.solve(ROOT, source) if source.number in ("03", "06") else None
    elsewhere()
    again = build.solve(ROOT, source)
    assert here in (None, again)
    kept = build.solved_file(ROOT, source).read_text(encoding="utf-8")
    assert independent_of_versions(kept) == independent_of_versions(again)


def independent_of_versions(text):
    """All of an executed notebook but numbers and drawings, which differ between versions."""
    notebook = nbformat.reads(text, as_version=4)
    cells = [
        (
            cell.source,
            [(output.output_type, sorted(output.get("data", ()))) for output in outputs],
            [output.data["text/plain"] for output in outputs if cell.source.startswith("check(")],
        )
        for cell in notebook.cells
        for outputs in [cell.get("outputs", ())]
    ]
    return notebook.metadata, cells


@pytest.mark.slow
@each_source
def test_the_untouched_student_notebook_runs_without_errors(source):
    """Each check reports that nothing is written yet, and each picture waits for its answer."""
    notebook = notebooks.execute(notebooks.student_notebook(source))
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert not [output for output in outputs if output["output_type"] == "error"]
    reported = [
        output["data"]["text/plain"]
        for cell in notebook.cells
        if cell.source.startswith("check(")
        for output in cell.outputs
    ]
    assert len(reported) == len(source.answer_cells())
    assert all("not written yet" in text for text in reported), reported


@each_source
def test_every_question_has_a_cell_and_a_check(source):
    """Cells and checks have the names of the questions; written questions have a rubric."""
    asked = {name for name, question in questions().items() if question.notebook == source.number}
    assert set(source.answer_cells()) == asked
    code = "\n".join(cell.text for cell in source.cells if cell.kind == "code")
    for name in asked:
        assert f'check("{name}")' in code
    answers = [cell.answer for cell in source.cells if cell.answer]
    assert answers
    assert answers == [cell.rubric for cell in source.cells if cell.rubric]
    assert all("points" in cell.metadata for cell in source.cells if cell.answer)
    assert code.rstrip().endswith("progress()")


@each_source
def test_an_answer_cell_defines_only_the_function_of_its_question(source):
    """The function has a docstring, and the cell has exactly one solution."""
    for name, cell in source.answer_cells().items():
        functions = [n for n in ast.parse(cell.text).body if isinstance(n, ast.FunctionDef)]
        assert [f.name for f in functions] == [questions()[name].function]
        assert ast.get_docstring(functions[0])
        assert len(cell.solutions) == 1
        compile(notebooks.stub(cell), "stub", "exec")


@pytest.mark.slow
@each_source
def test_every_grader_gives_the_expected_verdicts(source):
    """The solution and the alternative right answers earn all points, the stub earns none, each
    misconception receives its own sentence, and small changes to the solution lose points.
    """
    proofs = list(known_verdicts.grader_reports(source, PUBLIC_SALT))
    assert [p.question for p in proofs] == list(source.answer_cells())
    assert not [f"{p.question}: {problem}" for p in proofs for problem in p.problems]


def test_every_notebook_has_at_least_six_misconceptions():
    """The whole course has more than six misconceptions per notebook on average."""
    known = [len(catalogue.entries(source, "misconceptions")) for source in SOURCES]
    assert min(known) >= 6
    assert sum(known) >= 6 * len(SOURCES) + 2


# Each check of the graders must be able to fail.


@pytest.fixture
def course(tmp_path):
    """A copy of the first notebook's files, to damage."""
    first = SOURCES[0].path
    for folder in ("", "misconceptions", "alternatives", "grading"):
        target = tmp_path / "solutions" / folder
        target.mkdir(parents=True, exist_ok=True)
        (target / first.name).write_text((first.parent / folder / first.name).read_text())
    return Source(tmp_path / "solutions" / first.name)


def damage(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def problems(source, question):
    return [
        problem
        for p in known_verdicts.grader_reports(source, PUBLIC_SALT, question)
        for problem in p.problems
    ]


def test_a_question_with_too_few_alternative_answers_is_reported(course):
    damage(course.path.parent / "alternatives" / course.path.name, '@answers("01.5")\n', "")
    assert any("only 2 alternative right answers" in p for p in problems(course, "01.5"))


def test_a_rejected_alternative_answer_is_reported(course):
    """If a right answer is judged wrong, the grader has a defect."""
    path = course.path.parent / "alternatives" / course.path.name
    damage(path, "(coefficients[np.newaxis, 1:]", "(coefficients[np.newaxis, :-1]")
    assert any("the right answer 'repeated' gets: 01.5" in p for p in problems(course, "01.5"))


def test_a_misconception_that_gives_the_right_numbers_is_reported(course):
    path = course.path.parent / "misconceptions" / course.path.name
    damage(path, "return coefficients[1:] * x", "return coefficients[1:] + 0 * x")
    found = problems(course, "01.5")
    assert any("'times the place' gets the verdict right" in p for p in found)
    assert any("tolerances apart" in p for p in found)


def test_two_indistinguishable_misconceptions_are_reported(course):
    """Two misconceptions with the same numbers cannot each have a sentence of their own."""
    path = course.path.parent / "misconceptions" / course.path.name
    damage(path, "return coefficients[1:] * x", "return np.tile(coefficients[:-1], (len(x), 1))")
    found = problems(course, "01.5")
    assert any("'times the place'" in p and "tolerances apart" in p for p in found)


@pytest.mark.slow
def test_a_surviving_mutant_is_reported(course):
    """A mutant of code that no check uses survives, and the report asks for a reason."""
    damage(course.path, "    residual =", "    spare = 1 + 2\n    residual =")
    found = problems(course, "01.6")
    assert any("no reason is given why this survives" in p for p in found)
    assert any("mutants lose points" in p for p in found)


@pytest.mark.slow
def test_an_obsolete_reason_for_a_survivor_is_reported(course):
    """A reason given for a mutant that is caught must be removed."""
    reasons = '["01.5"]\n"line 1: x becomes y" = "because"\n'
    (course.path.parent / "grading" / "survivors.toml").write_text(reasons)
    assert any("but this is caught" in p for p in problems(course, "01.5"))


@pytest.mark.slow
def test_a_wrong_solution_is_reported(course):
    """The laws of the questions judge the solution, too."""
    damage(course.path, "b.T @ values", "b.T @ (values + 1)")
    verdicts = problems(course, "01.2")
    assert any("the solution is not right" in p for p in verdicts)


def test_the_stub_keeps_the_docstring_and_omits_the_solution():
    """The stub raises NotImplementedError where the answer belongs."""
    cell = SOURCES[0].answer_cells()["01.2"]
    empty = notebooks.stub(cell)
    assert "Return c of (1.4)" in empty
    assert "solve" not in empty
    assert 'raise NotImplementedError("01.2 is not written yet")' in empty
    assert "SOLUTION" not in empty


# Leaks


@pytest.mark.slow
def test_student_files_contain_no_hidden_material():
    """No code of a solution, no model answer and no number of a hidden case leaks to students."""
    assert not list(build.leaks(ROOT, "a secret salt"))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("hint.py", "def f(b, values):\n    return np.linalg.solve(b.T @ b, b.T @ values)\n"),
        ("hint.json", json.dumps({"stub": ["np.linalg.solve(b.T  @ b,  b.T @ values) # as told"]})),
        ("hint.py", "def f():\n    'Try np.linalg.solve(b.T @ b, b.T @ values).'\n"),
        ("hint.md", "By counting, the system is over-determined"),
    ],
)
def test_a_leaked_part_of_a_solution_is_found(name, text):
    """Leaks in code, strings and prose are found; white space and comments do not hide them."""
    if name.endswith(".md"):
        answer = next(cell.text for cell in SOURCES[0].cells if cell.answer).split()
        text = f"Before.\n{' '.join(answer[5:20])}\nAfter."
    assert list(leaks.code_leaks(SOURCES[0], {name: text}))


def test_a_leak_in_a_notebook_output_is_found():
    output = nbformat.v4.new_output("stream", text="np.linalg.solve(b.T @ b, b.T @ values)")
    cell = nbformat.v4.new_code_cell("1", outputs=[output])
    text = nbformat.writes(nbformat.v4.new_notebook(cells=[cell]))
    assert list(leaks.code_leaks(SOURCES[0], {"a.ipynb": text}))


def test_a_leak_is_reported_with_its_file_and_line():
    """The leak may be in code, in notebook cells or outputs, or under a key of a JSON file."""
    leak = "\n  np.linalg.solve(b.T @ b, b.T @ values)"
    code = nbformat.v4.new_code_cell(leak, outputs=[nbformat.v4.new_output("stream", text=leak)])
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("1"), code])
    files = {
        "hint.py": f"def fit():{leak}",
        "more.py": f'def fit():\n    """Hint.\n{leak}\n    """',
        "hint.ipynb": nbformat.writes(notebook),
        "hint.json": json.dumps({"01.2": leak}),
        "hint.md": f"Try{leak}.",
    }
    places = [
        "hint.py, line 2",
        "more.py, line 4",
        "hint.ipynb, cell 2, line 2",
        "hint.ipynb, output of cell 2, line 2",
        "hint.json, 01.2, line 2",
        "hint.md, line 2",
    ]
    part = "np.linalg.solve ( b.T @ b , b.T @"
    assert list(dict.fromkeys(leaks.code_leaks(SOURCES[0], files))) == [
        f"{place} holds a part of a solution of 01_least_squares: {part}" for place in places
    ]


@each_source
def test_common_idioms_are_not_leaks(source):
    """Sums along an axis, loops and empty arrays occur in every program."""
    law = """
def momentum(forces, areas):
    total = np.zeros((len(forces), 3))
    for k in range(len(forces)):
        total[k] = forces[k] * areas[k]
    return (total).sum(axis=0), total[:, 0] / total.sum(axis=1, keepdims=True)
"""
    assert not list(leaks.code_leaks(source, {"law.py": law}))


@each_source
def test_every_solution_is_found_if_it_leaks(source):
    """Every solution that is long enough to be distinctive is found, also in a one-line comment."""
    for cell in source.cells:
        for body in cell.solutions:
            if leaks.token_runs(body):
                assert list(leaks.code_leaks(source, {"a.py": f"if True:\n{body}"}))
                joined = " ".join(line.partition("#")[0] for line in body.splitlines())
                assert list(leaks.code_leaks(source, {"a.js": f"# {joined}"}))


@pytest.fixture
def changed_course(tmp_path):
    """A checkout with the first notebook, whose source was changed since it was built."""
    for folder in ("exercises", "solutions", "src/fieldcheck"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=all_but_the_first)
    for file in ("LICENSE", "docs/students.md", "report/chapters/11-least-squares.md"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / file, tmp_path / file)
    source = tmp_path / "solutions" / SOURCES[0].path.name
    source.write_text(source.read_text("utf-8").replace("# # ", "# # New: ", 1), encoding="utf-8")
    return tmp_path


def all_but_the_first(_, names):
    return [n for n in names if re.match(r"(0[2-9]|1\d)|__pycache__", n)]


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")
    return {path: path.read_bytes() for path in files}


@pytest.mark.slow
def test_a_leak_stops_the_build_before_any_file_is_written(changed_course):
    """No file is changed, and no file is added."""
    hint = changed_course / "src/fieldcheck/verdict.py"
    hint.write_text(f"{hint.read_text('utf-8')}\n\nhint = np.linalg.solve(b.T @ b, b.T @ values)\n")
    line = len(hint.read_text("utf-8").splitlines())
    before = contents(changed_course)
    with pytest.raises(ValueError, match=rf"src/fieldcheck/verdict\.py, line {line} holds a part"):
        build.build(changed_course, build.all_sources(changed_course))
    assert contents(changed_course) == before


@pytest.mark.slow
def test_a_leak_from_a_cell_of_the_source_stops_the_build(changed_course):
    """A cell of the source contains solution code outside the solution markers."""
    source = changed_course / "solutions" / SOURCES[0].path.name
    leak = "# %%\nnp.linalg.solve(b.T @ b, b.T @ values)\n\n# %%\n"
    source.write_text(source.read_text("utf-8").replace("# %%\n", leak, 1), encoding="utf-8")
    before = contents(changed_course)
    with pytest.raises(ValueError, match=r"exercises/01_least_squares\.ipynb, cell \d+, line 1 "):
        build.build(changed_course, build.all_sources(changed_course))
    assert contents(changed_course) == before


def written(*numbers):
    """A file of numbers, as the guard reads it."""
    return {"numbers.json": leaks.long_numbers(json.dumps(numbers))}


def test_leaked_numbers_of_a_hidden_case_are_found():
    """An array, a row, or any two numbers of a hidden input or of its answer, also rounded."""
    source, question = SOURCES[0], questions()["01.2"]
    tried = trials(question, source.functions(), [], [], "leak", "a secret salt")[1]

    def found(*numbers):
        return list(leaks.number_leaks(tried.calls, tried.answers.right, written(*numbers)))

    for array in (tried.calls[0].arguments[0], tried.answers.right[0][0]):
        x, y = map(float, array.ravel()[:2])
        assert found(array.tolist()), "the whole array"
        assert found(np.atleast_2d(array)[0].tolist()), "a row"
        assert found(y, 1.0, x), "a list of numbers in another order"
        assert found(float(f"{x:.9g}"), float(f"{y:.12g}")), "rounded"
        assert not found(x, float(f"{x:.9g}")), "one number, which may agree by chance"
        assert not found(x * (1 + 1e-10), y * (1 + 1e-10)), "nine digits agree, and three do not"
    assert not found(0.5, 0.123456789123)


@pytest.mark.parametrize(
    ("answer", "public", "is_leak"),
    [
        (0.123456789123, [0.123456789123], True),
        ([0.123456789123], [7.0, 0.123456789], True),
        ([0.123456789123, 1.0, 0.0], [0.0, 1.0, 0.123456789123], True),
        ([0.123456789123, 0.987654321987], [0.123456789123], False),
        ([0.0, -(2.0**-53), 3 * 2.0**-52], [-(2.0**-53), 3 * 2.0**-52], False),
        ([0.1 + 0.2 - 0.3, 1 - 0.9 - 0.1], [0.1 + 0.2 - 0.3, 1 - 0.9 - 0.1], False),
        ([1 / 1024, 2 / 3], [1 / 1024, 1 / 3], False),
        ([8 / 31, 10 / 23, -8 / 3], [8 / 31, 10 / 23, -8 / 3], False),
        ([8 / 31, 0.123456789123], [0.123456789123, 8 / 31], True),
        (np.sqrt([2, 3]), np.sqrt([2, 3]), True),
        ([1.0877919644084146e-15, 1.0], [1.0877919644084146e-15], False),
        (1.0877919644084146e-15, [1.0877919644084146e-15], True),
    ],
)
def test_rounding_errors_and_short_numbers_are_not_a_leak(answer, public, is_leak):
    """A number that is the whole answer is a leak; ratios of small integers and 2⁻⁵³ are none."""
    answers = [(np.asarray(answer),)]
    assert bool(list(leaks.number_leaks((), answers, written(*public)))) == is_leak


def test_weights_beside_huge_lengths_are_secret():
    call, answers = Call("f", (1e14 * np.ones(3),), "another unit"), [(np.sqrt([2, 3]),)]
    assert list(leaks.number_leaks([call], answers, written(*np.sqrt([2, 3]))))


def test_a_number_of_a_public_call_is_not_a_leak():
    """An angle or a distance may be the same for all students; other numbers beside it are not."""
    answers = [(np.sqrt([2, 3, 5]),)]
    known = leaks.numbers_of([Call("f", (np.sqrt(2),), "a diagonal")], [])
    assert not list(leaks.number_leaks((), answers, written(*np.sqrt([2, 3])), known))
    assert list(leaks.number_leaks((), answers, written(*np.sqrt([3, 5])), known))


@pytest.fixture(scope="session")
def numbers_for_students():
    """The long numbers in each file of the bundle."""
    files = {name: path for name, path in bundle.student_tree(ROOT) if path.is_file()}
    return {name: leaks.long_numbers(path.read_text("utf-8")) for name, path in files.items()}


@pytest.mark.slow
@each_source
def test_the_bundle_is_made_whatever_the_secret_is(source, numbers_for_students):
    """The files for students hold no hidden case of another secret than that tried above."""
    functions, hidden = source.functions(), hidden_cases(source)
    for question in questions().values():
        if question.notebook == source.number:
            public, *others = trials(question, functions, [], hidden, "leak", "another")
            known = leaks.numbers_of(public.calls, public.answers.right)
            for trial in others:
                values = trial.calls, trial.answers.right
                found = leaks.number_leaks(*values, numbers_for_students, known)
                assert not list(found), (question.name, trial.name)


# The bundle


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The bundle in a folder of its own."""
    folder = tmp_path_factory.mktemp("bundle")
    file = bundle.write_bundle(ROOT, folder / "bundle.zip")
    with zipfile.ZipFile(file) as archive:
        archive.extractall(folder)
    return folder / bundle.FOLDER


def test_the_student_bundle_is_reproducible_and_complete(tmp_path):
    """The bundle has the same bytes each time, contains what a student needs, and no solutions."""
    one = bundle.write_bundle(ROOT, tmp_path / "one.zip").read_bytes()
    assert bundle.write_bundle(ROOT, tmp_path / "two.zip").read_bytes() == one
    names = zipfile.ZipFile(tmp_path / "one.zip").namelist()
    for name in ("README.md", "requirements.txt", "student.txt", "01_least_squares.ipynb"):
        assert f"{bundle.FOLDER}/{name}" in names
    assert not [name for name in names if "solution" in name or "misconception" in name]


@pytest.mark.slow
def test_the_bundle_checks_answers_without_fieldrecon(unpacked):
    """The bundled package runs where neither fieldrecon nor SciPy can be imported."""
    program = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("fieldrecon", "scipy", "ipywidgets", "IPython", "pandas"):
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Missing())
import numpy as np, fieldcheck
print(fieldcheck.__file__)
def basis_matrix(points):
    return np.insert(points, 0, 1.0, axis=1)
print(fieldcheck.check("01.1"))
def basis_matrix(points):
    return points
print(fieldcheck.check("01.1"))
"""
    run = subprocess.run(
        [sys.executable, "-c", program],
        cwd=unpacked,
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": str(unpacked), "MPLCONFIGDIR": str(unpacked)},
    )
    where, right, wrong = run.stdout.splitlines()
    assert where.startswith(str(unpacked))
    assert right == "01.1 — right."
    assert "The column of ones is missing" in wrong


def test_fieldcheck_imports_only_packages_that_students_have():
    allowed = {"numpy", "matplotlib", "ipywidgets", "IPython", "fieldcheck", "__future__"}
    for path in (ROOT / "src/fieldcheck").rglob("*.py"):
        imported = {name.partition(".")[0] for name in imports(path)}
        assert imported <= allowed | set(sys.stdlib_module_names), path.name


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield node.module or ""
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


# Pages


@pytest.mark.slow
def test_a_published_solution_is_reproducible_and_self_contained(tmp_path):
    """HTML and PDF have the same bytes each time, and the page loads nothing from the network."""
    page, paper = publish(ROOT, SOURCES[0], tmp_path / "one")
    again = publish(ROOT, SOURCES[0], tmp_path / "two")
    assert [p.read_bytes() for p in again] == [page.read_bytes(), paper.read_bytes()]
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="https?://', text)
    assert "(1.4)" in text
    assert "How it is graded" in text
    assert text.count("<img") == text.count('src="data:image/svg+xml;base64,') > 2


@pytest.mark.slow
def test_solutions_are_published_from_paths_with_special_characters(tmp_path):
    """The paths contain characters that Lua's search path, shells and URLs reserve."""
    root = tmp_path / "a; b? #c%20 'd' ü"
    shutil.copytree(ROOT / "report", root / "report", ignore=shutil.ignore_patterns("build"))
    (root / "solutions").mkdir()
    for ending in (".py", ".ipynb"):
        shutil.copy(SOURCES[0].path.with_suffix(ending), root / "solutions")
    there = publish(root, SOURCES[0], root / "out")
    here = publish(ROOT, SOURCES[0], tmp_path / "out")
    assert [p.read_bytes() for p in there] == [p.read_bytes() for p in here]


@pytest.mark.slow
@each_source
def test_every_solution_can_be_published(source, tmp_path):
    """Every formula of every notebook survives the conversion to HTML and PDF."""
    page, paper = publish(ROOT, source, tmp_path)
    assert page.stat().st_size > 1e5
    assert paper.read_bytes().startswith(b"%PDF")


# The secret


def git(folder, *arguments):
    subprocess.run(["git", *arguments], cwd=folder, check=True, capture_output=True)


@pytest.fixture
def repository(tmp_path):
    """A repository that ignores the file of the secret salt."""
    git(tmp_path, "init", "-q")
    (tmp_path / ".gitignore").write_text(f"{secret_salt.FILE}\n")
    return tmp_path


def test_an_existing_secret_salt_is_not_replaced_without_renew(repository):
    """The salt is random, readable by its owner only, and replaced only with --renew."""
    assert not secret_salt.read_salt(repository).secret
    made = secret_salt.make_salt(repository, 2031)
    assert secret_salt.read_salt(repository) == made
    assert made.secret
    assert (repository / secret_salt.FILE).stat().st_mode & 0o077 == 0
    with pytest.raises(ValueError, match="exists, for 2031; with --renew"):
        secret_salt.make_salt(repository, 2032)
    assert secret_salt.make_salt(repository, 2032, renew=True).text != made.text


def test_a_secret_salt_that_git_tracks_or_would_track_is_refused(repository):
    secret_salt.make_salt(repository, 2031)
    git(repository, "add", "--force", secret_salt.FILE)
    with pytest.raises(ValueError, match="git tracks"):
        secret_salt.read_salt(repository)
    git(repository, "rm", "--cached", "-q", secret_salt.FILE)
    (repository / ".gitignore").write_text("")
    with pytest.raises(ValueError, match="git does not ignore"):
        secret_salt.make_salt(repository, 2031, renew=True)


def test_a_damaged_secret_salt_is_reported(tmp_path):
    """A damaged salt is not replaced, since it may be needed to grade again."""
    (tmp_path / secret_salt.FILE).write_text("{}")
    with pytest.raises(ValueError, match="is damaged"):
        secret_salt.read_salt(tmp_path)


def test_this_repository_ignores_the_secret_salt():
    listed = subprocess.run(
        ["git", "check-ignore", secret_salt.FILE],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode != 128:  # an unpacked archive is no repository
        assert listed.stdout.strip() == secret_salt.FILE


# The command


@pytest.mark.slow
def test_the_check_command_warns_if_there_is_no_secret_salt(capsys, monkeypatch):
    """The command proves one question under one kernel setting and names that setting."""
    monkeypatch.setattr("fieldgrade.commands.course.settings", lambda: blas_kernels.settings()[-1:])
    assert main(["course", "--root", str(ROOT), "check", "--question", "01.5"]) == 0
    printed = capsys.readouterr()
    assert "01.5" in printed.out
    assert "With all dispatched SIMD of NumPy off: " in printed.out
    assert "; NumPy dispatches to nothing." in printed.out
    if not secret_salt.read_salt(ROOT).secret:
        assert "There is no secret salt" in printed.err


def test_the_check_command_refuses_an_unknown_notebook(capsys):
    """The command prints a sentence and exits with status 2."""
    assert main(["course", "--root", str(ROOT), "check", "--only", "77"]) == 2
    assert "there is no notebook 77" in capsys.readouterr().err


def test_each_mutant_changes_one_thing():
    """It changes an operator, a number, a transpose or an axis, or omits a function call."""
    code = "def f(a, b):\n    return abs(a.T @ b).sum(axis=1) > -2.5"
    changed = {text.splitlines()[1].strip() for _, text in mutants.mutants(code)}
    assert {
        "return abs(a.T * b).sum(axis=1) > -2.5",
        "return abs(a @ b).sum(axis=1) > -2.5",
        "return (a.T @ b).sum(axis=1) > -2.5",
        "return abs(a.T @ b).sum() > -2.5",
        "return abs(a.T @ b).sum(axis=1) <= -2.5",
        "return abs(a.T @ b).sum(axis=1) > 2.5",
        "return abs(a.T @ b).sum(axis=2) > -2.5",
        "return abs(a.T @ b).sum(axis=0) > -2.5",
    } <= changed
    assert np.all([text != code for text in changed])
