"""Verdicts do not depend on rounding errors; a mistake whose numbers are such errors is found."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldcheck.answers import to_json
from fieldcheck.calls import Call
from fieldcheck.questions import get
from fieldgrade.authoring.catalogue import entries
from fieldgrade.authoring.known_answers import (
    answers_file,
    known_answers,
    public_calls,
    same_answers,
)
from fieldgrade.authoring.sources import Source
from fieldgrade.grader_validation import blas_kernels, rounding_errors
from fieldgrade.grader_validation.blas_kernels import JudgeRequest, KernelRun, Setting
from fieldgrade.grader_validation.known_verdicts import grader_reports
from fieldrecon.cli.main import main
from graded_class import SOURCES

SALT = "a salt"


@pytest.fixture
def course(tmp_path):
    """A copy of the first notebook's files, to damage."""
    first = SOURCES["01"].path
    for folder in ("", "misconceptions", "alternatives", "grading"):
        target = tmp_path / "solutions" / folder
        target.mkdir(parents=True, exist_ok=True)
        text = (first.parent / folder / first.name).read_text(encoding="utf-8")
        (target / first.name).write_text(text, encoding="utf-8")
    return Source(tmp_path / "solutions" / first.name)


def mistakes_file(course):
    return course.path.parent / "misconceptions" / course.path.name


NOISE = '''

@answers("01.2")
def vector_of_a_null_space(points, values):
    """The columns stand twice in the matrix, so any basis of its null space is as good as this one,
    and no two computers give the same.
    """
    b = np.insert(points, 0, 1.0, axis=1)
    return np.linalg.svd(np.hstack([b, b]))[2][-1, : b.shape[1]]


@answers("01.5")
def rounding_of_zero(coefficients, x):
    """These are the rounding errors of zero, and no two computers have the same rounding errors."""
    return (coefficients[1:] * 0.7 - coefficients[1:] / 10 * 7 + 1e-17) * 1e16 + 0 * x
'''


@pytest.fixture
def noisy(course):
    """The first notebook with two mistakes whose numbers are an arbitrary basis, and rounding."""
    path = mistakes_file(course)
    path.write_text(path.read_text(encoding="utf-8") + NOISE, encoding="utf-8")
    return course


def of_draws(source, question):
    found = rounding_errors.rounding_test(source, SALT, question)
    return rounding_errors.changes_of_draws(found, found.baseline())


numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)


@given(st.lists(numbers, min_size=1), numbers, st.integers(0, 99))
def test_inputs_change_in_their_last_digits(array, number, draw):
    """By 1e-14 up or down; zeros, whole numbers and arguments that are exact keep all digits."""
    given_arguments = (np.array(array), number, np.arange(3), 7, np.array(array))
    call = Call("f", given_arguments, "numbers", exact=(4,))
    (changed,) = rounding_errors.perturbed([call], draw)
    for new, old in zip(changed.arguments[:2], given_arguments[:2], strict=True):
        np.testing.assert_allclose(np.abs(new - old), 1e-14 * np.abs(old), rtol=0.02, atol=0)
    for new, old in zip(changed.arguments[2:], given_arguments[2:], strict=True):
        np.testing.assert_array_equal(new, old)
        assert type(new) is type(old)
    (again,) = rounding_errors.perturbed([call], draw)
    np.testing.assert_array_equal(again.arguments[0], changed.arguments[0])


@pytest.mark.slow
@pytest.mark.parametrize("question", ["04.3", "09.2"])
def test_verdicts_do_not_depend_on_the_last_digits(question):
    """Of the solution, all other right answers and all mistakes, for three students."""
    assert not of_draws(SOURCES[question[:2]], question)


@pytest.mark.slow
@pytest.mark.parametrize("number", SOURCES)
def test_no_verdict_depends_on_the_last_digits(number):
    """Of any question."""
    assert not of_draws(SOURCES[number], "")


@pytest.mark.parametrize(
    ("question", "name"),
    [("01.2", "vector of a null space"), ("01.5", "rounding of zero")],
)
def test_a_mistake_that_is_rounding_is_found(noisy, question, name):
    """By its name, and nothing else of the question."""
    (sentence,) = of_draws(noisy, question)[question]
    assert re.match(
        rf"the mistake '{name}' is judged wrong and no longer '{name}' "
        r"when the inputs change by 1e-14 \(draw \d\): .* \(and \d+ times more\)",
        sentence,
    )


def test_the_command_refuses_such_a_mistake(noisy, capsys, monkeypatch):
    """With status 1, and a sentence that names question, mistake and change."""
    monkeypatch.setattr("fieldgrade.commands.course.settings", list)
    root = noisy.path.parents[1]
    assert main(["course", "--root", str(root), "check", "--question", "01.5"]) == 1
    (told,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("01.5")]
    assert told.startswith("01.5: the mistake 'rounding of zero' is judged wrong and no longer")


def test_inputs_on_one_line_must_be_declared_exact(monkeypatch):
    """Else the rank of points on one line changes with their last digits."""
    question = get("01.4")
    inexact = replace(
        question, inputs=lambda seed: tuple(replace(c, exact=()) for c in question.inputs(seed))
    )
    monkeypatch.setattr(rounding_errors, "questions", lambda: {"01.4": inexact})
    assert any(
        "'by differences' is judged wrong" in s for s in of_draws(SOURCES["01"], "01.4")["01.4"]
    )


def judged_by_processes(source, question, settings):
    baseline = rounding_errors.rounding_test(source, SALT, question).baseline()
    request = JudgeRequest((source,), SALT, question, baseline.known)
    runs = [(setting, blas_kernels.run(setting, request)) for setting in settings]
    verdicts = ((f"with {setting.name}", found.verdicts) for setting, found in runs)
    return runs, rounding_errors.changes(baseline.verdicts, verdicts)


@pytest.mark.slow
def test_other_kernels_find_an_arbitrary_basis(noisy):
    """Where kernels can be chosen, one of them at least is another than here."""
    two = (
        blas_kernels.settings()[:2]
        if blas_kernels.has_choice_of_kernels()
        else blas_kernels.settings()
    )
    runs, changes = judged_by_processes(noisy, "01.2", two)
    assert not list(blas_kernels.not_as_chosen(runs))
    told = changes.get("01.2", [])
    assert len(told) == int(blas_kernels.has_choice_of_kernels())
    assert all("'vector of a null space' is judged wrong" in sentence for sentence in told)


@pytest.mark.slow
def test_no_verdict_depends_on_the_kernels():
    """Of two notebooks full of linear algebra; `fieldrecon course check` tries all."""
    for number in ("04", "09"):
        runs, changes = judged_by_processes(SOURCES[number], "", blas_kernels.settings())
        assert not changes
        assert not list(blas_kernels.not_as_chosen(runs))


def test_all_dispatched_instructions_are_turned_off():
    """All that the running NumPy names, whichever processor it was built for."""
    *_, plain = blas_kernels.settings()
    names = set(np._core._multiarray_umath.__cpu_dispatch__)
    assert set(plain.environment["NPY_DISABLE_CPU_FEATURES"].split()) == names
    assert set(blas_kernels.dispatched()) <= names


def run_of(numpy, scipy="A", simd=()):
    return KernelRun({"NumPy": numpy, "SciPy": scipy}, simd, {})


def test_settings_that_run_the_same_kernels_are_refused():
    """A name that OpenBLAS does not know is ignored, and some kernels have several names."""
    zen, haswell = (Setting(f"the {core} kernels", {"OPENBLAS_CORETYPE": core}) for core in "ZH")
    off = Setting("SIMD off", {"NPY_DISABLE_CPU_FEATURES": "AVX2"})
    good = [(zen, run_of("Zen", "Zen")), (haswell, run_of("Haswell", "Haswell"))]
    assert not list(blas_kernels.not_as_chosen([*good, (off, run_of("Zen", "Zen"))]))
    (alike,) = blas_kernels.not_as_chosen([good[0], (haswell, run_of("Haswell", "Zen"))])
    assert alike == "SciPy's OpenBLAS runs Zen both with the Z kernels and the H kernels"
    (still_on,) = blas_kernels.not_as_chosen([(off, run_of("Zen", simd=("AVX2",)))])
    assert still_on == "with SIMD off, NumPy still dispatches to AVX2"


@pytest.mark.slow
def test_a_run_that_stops_is_told(course):
    """In the last line that it wrote."""
    (*_, plain), missing = blas_kernels.settings(), Source(course.path.with_name("02_none.py"))
    with pytest.raises(
        RuntimeError, match=r"SIMD of NumPy off stopped with status 1: FileNotFound"
    ):
        blas_kernels.run(plain, JudgeRequest((missing,), SALT, "", {}))


# Mistakes without a name, and the file of known answers


def test_a_mistake_without_a_name_is_not_among_the_known_ones(course):
    """It must lose its points all the same, and no other name may be given to it."""
    path = mistakes_file(course)
    text = path.read_text(encoding="utf-8")
    old = '@answers("01.5")\ndef times_the_place'
    assert old in text
    path.write_text(text.replace(old, old.replace(")", ", named=False)", 1)), encoding="utf-8")
    question = get("01.5")
    found = entries(course, "misconceptions")
    known = known_answers(question, public_calls(question), course.functions(), found)
    assert "times the place" in [m.name for m in found]
    assert "times the place" not in [m.name for m in known.mistakes]
    assert not [problem for p in grader_reports(course, SALT, "01.5") for problem in p.problems]


def test_known_answers_that_differ_by_rounding_are_kept():
    """So another processor changes no file; another number, sentence or mistake does."""
    text = answers_file(SOURCES["01"])

    def changed(factor, sentence=""):
        return re.sub(
            r'"numbers":\[(-?\d\.\d+)', lambda m: f'"numbers":[{float(m[1]) * factor}', text
        ).replace("The constant is missing", sentence or "The constant is missing")

    assert changed(1) != text or same_answers(text, text)
    assert same_answers(text, changed(1 + 1e-12))
    assert not same_answers(text, changed(1 + 1e-7))
    assert not same_answers(text, changed(1, "A constant is missing"))
    assert not same_answers("{}", text)


def test_the_known_answers_of_a_question_are_written_with_its_named_mistakes():
    """One of those of 11.1 is rounding errors, by its own sentence."""
    question, source = get("11.1"), SOURCES["11"]
    found = [m for m in entries(source, "misconceptions") if m.question == "11.1"]
    written = to_json(known_answers(question, public_calls(question), source.functions(), found))
    named = {m.name for m in found} - {"mean of squares less square of mean"}
    assert {m["name"] for m in written["mistakes"]} == named
