"""Patterns of wrong values are reported, and only if they hold."""

import numpy as np
import pytest

from fieldcheck.calls import Call
from fieldcheck.inputs.simplices import relative_to_a_corner
from fieldcheck.question import Question
from fieldcheck.wrong_values.patterns import pattern
from fieldcheck.wrong_values.which_cases import HERE, OTHERS_RIGHT


def inputs(seed):
    random = np.random.default_rng(seed)
    return tuple(
        Call("table", (random.normal(size=(n, n)),), case)
        for n, case in ((3, "a small table"), (5, "a large table"))
    )


CALLS = inputs(0)
TABLE = Question("99.2", "table", 1, inputs, lambda call: (call.arguments[0].shape,))
TWO = Question("99.3", "table", 1, inputs, lambda call: (call.arguments[0].shape,) * 2)


def of_table(change):
    """The pattern if `change` of the right table is returned."""
    right = [call.arguments for call in CALLS]
    return pattern(TABLE, CALLS, [(change(r),) for (r,) in right], right)


def one(a, index, by=1.0):
    changed = a.copy()
    changed[index] += by
    return changed


def scaled(a, where, factor=2.0):
    return np.where(where, factor * a, a)


def square(a):
    return np.indices(a.shape)


def where_right(shapes, is_right, change=lambda a: a + np.cos(a), right=lambda a: a):
    """The pattern if the values are right for clouds of some shapes, up to small errors."""
    random = np.random.default_rng(0)
    calls = [Call("table", (random.normal(size=s),), f"a cloud of {s}") for s in shapes]
    told = [call.arguments for call in calls]
    values = [(right(a) if is_right(*a.shape) else change(a),) for (a,) in told]
    return pattern(TABLE, calls, values, told)


@pytest.mark.parametrize(
    ("dimensions", "right", "sentence"),
    [
        (
            (1, 2, 2, 3, 3),
            (1, 2),
            f"{HERE} right on a line and in the plane, and wrong in space.",
        ),
        (
            (1, 1, 2, 3),
            (1,),
            f"{HERE} right on a line, and wrong in the plane and in space.",
        ),
        ((1, 2, 2, 3, 3), (1,), f"{HERE} right only for a cloud of (7, 1)."),
        ((1, 1, 2, 2, 3, 3), (1, 3), ""),
        ((2, 2, 5, 5), (2,), ""),
        ((3, 3, 2, 2), (3,), ""),
    ],
)
def test_values_that_are_right_up_to_a_dimension_are_told(dimensions, right, sentence):
    """The columns of the first table are coordinates if there are one to three of them."""
    found = where_right([(7, d) for d in dimensions], lambda _, d: d in right)
    assert found.startswith(sentence)
    assert (f"{HERE} right" in found) == bool(sentence)


@pytest.mark.parametrize(
    ("rows", "right", "is_told"),
    [
        ((1, 7, 9), 1, False),
        ((3, 7, 9), 3, False),
        ((4, 7, 9), 4, False),
        ((3, 2, 9), 3, True),
        ((7, 5, 9), 7, True),
    ],
)
def test_a_single_right_case_is_told_unless_it_has_few_rows(rows, right, is_told):
    """It would say that the number of rows matters, and two points are always neighbours."""
    found = where_right([(n, 2) for n in rows], lambda n, _: n == right)
    assert (f"{HERE} right only for a cloud of ({right}, 2)." in found) == is_told


@pytest.mark.parametrize(
    ("shapes", "is_right"),
    [
        ([(5, 2), (7, 2), (9, 2)], lambda n, _: n == 7),
        ([(7, 1), (8, 1), (7, 2), (7, 3)], lambda _, d: d == 1),
        ([(5, 2), (6, 2), (9, 2), (12, 2)], lambda n, _: n < 9),
    ],
    ids=["a single case", "dimensions", "sizes"],
)
def test_a_case_whose_error_is_just_below_the_tolerance_is_not_called_right(shapes, is_right):
    """Large coordinates may hide it, and the case has nothing to do with the mistake."""
    assert f"{HERE} right" in where_right(shapes, is_right)
    found = where_right(shapes, is_right, right=lambda a: a + 3e-10 * np.abs(a).max())
    assert f"{HERE} right" not in found


def test_a_right_number_among_wrong_ones_tells_nothing():
    """A count is right by chance: one missing number may make up for another."""
    count = Question("99.5", "count", 1, inputs, lambda _: ((),))
    calls = [Call("count", (np.zeros((n, 2)),), f"a cloud of {n}") for n in (7, 5, 9)]
    right = [(np.array(x),) for x in (3.0, 7.0, 4.0)]
    wrong = [(np.array(x),) for x in (3.0, 5.0, 1.0)]
    assert "right only" not in pattern(count, calls, wrong, right)
    told = f"{HERE} right only for a cloud of 7."
    halved = [[(r / 2,) for (r,) in values] for values in (wrong, right)]
    assert pattern(count, calls, *halved) == told


def test_a_case_that_looks_alike_in_both_orders_is_not_called_the_only_right_one():
    """Its columns are equal, so that it is right by chance: the order says it all."""
    tables = [(np.random.default_rng(n).normal(size=(n, n)),) for n in (5, 6, 7)]
    tables[0] = (np.tile(tables[0][0][:, :1], 5),)
    calls = [Call("table", table, f"a table of {len(table[0])} rows") for table in tables]
    values = [(table[:, ::-1],) for (table,) in tables]
    found = pattern(TABLE, calls, values, tables)
    assert found == "The wrong arrays are right with their columns in the reverse order."


def test_nothing_is_said_on_which_cases_are_right_if_some_are_missing():
    """The other cases returned nothing that can be compared."""
    right = [call.arguments for call in CALLS]
    values = [(r if k else -r,) for k, (r,) in enumerate(right)]
    opposite = "The wrong values are the right ones with the opposite sign."
    told = f"{OTHERS_RIGHT} {opposite}"
    assert pattern(TABLE, CALLS, values, right) == told
    assert pattern(TABLE, CALLS, values, right, are_all=False) == opposite


@pytest.mark.parametrize(
    ("rows", "right", "sentence"),
    [
        (
            (4, 5, 5, 9, 12),
            {9, 12},
            f"{HERE} right where the first table has 9 or more rows, and wrong where it has 5 or",
        ),
        (
            (12, 4, 9, 5, 5),
            {4, 5},
            f"{HERE} right where the first table has 5 or fewer rows, and wrong where it has 9 or",
        ),
        ((1, 1, 9, 12), {1}, ""),
        ((3, 4, 9, 12), {3, 4}, ""),
        ((4, 5, 6, 9, 12), {5, 12}, ""),
        ((5, 5, 9, 9), {}, ""),
        ((3, 3, 9, 12), {3}, ""),
        ((2, 6, 9, 12), {2, 6}, ""),
    ],
)
def test_values_that_are_right_up_to_a_size_are_told(rows, right, sentence):
    """The largest sizes with wrong values are below all with right ones, or the other way round."""
    found = where_right([(n, 2) for n in rows], lambda n, _: n in right)
    assert found.startswith(sentence)
    assert (f"{HERE} right" in found) == bool(sentence)


@pytest.mark.parametrize(
    ("change", "beginning"),
    [
        (lambda a: a + np.cos(a), f"{HERE} right where the first table has 6 or fewer rows"),
        (lambda a: -a, "The wrong values are the right ones with the opposite sign."),
        (lambda a: a + 1e-8 * np.cos(a), ""),
    ],
    ids=["large errors", "another pattern", "small errors"],
)
def test_a_size_is_told_only_for_want_of_a_better_pattern(change, beginning):
    """Errors near the tolerance are above it by chance."""
    found = where_right([(n, 2) for n in (5, 6, 9, 12)], lambda n, _: n < 9, change)
    assert found.startswith(beginning)
    assert bool(found) == bool(beginning)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda a: a, ""),
        (lambda a: a * (1 + 1e-13), ""),
        (
            lambda a: a.astype(np.float32),
            "The wrong values have the seven digits of float32: compute with float64.",
        ),
        (lambda a: a + 1e-7 * np.cos(a), ""),
        (np.zeros_like, "The wrong values are all zero."),
        (lambda a: -a, "The wrong values are the right ones with the opposite sign."),
        (lambda a: a / 2, "The wrong values are the right ones times 1/2."),
        (lambda a: -8 * np.pi * a, "The wrong values are the right ones times −8π."),
        (lambda a: 1.25 * a, "The wrong values are the right ones times 1.25."),
        (lambda a: (1 - 2e-7) * a, "The wrong values are the right ones times (1 -2.0e-07)."),
        (
            lambda a: len(a) * a,
            "For a small table, the wrong values are the right ones times 3. For a large table, "
            "they are the right ones times 5.",
        ),
        (np.abs, "The wrong numbers differ from the right ones only in sign."),
        (lambda a: a - 0.5, "The wrong values are all too small by 0.5."),
        (np.transpose, "The wrong arrays are the transposes of the right ones."),
        (np.flipud, "The wrong arrays are right in the reverse order."),
        (
            np.fliplr,
            "The wrong arrays are right with their columns in the reverse order.",
        ),
        (
            lambda a: np.roll(a, 1, 0),
            "The wrong arrays have the right rows in another order.",
        ),
        (
            lambda a: np.roll(a, 1, 1),
            "The wrong arrays have the right columns in another order.",
        ),
        (np.rot90, "The wrong values are the right ones at other positions."),
        (lambda a: one(a, (0, slice(None))), "Only row [0] is wrong."),
        (lambda a: one(a, (slice(None), -1)), "Only the last column is wrong."),
        (lambda a: scaled(a, square(a)[1] != 1), "Only column [1] is right."),
        (lambda a: a + np.eye(len(a)), "Only values on the diagonal are wrong."),
        (np.triu, "Only values below the diagonal are wrong."),
        (lambda a: np.diag(np.diag(a)), "Only the values on the diagonal are right."),
        (
            lambda a: 2 * a if len(a) == 5 else a,
            f"{OTHERS_RIGHT} The wrong values are the right ones times 2.",
        ),
        (lambda a: a**2, ""),
    ],
)
def test_a_pattern_is_reported(change, sentence):
    assert of_table(change) == sentence


def test_that_signs_differ_in_sign_is_not_told():
    """A number that is −1, 0 or 1 is hardly wrong in another way."""
    right = [(np.sign(table),) for (table,) in (call.arguments for call in CALLS)]
    values = [(one(signs, (0, 0), -2 * signs[0, 0]),) for (signs,) in right]
    assert "sign" not in pattern(TABLE, CALLS, values, right)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda a, b: (b, a), "The returned arrays are the right ones in another order."),
        (lambda a, b: (a, b + a), "Only the first of the 2 returned arrays is right."),
        (lambda a, b: (a * b, b + a), ""),
    ],
)
def test_a_pattern_of_two_arrays_is_reported(change, sentence):
    right = [(a, a @ a) for (a,) in (call.arguments for call in CALLS)]
    assert pattern(TWO, CALLS, [change(*r) for r in right], right) == sentence


def test_a_pattern_of_one_case_alone_is_not_reported():
    """Row 0 is wrong in one case, row 1 in the other."""
    assert of_table(lambda a: one(a, (len(a) - 3, slice(None)))) == ""


def test_a_single_number_has_no_factor():
    """Every number is a multiple of every other, and two may be views of one."""
    number = Question("99.4", "number", 1, inputs, lambda _: ((),))
    right = [(np.array(2.5),)]
    assert pattern(number, CALLS[:1], [(np.array(3.75),)], right) == ""
    assert pattern(number, CALLS[:2], [(np.array(3.75),)] * 2, right * 2) == ""
    assert "times 1/2" in pattern(number, CALLS[:2], [(np.array(1.25),)] * 2, right * 2)
    three = (*CALLS, CALLS[0])
    assert "times 1.5" in pattern(number, three, [(np.array(3.75),)] * 3, right * 3)


@pytest.mark.parametrize("wrong", [5.0, 12.0])
def test_a_whole_number_for_another_is_no_multiple(wrong):
    """Neither "six times 0.8333" nor "six times 2" explains a wrong rank."""
    rank = Question("99.5", "rank", 1, inputs, lambda _: ((),))
    right = [(np.array(6.0),), (np.array(6.0),)]
    assert pattern(rank, CALLS, [(np.array(wrong),)] * 2, right) == ""


def test_equal_ranks_for_others_are_no_multiple():
    """Ranks of six for ranks of five are not "the right ones times 1.2"."""
    ranks = Question("99.5", "ranks", 1, inputs, lambda call: (len(call.arguments[0]),))
    right, wrong = ([(np.full(n, size),) for n in (3, 5)] for size in (5.0, 6.0))
    assert "times" not in pattern(ranks, CALLS, wrong, right)
    uneven = [(r * [1, 2, 1, 1, 1][: len(r)],) for (r,) in right]
    assert "times 1.2" in pattern(ranks, CALLS, [(1.2 * r,) for (r,) in uneven], uneven)


def test_equal_coordinates_at_other_corners_tell_nothing():
    """A hexagon that is turned the other way has the same coordinates, up to the sign."""
    corners = np.exp(1j * (0.2 + np.pi / 3 * np.arange(6)))
    hexagon = np.column_stack([corners.real, corners.imag])
    turned = hexagon[:, ::-1] * [1, -1]
    question = Question("99.2", "hexagon", 1, inputs, lambda _: ((6, 2),))
    assert pattern(question, CALLS, [(turned,)] * 2, [(hexagon,)] * 2) == ""
    others = np.random.default_rng(3).normal(size=(6, 2))
    moved = np.roll(others.ravel(), 5).reshape(6, 2)
    sentence = "The wrong values are the right ones at other positions."
    assert pattern(question, CALLS, [(moved,)] * 2, [(others,)] * 2) == sentence


def test_the_opposite_of_a_whole_number_is_reported():
    characteristic = Question("99.5", "euler", 1, inputs, lambda _: ((),))
    right = [(np.array(2.0),), (np.array(-4.0),)]
    opposite = [(-r,) for (r,) in right]
    sentence = "The wrong numbers differ from the right ones only in sign."
    assert pattern(characteristic, CALLS, opposite, right) == sentence


def test_truth_values_are_not_too_small_by_one():
    """Where all answers are 0 or 1, a wrong one is the other one."""
    flag = Question("99.5", "flag", 1, inputs, lambda _: ((3,),))
    right = [(np.array([1.0, 1.0, 0.0]),)] * 2
    assert "too" not in pattern(flag, CALLS, [(right[0][0] - 1,)] * 2, right)
    larger = [(2 * r,) for (r,) in right]
    assert "too small by 1" in pattern(flag, CALLS, [(r - 1,) for (r,) in larger], larger)


def three_tables(*factors, integers=False):
    """The pattern if the right values of three tables are multiplied by these factors."""
    tables = [np.arange(1.0, 10.0).reshape(3, 3) + (0 if integers else 0.1 * k) for k in range(3)]
    calls = [
        Call("table", (a,), f"{name} table")
        for a, name in zip(tables, ("a first", "the same", "another"), strict=True)
    ]
    values = [(k * a,) for k, a in zip(factors, tables, strict=True)]
    return pattern(TABLE, calls, values, [(a,) for a in tables])


def test_rounding_errors_are_no_factor():
    """A factor close to one is reported if several cases share it, as with 3.14 for π."""
    rough = 3.14 / np.pi
    assert "times (1 -5.1e-04)" in three_tables(rough, rough, rough)
    assert three_tables(1 + 1e-8, 1 - 2e-8, 1 + 3e-8) == ""
    assert three_tables(1 + 1e-8, 1, 1) == OTHERS_RIGHT


def test_single_precision_makes_most_cases_wrong():
    """One case whose wrong values happen to have few digits is not single precision."""
    assert "float32" not in of_table(lambda a: a.astype(np.float32) if len(a) == 5 else a)


def test_a_right_value_of_zero_tells_nothing():
    """Many wrong answers are right where all data are zero."""
    tables = [np.zeros((3, 3)), np.ones((3, 3)), np.eye(3)]
    calls = [Call("table", (a,), "a table") for a in tables]
    right = [(a,) for a in tables]
    assert "right only" not in pattern(TABLE, calls, [(np.cos(a) * a,) for a in tables], right)


def test_positions_are_compared_as_seen_from_the_corner():
    """A result on the wrong side of the first corner is not the opposite of the right one."""
    center = Question(
        *("99.6", "center", 1, inputs, lambda _: ((2,),), ()),
        normal_form=relative_to_a_corner,
    )
    calls = [
        Call("center", (a[:3, :2] + 5,), "a triangle") for a in (c.arguments[0] for c in CALLS)
    ]
    right = [(c.arguments[0].mean(axis=0),) for c in calls]
    corners = [c.arguments[0][0] for c in calls]
    turned = [(2 * q - r,) for q, (r,) in zip(corners, right, strict=True)]
    assert pattern(center, calls, turned, right) == (
        "Seen from the first corner, the wrong values are the right ones with the opposite sign."
    )


def test_a_factor_is_said_once():
    """Equal factors are not repeated: 1.25 of whole numbers, and two equal ones of three."""
    same = "The wrong values are the right ones times 1.25."
    assert three_tables(1.25, 1.25, 1.25, integers=True) == same
    assert three_tables(2, 2, 3) == (
        "For a first table, the wrong values are the right ones times 2. "
        "For another table, they are the right ones times 3."
    )


def test_missing_digits_of_stored_values_are_no_other_factor():
    """Stored values have twelve digits, so far from the origin a factor is known less exactly.

    The factor is taken from the case with the least tolerance.
    """
    rough = Question(
        *("99.7", "table", 1, inputs, lambda call: (call.arguments[0].shape,), ()),
        tolerance=lambda call: 1e-4 if len(call.arguments[0]) == 3 else 1e-9,
    )
    right = [call.arguments for call in CALLS]
    sentence = "The wrong values are the right ones with the opposite sign."
    for factor, is_equal in ((1 - 4e-5, True), (1 - 4e-3, False)):
        values = [(-factor * right[0][0],), (-right[1][0],)]
        assert (pattern(rough, CALLS, values, right) == sentence) == is_equal


def test_cases_may_have_the_same_name():
    alike = [Call("table", call.arguments, "a table") for call in CALLS]
    right = [call.arguments for call in CALLS]
    values = [right[0], (-right[1][0],)]
    assert "opposite sign" in pattern(TABLE, alike, values, right)


def halves(cut, whole=("integers",), change=np.trunc):
    """The pattern if halves of tables change in some cases; `whole` tables hold integers."""
    numbers = 10 * np.arange(9.0).reshape(3, 3) + 3
    tables = {"small": 10 * CALLS[0].arguments[0], "large": 10 * CALLS[1].arguments[0]}
    tables["integers"] = numbers
    tables = {name: a.astype(int) if name in whole else a for name, a in tables.items()}
    calls = [Call("table", (a,), name) for name, a in tables.items()]
    right = [(a / 2,) for a in tables.values()]
    values = [(change(a / 2) if name in cut else a / 2,) for name, a in tables.items()]
    return pattern(TABLE, calls, values, right)


def test_lost_decimals_of_integers_are_reported():
    """An answer is right for real numbers, and stores halves of integers as integers."""
    assert "the decimals are lost" in halves(cut=("integers",))


def test_integers_whose_halves_are_integers_lose_no_decimals():
    """They are right, and speak for no other cause."""
    tables = [CALLS[0].arguments[0], np.arange(9).reshape(3, 3), 2 * np.arange(9).reshape(3, 3)]
    calls = [Call("table", (a,), name) for a, name in zip(tables, "abc", strict=True)]
    right = [(a / 2,) for a in tables]
    values = [right[0], *((np.trunc(r),) for (r,) in right[1:])]
    assert "the decimals are lost" in pattern(TABLE, calls, values, right)


def test_other_errors_for_arrays_of_integers_only_are_reported():
    """At least two cases are wrong, all those with integers and no others."""
    both = ("small", "integers")
    words = "wrong only where an argument is an array of integers"
    assert words in halves(both, both, np.square)
    assert "such as `np.zeros_like` makes?" in halves(both, both, np.square)
    rounding = halves(both, both, lambda a: (1 + 1e-6 * np.cos(a)) * a)
    assert rounding.endswith(f"{words}."), "an error of a millionth is no lost decimal"
    assert words not in halves(("integers",), ("integers",), np.square)
    assert words not in halves(both, ("integers",), np.square)


@pytest.mark.parametrize(
    ("cut", "whole"),
    [
        (("small",), ("integers",)),
        (("small", "integers"), ("integers",)),
        (("integers",), ()),
        (("integers",), ("small", "large", "integers")),
    ],
    ids=["real numbers", "real numbers too", "no integers", "integers everywhere"],
)
def test_lost_decimals_have_no_other_cause(cut, whole):
    """Nothing is said of integers if they are not what the wrong cases have in common alone."""
    assert "decimals" not in halves(cut, whole)
