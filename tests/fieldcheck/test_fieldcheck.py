"""The first finding in the order of the checks is reported, with a sentence."""

import io
import json
import re
import sys
import time
from collections import Counter
from dataclasses import replace
from itertools import zip_longest

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes

import fieldcheck
from checkout import ROOT
from fieldcheck import answers, calls, figures, notebook, seeds
from fieldcheck.answers import Answers, Mistake, public_answers
from fieldcheck.calls import Call, Outcome, perform
from fieldcheck.failed_case import FailedCase
from fieldcheck.judge import judge
from fieldcheck.pictures import picture_of_difference
from fieldcheck.question import Law, Question, relative, unchanged
from fieldcheck.questions import get, questions
from fieldcheck.seeds import seed
from fieldcheck.shapes import fitted
from fieldcheck.verdict import FINDINGS, TITLES, Verdict
from fieldgrade.authoring.build import all_sources


def inputs(seed):
    random = np.random.default_rng(seed)
    return tuple(Call("twice", (random.normal(size=n),), f"{n} numbers") for n in (5, 3))


def is_linear(made, values):
    pairs = zip(made, values, strict=True)
    return max(relative(v.sum() - 2 * call.arguments[0].sum(), v) for call, (v,) in pairs)


TWICE = Question(
    "99.1",
    "twice",
    1,
    inputs,
    lambda call: (call.arguments[0].shape,),
    (Law("Twice the numbers have twice the sum.", is_linear),),
    limit=60.0,
)
CALLS = inputs(0)


def known():
    """The right numbers, and the numbers of one misconception."""
    squares = perform({"twice": lambda x: x**2}, CALLS, 1)
    return Answers(
        tuple((2 * call.arguments[0],) for call in CALLS),
        (Mistake("squared", "These are the squares.", squares),),
    )


def verdict_of(function, known=None):
    return judge(TWICE, CALLS, perform({"twice": function}, CALLS, 600), known)


def raises(_):
    raise ValueError("no   such\nthing")


def unwritten(_):
    raise NotImplementedError


def in_place(x):
    x *= 2
    return x


def decimals_in_place(x):
    y = x.astype(int)
    y *= 2.5
    return y


def last_wrong(x):
    y = 2 * x
    y[-1] += 1
    return y


def wrong_then_lost(x):
    """The first call has wrong values, and the second NaN: the first one is reported."""
    return 3 * x if len(x) == 5 else x * np.nan


@pytest.mark.parametrize(
    ("function", "finding", "words"),
    [
        (None, "missing", "There is no function twice"),
        (unwritten, "unwritten", "Write twice"),
        (raises, "exception", "twice stops with ValueError: no such thing. It arises in line"),
        (
            decimals_in_place,
            "exception",
            r"The array on the left holds integers, and takes no decimals, not even by `\+=` or",
        ),
        (lambda _: None, "type", "nothing \\(None\\), as where no `return` is reached"),
        (lambda _: "two", "type", "an object of type str"),
        (lambda _: [[1], [[1], 2]], "type", "not a rectangular array"),
        (lambda _: [[1], [1, 2]], "shape", r"shape \(1,\) and an array of shape \(2,\)"),
        (lambda x: [2 * float(t) for t in x], "right", r"But twice returns a list\. "),
        (lambda x: 1j * x, "type", "complex"),
        (lambda x: x[:-1], "shape", r"of shape \(4,\)\. It should be an array of shape \(5,\)"),
        (lambda x: x[:, None], "shape", r"shape \(5, 1\)"),
        (lambda x: 2 * x / (x - x[0]), "not finite", "1 of 5 values are NaN or infinite"),
        (wrong_then_lost, "wrong", r"off by \d"),
        (in_place, "modified", "changes its argument number 1"),
        (lambda x: x**2, "misconception", "These are the squares"),
        (last_wrong, "wrong", r"twice the sum\. For \d numbers, entry \[\d\] is off by 1\. The"),
        (lambda x: 2 * x, "right", ""),
        (lambda x: tuple(2 * x), "right", ""),
        (lambda x: np.matrix(2 * x), "right", r"But twice returns an np\.matrix, "),
        (lambda x: np.matrix(2 * x).T, "right", r"But twice returns an np\.matrix, "),
        (lambda x: np.matrix(2 * x)[:, :-1], "shape", r"shape \(1, 4\)"),
        (lambda x: [2 * t for t in x.reshape(-1, 1, 1)], "shape", r"shape \(5, 1, 1\)"),
        (lambda x: tuple(2 * t for t in x.reshape(-1, 1, 1)), "right", ""),
        (lambda x: 2 * x + 0j, "right", "But twice returns complex numbers"),
    ],
)
def test_each_answer_gets_the_first_failed_check(function, finding, words):
    """Each finding has its own sentence and credit."""
    verdict = verdict_of(function, known())
    assert verdict.finding == finding
    assert re.search(words, verdict.sentence) if words else not verdict.sentence
    assert verdict.credit == (1.0 if finding == "right" else 0.0)


def test_the_shown_case_violates_the_quoted_law():
    """A case with a larger error that obeys the law is not shown with it.

    If the law holds for each case, the first case is not passed over unless its error is small.
    """

    def sentence(by, of_each):
        off = by * np.array([1, -1, 0, 0, 0])
        outcomes = perform({"twice": lambda x: 2 * x + (off if len(x) == 5 else 0.1)}, CALLS, 600)
        obeyed = Law("Twice the numbers have twice the sum.", is_linear, of_each=of_each)
        return judge(replace(TWICE, laws=(obeyed,)), CALLS, outcomes, known()).sentence

    with_law = "Twice the numbers have twice the sum. For 3 numbers, "
    assert sentence(9, of_each=False).startswith(with_law)
    assert sentence(3e-8, of_each=True).startswith(with_law)
    assert sentence(9, of_each=True).startswith("For 5 numbers, entry [0] is off by 9.")


def test_the_shown_array_violates_the_quoted_law():
    """An array with a larger error of which the law says nothing is not shown with it."""
    pair = replace(
        TWICE,
        shapes=lambda call: (call.arguments[0].shape, ()),
        laws=(Law("Twice.", lambda made, values: is_linear(made, [(v[0],) for v in values])),),
    )
    right = Answers(tuple((2 * call.arguments[0], np.array(1.0)) for call in CALLS), ())

    def sentence(first, second):
        outcomes = perform({"twice": lambda x: (2 * x + first, 1.0 + second)}, CALLS, 600)
        return judge(pair, CALLS, outcomes, right).sentence

    assert re.match(r"Twice. For 5 numbers, entry \[.\] of the first array is", sentence(0.1, 9))
    assert sentence(0, 9).startswith("For 5 numbers, the second number is off by 9.")


def test_the_first_failing_case_is_shown():
    """Cases begin with the plain ones; the error of a later one may be larger, or the law too."""

    def larger_for_three(x):
        return 2 * x + (1 if len(x) == 5 else 1e6)

    verdict = verdict_of(larger_for_three, known())
    assert verdict.sentence.startswith("Twice the numbers have twice the sum. For 5 numbers, ")
    assert verdict.call == 0

    def obeys_the_law_first(x):
        return 2 * x + (np.array([9, -9, 0, 0, 0]) if len(x) == 5 else 0)

    verdict = verdict_of(obeys_the_law_first, known())
    assert verdict.sentence.startswith("For 5 numbers, entry [0] is off by 9.")


def test_the_first_case_of_a_wrong_form_is_shown():
    """A wrong shape explains the error that it causes in a later case."""

    def column(x):
        return x[:, None] if len(x) == 5 else x[:, None].sum(axis=2)

    assert verdict_of(column, known()).finding == "shape"


def test_a_law_may_say_what_its_deviation_is():
    """It says more than a difference where the right answer is one of many."""
    names_it = Law("Be right.", is_linear, of_each=True, amount="the sum is wrong by {:.1g}")
    outcomes = perform({"twice": lambda x: 2 * x + 1}, CALLS, 600)
    verdict = judge(replace(TWICE, laws=(names_it,)), CALLS, outcomes, known())
    deviation = is_linear(CALLS[:1], [outcomes[0].values])
    sentence = f"Be right. For 5 numbers, the sum is wrong by {deviation:.1g}."
    assert verdict.sentence.startswith(sentence)


def test_a_law_on_several_cases_is_quoted_without_one():
    """No single case violates it."""
    grows = Law(
        "The sums of two cases must differ.",
        lambda _, values: float(values[1][0].sum() == values[0][0].sum()),
    )
    several = replace(TWICE, laws=(grows,))
    outcomes = perform({"twice": np.zeros_like}, CALLS, 600)
    assert judge(several, CALLS, outcomes, known()).sentence == (
        "The sums of two cases must differ. The wrong values are all zero."
    )


def test_a_law_that_the_values_nearly_satisfy_is_not_quoted():
    """The same wrong value in both cases is compared with a right one, which differs from it."""
    compares = Law(
        "The largest numbers of two cases must be equal.",
        lambda _, values: float(np.ptp([v.max() for (v,) in values])),
    )
    numbers = tuple(Call("twice", (np.arange(n) / (n - 1),), f"{n} numbers") for n in (5, 3))
    question = replace(TWICE, inputs=lambda _: numbers, laws=(compares,))
    right = Answers(tuple((2 * call.arguments[0],) for call in numbers), ())

    def sentence(change):
        outcomes = perform({"twice": lambda x: 7 * x + change * len(x)}, numbers, 600)
        return judge(question, numbers, outcomes, right).sentence

    assert sentence(0.5).startswith(compares.sentence)
    assert sentence(1e-6).startswith("For 5 numbers, entry [4] is off by 5.")


@pytest.mark.parametrize(
    ("factors", "finding"),
    [((3, None), "wrong"), ((2, None), "exception"), ((2, 3, None), "exception")],
)
def test_an_error_hides_no_wrong_values_of_the_first_case(factors, finding):
    """Those of a later case may depend on the machine, as the error does."""
    made = tuple(Call("twice", (np.arange(1.0, 4),), f"case {k}") for k in range(len(factors)))
    outcomes = [
        Outcome("raised", error="LinAlgError: Singular matrix")
        if factor is None
        else Outcome("returned", values=(factor * call.arguments[0],))
        for factor, call in zip(factors, made, strict=True)
    ]
    right = Answers(tuple((2 * call.arguments[0],) for call in made), ())
    verdict = judge(replace(TWICE, inputs=lambda _: made), made, outcomes, right)
    assert verdict.finding == finding
    assert verdict.call == (0 if finding == "wrong" else len(factors) - 1)


def near_and_far(first, last):
    """The verdict on numbers near zero, far away, and not returned, beside rounded right ones.

    The law on their differences needs more digits than are stored far away.
    """
    made = tuple(
        Call("twice", (x,), f"case {k}")
        for k, x in enumerate((np.arange(3.0), np.arange(3) + 1 / 3, 1e7 + np.arange(3) / 3))
    )
    spread = Law(
        "Twice the numbers have twice the spread.",
        lambda made, values: max(
            abs(np.ptp(v) - 2 * np.ptp(c.arguments[0]))
            for c, (v,) in zip(made, values, strict=True)
        ),
        1e-8,
    )
    stored = tuple((np.round(2 * call.arguments[0], 5),) for call in made)
    outcomes = [
        Outcome("returned", values=(first(made[0].arguments[0]),)),
        Outcome("returned", values=(2 * made[1].arguments[0],)),
        last,
    ]
    question = replace(TWICE, laws=(spread,), tolerance=lambda _: 1e-4)
    return judge(question, made, outcomes, Answers(stored, ()))


@pytest.mark.parametrize(
    ("last", "finding"),
    [
        (Outcome("raised", error="ValueError: own error"), "exception"),
        (Outcome("returned", values=(np.full(3, np.nan),)), "not finite"),
        (Outcome("returned", values=(np.zeros(2),)), "shape"),
    ],
)
def test_missing_digits_of_stored_values_violate_no_law(last, finding):
    """They stand for values that are missing: right values before these satisfy all laws."""
    assert near_and_far(lambda x: 2 * x, last).finding == finding
    wrong = near_and_far(lambda x: 2 * x + 1, last)
    assert wrong.sentence.startswith("For case 0, entry [0] is off by 1."), "the law holds"
    assert near_and_far(lambda x: 3 * x, last).sentence.startswith("Twice the numbers have twice")


def test_a_law_is_judged_on_the_values_of_all_cases_before_an_error():
    """Equal wrong values satisfy a law that they violate beside right ones."""
    equal = Law(
        "The numbers must be equal.", lambda _, values: float(np.ptp([v[0] for (v,) in values[:2]]))
    )
    made = tuple(Call("twice", (np.ones(3),), f"case {k}") for k in range(3))
    outcomes = [
        *2 * [Outcome("returned", values=(np.array([5.0, 6, 7]),))],
        Outcome("raised", error="ValueError: own error"),
    ]
    right = Answers(3 * ((2 * np.ones(3),),), ())
    verdict = judge(replace(TWICE, laws=(equal,)), made, outcomes, right)
    assert verdict.sentence.startswith("For case 0, entry [2] is off by 5.")


def test_a_case_at_the_limit_of_the_tolerance_is_shown_last():
    """It reads like a rounding error; other cases show the mistake."""

    def added(large):
        def function(x):
            return 2 * x + (3e-9 if len(x) == 5 else large)

        return verdict_of(function, known())

    assert added(1.0).call == 1
    assert added(3e-9).call == 0


@pytest.mark.parametrize("number", sorted({name[:2] for name in questions()}))
def test_the_solution_with_an_error_in_its_last_case_is_told_the_error(number):
    """No law is quoted: stored right values, which stand for missing ones, have twelve digits."""
    functions = next(s.functions() for s in all_sources(ROOT) if s.number == number)
    for question in (q for q in questions().values() if q.notebook == number):
        made = question.inputs(seed("", question.name))
        outcomes = [
            *perform(functions, made[:-1], 600.0),
            Outcome("raised", error="ValueError: own error"),
        ]
        known = public_answers(number)[question.name]
        verdict = judge(question, made, outcomes, known)
        assert verdict.finding == "exception", (question.name, verdict.sentence)
        assert "own error" in verdict.sentence


@pytest.mark.parametrize(
    "function", [np.linalg.svd, lambda a: np.linalg.lstsq(a, a), np.linalg.eigvalsh, np.linalg.eig]
)
def test_an_error_of_numpy_for_nan_is_explained(function):
    """The named line need not be wrong; the division by zero is in it or before it."""
    verdict = verdict_of(lambda _: function(np.full((3, 3), np.nan)), known())
    assert verdict.finding == "exception"
    assert verdict.sentence.endswith("look for a division by zero in or before this line.")


def test_slow_and_endless_answers_lose_points():
    """The time spent on an endless answer is limited."""

    def slow(x):
        end = time.process_time() + 0.02
        while time.process_time() < end:
            pass
        return 2 * x

    def waiting(x):
        time.sleep(0.02)
        return 2 * x

    def within(seconds, function):
        hasty = replace(TWICE, limit=0.01)
        return judge(hasty, CALLS, perform({"twice": function}, CALLS, seconds), known())

    assert within(600, slow).finding == "slow"
    assert within(600, slow).credit == 0.5
    assert within(600, waiting).right, "a busy machine lets an answer wait"

    def endless(_):
        while True:
            try:
                time.sleep(1)
            except Exception:
                continue

    assert within(0.1, endless).finding == "endless"


def test_without_known_answers_the_laws_decide():
    assert verdict_of(lambda x: 2 * x).right
    verdict = verdict_of(lambda x: 2.001 * x)
    assert verdict.finding == "wrong"
    assert verdict.sentence.startswith("Twice the numbers have twice the sum. This is off by")
    assert verdict_of(lambda x: x**2).finding == "wrong"


def test_only_the_numbers_of_a_misconception_are_recognized():
    """Numbers that are merely near those of a misconception are wrong."""
    assert verdict_of(lambda x: x**2 * (1 + 1e-6), known()).finding == "wrong"
    assert verdict_of(lambda x: x**2 * (1 + 1e-12), known()).mistake == "squared"


def test_a_misconception_that_gives_zero_matches_rounding_errors_of_zero():
    """The unit of differences is the size of the right numbers."""
    nothing = Mistake("nothing", "It is zero.", perform({"twice": lambda x: 1e-16 * x}, CALLS, 1))
    zero = replace(known(), mistakes=(nothing,))
    assert verdict_of(lambda x: -3e-13 * x, zero).mistake == "nothing"
    assert verdict_of(lambda x: 1e-7 * x, zero).finding == "wrong"


def test_a_fingerprint_identifies_a_misconception():
    """Here the fingerprint is the absolute values; a right answer must have the right signs too."""
    sizes = replace(TWICE, fingerprint=lambda _, values: tuple(np.abs(v) for v in values))

    def judged(function):
        return judge(sizes, CALLS, perform({"twice": function}, CALLS, 1), known())

    assert judged(lambda x: -(x**2)).mistake == "squared"
    assert judged(lambda x: -2 * x).finding == "wrong"


def test_a_fingerprint_may_leave_out_values_that_are_not_finite():
    """Here it leaves out the first number, a quotient of rounding errors in a mistake."""
    others = replace(TWICE, fingerprint=lambda _, values: tuple(v[1:] for v in values))

    def first_divided_by_zero(x):
        return np.append(np.inf, x[1:] ** 2)

    def judged(question):
        outcomes = perform({"twice": first_divided_by_zero}, CALLS, 1)
        return judge(question, CALLS, outcomes, known())

    assert judged(others).mistake == "squared"
    assert judged(TWICE).finding == "not finite"


@pytest.mark.parametrize(("open_order", "mistake"), [(True, "too few"), (False, "")])
def test_columns_in_another_order_are_recognized_if_their_order_is_open(open_order, mistake):
    """The mistake has too few columns, so that no normal form applies."""

    def columns(*powers):
        return lambda x: np.stack([x**k for k in powers], axis=1)

    def by_first_row(_, values):
        return tuple(v[:, np.argsort(v[0])] for v in values)

    table = replace(
        TWICE,
        shapes=lambda call: ((call.arguments[0].size, 3),),
        laws=(),
        normal_form=by_first_row if open_order else unchanged,
    )
    right = tuple((columns(1, 2, 3)(call.arguments[0]),) for call in CALLS)
    few = Mistake("too few", "One is missing.", perform({"twice": columns(1, 3)}, CALLS, 1))
    outcomes = perform({"twice": columns(3, 1)}, CALLS, 1)
    assert judge(table, CALLS, outcomes, Answers(right, (few,))).mistake == mistake


def test_a_misconception_with_another_shape_is_recognized():
    """The student reads the sentence of the misconception instead of the shapes."""
    columns = perform({"twice": lambda x: 3 * x[:, None]}, CALLS, 1)
    transposed = Mistake("columns", "These are columns.", columns)
    both = replace(known(), mistakes=(*known().mistakes, transposed))
    assert verdict_of(lambda x: 3 * x[:, None], both).mistake == "columns"
    assert verdict_of(lambda x: 4 * x[:, None], both).finding == "shape"


def test_an_exception_alone_does_not_identify_a_misconception():
    """Two functions that raise the same error need not have the same misconception."""
    stops = Mistake("stops", "It stops.", perform({"twice": raises}, CALLS, 1))
    assert verdict_of(raises, replace(known(), mistakes=(stops,))).finding == "exception"


def test_the_arguments_are_copies():
    """Changes made by one call reach neither the next call nor the inputs."""
    before = [call.arguments[0].copy() for call in CALLS]
    verdict_of(in_place)
    for call, was in zip(CALLS, before, strict=True):
        assert np.array_equal(call.arguments[0], was)


def test_an_error_is_reported_with_the_students_own_line():
    """The error arises inside NumPy."""

    def solve(x):
        return np.linalg.solve(np.zeros((2, 2)), np.ones(2)) + x

    (outcome, _) = perform({"twice": solve}, CALLS, 1)
    assert outcome.error == "LinAlgError: Singular matrix"
    assert "of solve" in outcome.line
    assert "np.linalg.solve(np.zeros" in outcome.line


def test_system_exit_is_reported_as_an_exception():
    """The program continues."""
    verdict = verdict_of(lambda _: sys.exit(3))
    assert verdict.finding == "exception"
    assert "SystemExit" in verdict.sentence


@pytest.mark.filterwarnings("error")
def test_warnings_do_not_affect_the_verdict():
    """A division by zero whose result is replaced is not an error."""
    verdict = verdict_of(lambda x: np.where(x == x, 2 * x, x / 0), known())
    assert verdict.right


ROWS = replace(
    TWICE,
    inputs=lambda seed: tuple(replace(c, arguments=(c.arguments[0][None],)) for c in inputs(seed)),
)


@pytest.mark.parametrize(
    ("pack", "finding"),
    [(tuple, "right"), (np.matrix, "right"), (list, "right"), (np.sum, "shape")],
)
def test_one_row_has_two_axes_in_every_container(pack, finding):
    """An array without its first axis is refused, but a tuple or a list of its only row is not."""
    made = ROWS.inputs(0)
    outcomes = perform({"twice": lambda x: pack(2 * x)}, made, 600)
    assert judge(ROWS, made, outcomes).finding == finding
    squeezed = perform({"twice": lambda x: 2 * x[0]}, made, 600)
    assert judge(ROWS, made, squeezed).finding == "shape"


def test_equivalent_containers_are_accepted():
    """Examples are rows as a tuple, several arrays as one, and a number in an array."""
    assert fitted((np.array([[1, 2], [3, 4]]),), [(2,), (2,)])[1].tolist() == [3, 4]
    assert fitted((np.array([7]),), [()])[0] == 7
    assert [v.shape for v in fitted((np.ones((3, 1)),), [(3,)])] == [(3, 1)]


def test_known_answers_are_reproduced_from_json():
    """This includes shapes, errors, and values that are not finite."""
    strange = (
        Outcome("returned", values=(np.array([[1 / 3, np.nan]]), np.array(np.inf))),
        Outcome("raised", error="ValueError: long story"),
    )
    there = Answers(known().right, (Mistake("a", "b", strange),))
    back = answers.from_json(json.loads(json.dumps(answers.to_json(there))))
    for one, other in zip(there.right, back.right, strict=True):
        np.testing.assert_allclose(one[0], other[0], rtol=1e-11)
    outcome, error = back.mistakes[0].outcomes
    np.testing.assert_allclose(outcome.values[0], strange[0].values[0], rtol=1e-11)
    assert outcome.values[1] == np.inf
    assert error.error == "ValueError"


def test_every_finding_has_a_title():
    """No finding occurs twice."""
    assert set(TITLES) == set(FINDINGS)
    assert len(set(FINDINGS)) == len(FINDINGS)


@pytest.mark.parametrize("name", questions())
def test_inputs_depend_on_the_seed_alone(name):
    """Another seed gives other numbers in the same cases."""
    question = get(name)
    one, again, other = question.inputs(5), question.inputs(5), question.inputs(6)
    assert [c.case for c in one] == [c.case for c in other]
    assert [question.shapes(c) for c in one] == [question.shapes(c) for c in other]
    changed = False
    for a, b, c in zip(one, again, other, strict=True):
        for x, y, z in zip(a.arguments, b.arguments, c.arguments, strict=True):
            assert np.array_equal(x, y)
            changed = changed or not np.array_equal(x, z)
    assert changed, "nobody has inputs of their own"


POSITIVE = {
    **{name: {2} for name in ("02.1", "02.2", "02.9", "11.4", "12.6", "14.7")},
    **{name: {3} for name in ("02.4", "02.5", "02.7", "02.8", "13.9")},
    **{name: {2} for name in ("11.3", "13.1", "13.2", "13.3", "13.6", "13.11")},
    **{name: {1} for name in ("07.1", "14.1")},
    "09.5": {0},
    "05.8": {4},
    "12.10": {4},
}
"""Positions of lengths, weights, areas, times, stiffnesses and links, which have one sign."""


def test_inputs_have_both_signs_so_that_a_lost_sign_is_seen():
    for question in questions().values():
        calls = question.inputs(seed("", question.name))
        rows = zip_longest(*(call.arguments for call in calls))
        arrays = {i: [np.asarray(a) for a in row if a is not None] for i, row in enumerate(rows)}
        numbers = {i: row for i, row in arrays.items() if row[0].dtype.kind == "f"}
        positive = {i for i, row in numbers.items() if all((a >= 0).all() for a in row)}
        assert positive == POSITIVE.get(question.name, set()), question.name


def test_an_unknown_question_is_refused():
    """The message lists the existing questions."""
    with pytest.raises(ValueError, match=r"in question '77.1'; there are 01.1, 01.2"):
        get("77.1")


def test_seeds_depend_on_student_question_and_salt():
    """Case and surrounding spaces of the name do not matter."""
    numbers = {
        seeds.seed(student, question, salt)
        for student in ("ada", "bob")
        for question in ("01.1", "01.2")
        for salt in ("a", "b")
    }
    assert len(numbers) == 8
    assert seeds.seed(" Ada ", "01.1") == seeds.seed("ada", "01.1")


def test_the_student_is_read_from_student_txt(tmp_path, monkeypatch):
    """Comments and empty lines in the file are skipped."""
    monkeypatch.chdir(tmp_path)
    assert seeds.student() == seeds.EVERYBODY
    (tmp_path / "student.txt").write_text("# your number\n\n  s1234 \n")
    assert seeds.student() == "s1234"
    mine = fieldcheck.data("01.1")[0]
    (tmp_path / "student.txt").write_text("s1235\n")
    assert not np.array_equal(mine, fieldcheck.data("01.1")[0])


@pytest.fixture
def first_notebook(tmp_path, monkeypatch):
    """A right answer to one question, in a new working folder."""
    monkeypatch.chdir(tmp_path)
    return {"basis_matrix": lambda points: np.insert(points, 0, 1.0, axis=1)}


def test_progress_is_kept_after_a_restart(first_notebook):
    """The points of checked questions add up."""
    assert fieldcheck.check("01.1", first_notebook).right
    assert fieldcheck.check("01.2", first_notebook).finding == "missing"
    shown = fieldcheck.progress()
    assert shown.earned == get("01.1").points
    assert "✓ right" in repr(shown)
    assert "basis_matrix" in shown._repr_html_()
    begun = [question for question in questions().values() if question.notebook == "01"]
    assert shown.possible == sum(question.points for question in begun)


def test_progress_has_a_sum_for_each_notebook():
    """It names the points of answers in words, which no check can give."""
    lines = repr(notebook.Progress({"04.1": "right", "13.5": "exception"})).splitlines()
    headings = [line for line in lines if line.startswith("Notebook")]
    assert headings == ["Notebook 04", "Notebook 13", "Notebook 13, optional"]
    sums = [line for line in lines if " points" in line]
    points = {
        number: sum(q.points for q in questions().values() if q.notebook == number)
        for number in ("04", "13")
    }
    assert sums[0].startswith(f"2 of {points['04']} points for functions; 7 more for answers in")
    assert sums[1].startswith(f"0 of {points['13'] - 2} points for functions; 9 more")
    assert sums[2] == "0 of 2 points"
    assert any(line.endswith("✗ stops with an error") for line in lines)


@pytest.mark.slow
def test_a_wrong_answer_is_drawn_beside_the_right_one(first_notebook):
    """A right answer gets no picture."""
    wrong = {"basis_matrix": lambda points: np.insert(points, 0, 1.5, axis=1)}
    verdict = fieldcheck.check("01.1", wrong)
    assert verdict.picture.startswith("<svg")
    assert verdict.picture in verdict._repr_html_()
    assert not fieldcheck.check("01.1", first_notebook).picture


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "wrong", "parts"),
    [
        ("01.5", lambda v: 2 * v, {"plot": 1, "quiver": 2}),
        ("06.1", lambda v: np.roll(v, 1, axis=0), {"plot": 1, "fill": 1, "quiver": 2}),
        ("07.1", lambda v: v[::-1], {"plot": 2, "annotate": 12}),
        ("07.1", np.zeros_like, {"plot": 2, "annotate": 12}),
        ("07.6", lambda v: 2 * v, {"imshow": 3}),
    ],
)
def test_the_picture_suits_the_question(name, wrong, parts, monkeypatch):
    """Arrows at the points, or at the middles of the sides; polygons; or else a table."""
    drawn = Counter()
    for part in ("quiver", "fill", "plot", "annotate", "imshow"):
        count(monkeypatch, drawn, part)
    question = get(name)
    inputs = question.inputs(seed("", name))
    right = answers.public_answers(question.notebook)[name].right
    outcomes = [Outcome("returned", values=tuple(map(wrong, values))) for values in right]
    known = Answers(right, ())
    verdict = judge(question, inputs, outcomes, known)
    picture = picture_of_difference(verdict, question, inputs, outcomes, known).picture
    assert picture.startswith("<svg")
    assert drawn == parts


def count(monkeypatch, drawn, part):
    """Count how often axes draw this part."""
    draw = getattr(Axes, part)

    def counted(axes, *args, **kwargs):
        drawn[part] += 1
        return draw(axes, *args, **kwargs)

    monkeypatch.setattr(Axes, part, counted)


def test_a_damaged_progress_file_is_ignored(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / notebook.RECORD).write_text("{")
    assert fieldcheck.progress().earned == 0


@pytest.mark.parametrize("name", ["02.3", "2.5", 2.5])
def test_an_unknown_question_is_refused_with_those_of_its_notebook(name):
    """Written questions have no check, and a trailing zero is easily forgotten."""
    with pytest.raises(ValueError, match=rf"in question {name!r}; there are 02.1, .*02.9$"):
        fieldcheck.check(name)


def test_whole_numbers_are_compared_without_rounding():
    """A wrong rank is not reported as "off by 1; 1e-09 is allowed for rounding"."""
    question = questions()["01.4"]
    calls = question.inputs(seed("", "01.4"))
    right = answers.public_answers("01")["01.4"].right
    known = Answers(right, ())
    outcomes = [Outcome("returned", values=(np.array(float(v[0]) + 7),)) for v in right]
    verdict = judge(question, calls, outcomes, known)
    assert verdict.finding == "wrong"
    assert "rounding" not in verdict.sentence
    assert "off by 7. All right values here are whole numbers." in verdict.sentence


def test_large_values_are_not_called_whole_numbers():
    """Above 2⁵³ all floating-point numbers are whole."""
    question = Question("99.1", "weights", 1, lambda _: (), lambda _: ((2,),))
    asked = (Call("weights", (), "a tiny cell"),)
    right = np.array([3e24, 7e24])
    outcomes = [Outcome("returned", values=(2 * right,))]
    assert "whole" not in judge(question, asked, outcomes, Answers([(right,)], ())).sentence


def not_to_be_compared(_, values):
    """Rows may come in any order."""
    return tuple(map(answers.rows_sorted, values))


def first_positive(_, values):
    """Each row may have the other sign."""
    return tuple(v * np.where(v[:, :1] < 0, -1, 1) for v in values)


@pytest.mark.parametrize(
    ("form", "amount", "words"),
    [
        (unchanged, 0.3, "a mesh, entry [2, 1] is off by 0.3."),
        (
            not_to_be_compared,
            0.3,
            "a mesh, the entries are not the right ones in any order that the question allows.",
        ),
        (not_to_be_compared, 0.001, "a mesh, an entry is off by 0.001."),
        (first_positive, 0.3, "a mesh, the entries are not the right ones with either sign."),
        (first_positive, 0.001, "a mesh, entry [2, 1] is off by 0.001."),
    ],
)
def test_an_amount_is_told_only_where_the_right_entry_is_known(form, amount, words):
    """Rows that may come in any order, or with any sign, are compared as they match."""
    right = np.array([[1.5, 2.0], [0.5, 7.0], [3.5, 1.0]])
    asked, known = (Call("edges", (), "a mesh"),), Answers([(right,)], ())
    outcomes = [Outcome("returned", values=(right + np.diag([0, 0, amount])[:, 1:],))]
    question = Question("99.1", "edges", 1, lambda _: asked, lambda _: ((3, 2),), normal_form=form)
    assert words in judge(question, asked, outcomes, known).sentence


def test_exchanged_arrays_are_recognized_where_the_sign_of_one_is_open():
    ends, normals = np.array([[1.0, 2.0], [4.0, 3.0]]), np.array([[-0.6, 0.8], [1.0, 0.0]])

    def form(_, values):
        return values[0], *first_positive(_, values[1:])

    asked, known = (Call("edges", (), "a mesh"),), Answers([(ends, normals)], ())
    outcomes = [Outcome("returned", values=(-normals, ends))]
    question = Question(
        "99.1", "edges", 1, lambda _: asked, lambda _: ((2, 2), (2, 2)), normal_form=form
    )
    assert "not the right ones" in judge(question, asked, outcomes, known).sentence
    outcomes = [Outcome("returned", values=(normals, ends))]
    found = judge(question, asked, outcomes, known).sentence
    assert "The returned arrays are the right ones in another order." in found


def test_the_line_of_an_error_is_counted_from_the_def():
    """Above it the cell may have other lines; a comprehension is part of its function."""
    code = "# a comment\nimport math\n\n\ndef f(x):\n    y = [1 / k for k in x]\n    return y\n"
    namespace: dict = {}
    exec(compile(code, "cell", "exec"), namespace)
    with pytest.raises(ZeroDivisionError) as raised:
        namespace["f"]([1, 0])
    assert calls.own_line(raised.value, namespace["f"]) == "line 2 of f"


@pytest.mark.parametrize("open_order", [False, True])
def test_the_only_wrong_row_is_named_only_where_the_order_is_given(open_order):
    right = np.array([[1.5, 2.0], [0.5, 7.0], [3.5, 1.0]])
    asked, known = (Call("edges", (), "a mesh"),), Answers([(right,)], ())
    outcomes = [Outcome("returned", values=(right + np.outer([0, 0, 1], [0.3, 0.7]),))]
    form = (lambda _, v: tuple(map(answers.rows_sorted, v))) if open_order else unchanged
    question = Question("99.1", "edges", 1, lambda _: asked, lambda _: ((3, 2),), normal_form=form)
    assert ("Only row" in judge(question, asked, outcomes, known).sentence) != open_order


@pytest.mark.parametrize(("name", "says"), [("14.7", True), ("01.4", False)])
def test_only_answers_that_are_all_true_or_false_are_told_as_such(name, says):
    """A wrong rank is off by one; a wrong truth value must be the other one."""
    question = questions()[name]
    calls = question.inputs(seed("", name))
    right = answers.public_answers(name[:2])[name].right
    changed = [tuple(np.where(v == 0, 1.0, v - 1) for v in values) for values in right]
    outcomes = [Outcome("returned", values=values) for values in changed]
    verdict = judge(question, calls, outcomes, Answers(right, ()))
    assert verdict.finding == "wrong"
    assert bool(re.search(r"must be (0, or False|1, or True)\.", verdict.sentence)) == says
    assert ("off by 1" in verdict.sentence) != says


def constant(points, _):
    return np.ones(points.shape[1] + 1)


@pytest.mark.usefixtures("first_notebook")
def test_the_failed_case_has_inputs_returned_and_right_values():
    """They repeat the call; the right values are those of the public cases."""
    verdict = fieldcheck.check("01.2", {"fit": constant})
    failed = fieldcheck.case()
    np.testing.assert_array_equal(constant(*failed.arguments), failed.returned)
    points, values = failed.arguments
    least_squares = np.linalg.lstsq(np.insert(points, 0, 1, axis=1), values, rcond=None)[0]
    np.testing.assert_allclose(failed.right, least_squares, rtol=1e-9)
    assert f"01.2: fit for {failed.call.case}\n" in repr(failed)
    assert failed.call.case in verdict.sentence
    assert "case()" in verdict._repr_html_()


@pytest.mark.usefixtures("first_notebook")
def test_a_failed_case_of_own_inputs_has_no_right_values():
    question = get("01.2")
    verdict = notebook.try_seed(question, {"fit": constant}, 5)
    assert not verdict.right
    assert fieldcheck.case("01.2").right is None
    assert "not stored, since these inputs are your own" in repr(fieldcheck.case())


@pytest.mark.usefixtures("first_notebook")
def test_a_failed_case_is_forgotten_when_the_answer_is_right(monkeypatch):
    monkeypatch.setattr(notebook, "_failed", {})
    with pytest.raises(ValueError, match="the last check has not failed"):
        fieldcheck.case()
    fieldcheck.check("01.2", {"fit": lambda *_: 1 / 0})
    assert "ZeroDivisionError" in repr(fieldcheck.case("01.2"))
    right = {"fit": lambda p, v: np.linalg.lstsq(np.insert(p, 0, 1, axis=1), v, rcond=None)[0]}
    assert fieldcheck.check("01.2", right).right
    with pytest.raises(ValueError, match=r"the last check of 01\.2 has not failed"):
        fieldcheck.case("01.2")
    fieldcheck.check("01.3", {"evaluate": lambda *_: 1 / 0})
    assert fieldcheck.check("01.2", right).right
    with pytest.raises(ValueError, match="the last check has not failed"):
        fieldcheck.case()
    assert "01.3" in repr(fieldcheck.case("01.3"))


def test_a_whole_number_is_shown_as_one():
    """A rank is 4, not ``4.``."""
    answer = Outcome("returned", values=(np.array(3.0),))
    shown = repr(FailedCase(get("01.4"), CALLS[0], answer, (np.array(4.0),)))
    assert "a number: 3\n" in shown
    assert shown.endswith("a number: 4")


def test_start_over_prints_the_stub_outside_a_notebook(capsys):
    fieldcheck.start_over("01.1")
    printed = capsys.readouterr().out
    assert "def basis_matrix(points):" in printed
    assert "NotImplementedError" in printed


def test_html_in_an_exception_is_escaped():
    shown = Verdict("01.1", "exception", "<script>alert(1)</script>")._repr_html_()
    assert "<script>" not in shown


@pytest.mark.slow
@pytest.mark.parametrize("count", [90, 9000])
def test_artists_with_many_points_are_images_and_the_rest_are_paths(count):
    """A picture of ten thousand points takes up as little space as one of a thousand."""
    x, y = np.random.default_rng(0).random((2, count))
    with figures.figure(3, 2) as page:
        axes = page.subplots()
        axes.scatter(x, y, c=y, s=4)
        axes.plot(x[:50], y[:50])
    text = figures.svg(page)
    assert ("<image" in text) == (count > 1000)
    assert 'id="line2d_1"' in text
    assert len(text) < 150_000


def test_paths_are_one_line_with_three_decimals():
    """The numbers are those of Matplotlib to a thousandth of a point."""
    with figures.figure(3, 2) as page:
        page.subplots().plot(np.linspace(0, 1, 40), np.sin(np.linspace(0, 9, 40)))
    file = io.StringIO()
    with mpl.rc_context(figures.STYLE):
        page.savefig(file, format="svg")
    paths = [re.findall(r' d="([^"]*)"', text) for text in (figures.svg(page), file.getvalue())]
    assert paths[0]
    for short, long in zip(*paths, strict=True):
        assert "\n" not in short
        assert not re.search(r"\.\d{4}", short)
        numbers = [np.array(re.findall(r"-?\d+\.?\d*", path), float) for path in (short, long)]
        np.testing.assert_allclose(*numbers, atol=1e-3)


@pytest.mark.slow
def test_pictures_are_reproducible():

    def drawn():
        with figures.figure(3, 2) as page:
            page.subplots().plot([0, 1], [1, 0])
        return figures.svg(page)

    assert drawn() == drawn()


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (lambda: unwritten(1), "The picture waits for unwritten, not written yet."),
        (lambda: raises(1), "The picture cannot be drawn: ValueError: no such thing."),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_replaced_by_the_reason(picture, words):
    assert repr(figures._drawn(picture, {})) == words


@pytest.mark.slow
def test_a_moved_slider_redraws_the_picture(monkeypatch):
    """The picture function receives the value of the slider."""
    shown, seen = [], []
    monkeypatch.setattr("IPython.display.display", shown.append)

    def picture(epsilon, n):
        seen.append((epsilon, n))
        return unwritten(1)

    sliders = {
        "epsilon": figures.Slider(0.01, 1, 0.1, "ε", logarithmic=True),
        "n": figures.Slider(1, 9, 3, "n", whole=True),
    }
    figures._show_moving(picture, sliders)
    controls = shown[0].children
    controls[1].value = 5
    assert seen == [(pytest.approx(0.1), 3), (pytest.approx(0.1), 5)]
    assert "waits for unwritten" in controls[2].value


def test_drawing_outside_a_notebook_shows_nothing():

    @figures.draw()
    def nothing():
        with figures.figure(2, 2) as page:
            page.subplots()
        return page

    assert callable(nothing)


def test_a_missing_function_is_reported_for_every_call():
    made = perform({}, CALLS, 1)
    assert [outcome.status for outcome in made] == ["missing", "missing"]
    assert calls.as_arrays(()) is None
