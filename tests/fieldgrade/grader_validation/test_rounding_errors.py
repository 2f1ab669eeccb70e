"""Verdicts do not depend on rounding; misconceptions that consist of rounding errors are found."""

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
    """Notebook 01 with two added misconceptions: an arbitrary basis vector, and pure rounding."""
    path = mistakes_file(course)
    path.write_text(path.read_text(encoding="utf-8") + NOISE, encoding="utf-8")
    return course


def changes_under_perturbation(source, question):
    found = rounding_errors.rounding_test(source, SALT, question)
    return rounding_errors.changes_of_draws(found, found.baseline())


numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)


@pytest.mark.slow
@given(st.lists(numbers, min_size=1), numbers, st.integers(0, 99))
def test_perturbations_change_the_last_digits_only(array, number, draw):
    """The relative change is 1e-14; zeros, integers and arguments declared exact do not change."""
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
def test_verdicts_of_two_questions_do_not_depend_on_the_last_digits(question, monkeypatch):
    """The verdicts on solution, alternatives and misconceptions, for one student and ten draws."""
    monkeypatch.setattr(rounding_errors, "STUDENTS", ("second",))
    assert not changes_under_perturbation(SOURCES[question[:2]], question)


@pytest.mark.slow
@pytest.mark.parametrize("number", SOURCES)
def test_no_verdict_of_any_question_depends_on_the_last_digits(number, monkeypatch):
    """On the inputs of all students, once; `fieldrecon course check` tries ten draws, and the own
    and hidden inputs of three students, as the test above for two questions.
    """
    monkeypatch.setattr(rounding_errors, "DRAWS", 1)
    monkeypatch.setattr(rounding_errors, "STUDENTS", ())
    assert not changes_under_perturbation(SOURCES[number], "")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("question", "name"),
    [("01.2", "vector of a null space"), ("01.5", "rounding of zero")],
)
def test_a_misconception_that_depends_on_rounding_is_reported(noisy, question, name):
    """The report names this misconception, and no other of the question."""
    (sentence,) = changes_under_perturbation(noisy, question)[question]
    assert re.match(
        rf"the mistake '{name}' is judged wrong and no longer '{name}' "
        r"when the inputs change by 1e-14 \(draw \d\): .* \(and \d+ times more\)",
        sentence,
    )


@pytest.mark.slow
def test_the_check_command_refuses_a_misconception_that_depends_on_rounding(
    noisy, capsys, monkeypatch
):
    """The exit status is 1; the message names the question, the misconception and the change."""
    monkeypatch.setattr("fieldgrade.commands.course.settings", list)
    root = noisy.path.parents[1]
    assert main(["course", "--root", str(root), "check", "--question", "01.5"]) == 1
    (reported,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("01.5")]
    assert reported.startswith("01.5: the mistake 'rounding of zero' is judged wrong and no longer")


@pytest.mark.slow
def test_collinear_inputs_must_be_declared_exact(monkeypatch):
    """Otherwise a wrong rank of collinear points changes with their last digits."""
    question = get("01.4")
    inexact = replace(
        question, inputs=lambda seed: tuple(replace(c, exact=()) for c in question.inputs(seed))
    )
    monkeypatch.setattr(rounding_errors, "questions", lambda: {"01.4": inexact})
    assert any(
        "'rounding counted' is judged wrong and no longer" in s
        for s in changes_under_perturbation(SOURCES["01"], "01.4")["01.4"]
    )


def judged_under_kernels(source, question, settings):
    baseline = rounding_errors.rounding_test(source, SALT, question).baseline()
    request = JudgeRequest((source,), SALT, question, baseline.known)
    runs = [(setting, blas_kernels.run(setting, request)) for setting in settings]
    verdicts = ((f"with {setting.name}", found.verdicts) for setting, found in runs)
    return runs, rounding_errors.changes(baseline.verdicts, verdicts)


@pytest.mark.slow
def test_another_kernel_reveals_an_arbitrary_basis(noisy):
    """Where kernels can be chosen, at least one of them differs from the default kernel."""
    two = (
        blas_kernels.settings()[:2]
        if blas_kernels.has_choice_of_kernels()
        else blas_kernels.settings()
    )
    runs, changes = judged_under_kernels(noisy, "01.2", two)
    assert not list(blas_kernels.not_as_chosen(runs))
    reported = changes.get("01.2", [])
    assert len(reported) == int(blas_kernels.has_choice_of_kernels())
    assert all("'vector of a null space' is judged wrong" in sentence for sentence in reported)


@pytest.mark.slow
def test_no_verdict_of_a_question_depends_on_the_kernels():
    """This one uses much linear algebra; `fieldrecon course check` tests all notebooks."""
    runs, changes = judged_under_kernels(SOURCES["09"], "09.2", blas_kernels.settings())
    assert not changes
    assert not list(blas_kernels.not_as_chosen(runs))


def test_the_plain_setting_disables_all_dispatched_simd():
    """The names come from the running NumPy, whatever processor it was built for."""
    *_, plain = blas_kernels.settings()
    names = set(np._core._multiarray_umath.__cpu_dispatch__)
    assert set(plain.environment["NPY_DISABLE_CPU_FEATURES"].split()) == names
    assert set(blas_kernels.dispatched()) <= names


def run_of(numpy, scipy="A", simd=()):
    return KernelRun({"NumPy": numpy, "SciPy": scipy}, simd, {})


def test_settings_that_run_the_same_kernels_are_reported():
    """OpenBLAS ignores unknown names, and some kernels have several names."""
    zen, haswell = (Setting(f"the {core} kernels", {"OPENBLAS_CORETYPE": core}) for core in "ZH")
    off = Setting("SIMD off", {"NPY_DISABLE_CPU_FEATURES": "AVX2"})
    good = [(zen, run_of("Zen", "Zen")), (haswell, run_of("Haswell", "Haswell"))]
    assert not list(blas_kernels.not_as_chosen([*good, (off, run_of("Zen", "Zen"))]))
    (alike,) = blas_kernels.not_as_chosen([good[0], (haswell, run_of("Haswell", "Zen"))])
    assert alike == "SciPy's OpenBLAS runs Zen both with the Z kernels and the H kernels"
    (still_on,) = blas_kernels.not_as_chosen([(off, run_of("Zen", simd=("AVX2",)))])
    assert still_on == "with SIMD off, NumPy still dispatches to AVX2"


@pytest.mark.slow
def test_a_failed_run_is_reported_with_its_last_line(course):
    (*_, plain), missing = blas_kernels.settings(), Source(course.path.with_name("02_none.py"))
    with pytest.raises(
        RuntimeError, match=r"SIMD of NumPy off stopped with status 1: FileNotFound"
    ):
        blas_kernels.run(plain, JudgeRequest((missing,), SALT, "", {}))


# Unnamed misconceptions, and the file of known answers


def test_an_unnamed_misconception_is_not_a_known_answer(course):
    """It must still lose its points, and must not be given the name of another misconception."""
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


@pytest.mark.slow
def test_known_answers_that_differ_by_rounding_are_the_same():
    """Another processor does not change the file; another number or sentence does."""
    text = answers_file(SOURCES["01"])

    def changed(factor, sentence='"sentence":"'):
        return re.sub(
            r'"numbers":\[(-?\d\.\d+)', lambda m: f'"numbers":[{float(m[1]) * factor}', text
        ).replace('"sentence":"', sentence)

    assert changed(1) != text or same_answers(text, text)
    assert same_answers(text, changed(1 + 1e-12))
    assert not same_answers(text, changed(1 + 1e-7))
    assert not same_answers(text, changed(1, '"sentence":"x'))
    assert not same_answers("{}", text)


def test_known_answers_contain_the_named_misconceptions():
    """Some misconceptions of 11.1 are unnamed, since their numbers are rounding errors."""
    question, source = get("11.1"), SOURCES["11"]
    found = [m for m in entries(source, "misconceptions") if m.question == "11.1"]
    written = to_json(known_answers(question, public_calls(question), source.functions(), found))
    named = {m.name for m in found if m.named}
    assert {m["name"] for m in written["mistakes"]} == named < {m.name for m in found}
