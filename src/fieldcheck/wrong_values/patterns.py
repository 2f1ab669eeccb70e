"""Patterns of wrong values: a multiple of the right ones, another order, a single wrong column.

A pattern is a statement on the returned numbers. It is reported only if it holds in every wrong
case, so it is true whatever the code of the student.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fieldcheck.answers import rows_sorted
from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, scale
from fieldcheck.shapes import ORDINALS
from fieldcheck.wrong_values.compared import (
    Case,
    are_single_whole_numbers,
    are_truth_values,
    compared,
)
from fieldcheck.wrong_values.which_cases import integers, single_precision, sizes, which

CLOSE = 1e-6
"""Relative difference of factors that count as equal."""
FACTORS = {
    **{str(n): float(n) for n in (2, 3, 4, 6, 8)},
    **{f"1/{n}": 1 / n for n in (2, 3, 4, 6, 8)},
    "π": np.pi,
    "2π": 2 * np.pi,
    "4π": 4 * np.pi,
    "8π": 8 * np.pi,
    "16π": 16 * np.pi,
    "1/π": 1 / np.pi,
    "1/(2π)": 1 / (2 * np.pi),
    "1/(4π)": 1 / (4 * np.pi),
    "1/(8π)": 1 / (8 * np.pi),
    "1/(16π)": 1 / (16 * np.pi),
}


NEARLY_ONE = 1e-3
"""Factors this close to one may be rounding errors, which have another factor in each case."""

FEWEST_NUMBERS = 3
"""Fewest numbers of which a factor without a name is reported: two are often views of one."""

Kind = Callable[[Sequence[Case]], str]
"""A pattern: the sentence if all wrong cases have it, else nothing."""


def pattern(
    question: Question,
    calls: Sequence[Call],
    values: Sequence[Values],
    right: Sequence[Values],
    are_all: bool = True,
    in_order: bool = True,
) -> str:
    """Return what the wrong values have in common, in one or two sentences, or nothing.

    Parameters
    ----------
    question : Question
        The question.
    calls : sequence of Call
        The calls.
    values, right : sequence of Values
        The returned and the right arrays of each call, of the same shapes.
    are_all : bool
        Whether these are all calls, so that it can be said which of them are right.
    in_order : bool
        Whether the rows are compared in the order in which they were returned.
    """
    cases = [compared(question, *each) for each in zip(calls, values, right, strict=True)]
    wrong = [case for case in cases if not case.right_if(lambda v, _: v)]
    if not wrong:
        return ""
    # A wrong rank is no multiple of the right one, even if it happens to be twice as large, and in
    # special cases only it is too small by one for any reason. A wrong sign has another sign.
    rank = are_single_whole_numbers(right)
    signs = all(np.isin(value, (-1, 0, 1)).all() for values in right for value in values)
    kinds_of_numbers = (_zero, *(() if rank else (_factor,)), *(() if signs else (_signs,)))
    arithmetic = tuple(map(_from_the_corner, kinds_of_numbers))
    offset = () if rank and 2 * len(wrong) <= len(cases) else (_offset,)
    of_numbers = () if are_truth_values(right) else (*arithmetic, *offset)
    kinds = (*of_numbers, _outputs, _order, *((_positions,) if in_order else ()))
    found = (
        integers(cases, wrong)
        or single_precision(cases, wrong)
        or next(filter(None, (kind(wrong) for kind in kinds)), "")
    )
    if not are_all:
        return found
    some = which(cases, wrong, bool(_order(wrong))) or ("" if found else sizes(cases, wrong))
    return " ".join(filter(None, (some, found)))


def _from_the_corner(kind: Kind) -> Kind:
    """Return a pattern that says from where positions are taken, if not from the origin."""

    def found(wrong: Sequence[Case]) -> str:
        sentence = kind(wrong)
        if not sentence or not any(case.moved for case in wrong):
            return sentence
        return f"Seen from the first corner, {sentence[0].lower()}{sentence[1:]}"

    return found


def _zero(wrong: Sequence[Case]) -> str:
    zero = all(not v.any() for case in wrong for v in case.values)
    return "The wrong values are all zero." if zero else ""


def _factor(wrong: Sequence[Case]) -> str:
    """Recognize v = k r with one k in all cases, or another k in each case of many entries."""
    factors = [k for case in wrong if (k := _factor_of(case))]
    entries = [sum(np.count_nonzero(r) for r in case.right) for case in wrong]
    if len(factors) < len(wrong) or sum(entries) < 2 or _are_rounding(factors):
        return ""
    if max(entries) == 1 and len(wrong) < FEWEST_NUMBERS and not _named(factors[0]):
        return ""
    k = factors[int(np.argmin([case.tolerance for case in wrong]))]
    if _are_equal(factors, k, wrong) and _plausible(k, wrong):
        return f"The wrong values are the right ones {_times(k)}."
    if min(entries) < 3:
        return ""
    # A case for each factor that reads differently; two of them show that it varies.
    names: dict[str, str] = {}
    for k, case in zip(factors, wrong, strict=True):
        names.setdefault(_times(k), case.name)
    (first, name), *others = names.items()
    if not others:
        return (
            "" if _is_one_whole_number(wrong) else f"The wrong values are the right ones {first}."
        )
    other, its_name = others[0]
    return (
        f"For {name}, the wrong values are the right ones {first}. "
        f"For {its_name}, they are the right ones {other}."
    )


def _are_equal(factors: Sequence[float], k: float, wrong: Sequence[Case]) -> bool:
    """Return whether factors are k, as far as the digits of the stored values show it."""
    close = [max(CLOSE, case.tolerance) for case in wrong]
    return bool((np.abs(np.subtract(factors, k)) <= abs(k) * np.array(close)).all())


def _are_rounding(factors: Sequence[float]) -> bool:
    """Return whether the factors are so close to one, without being equal, or single."""
    excess = np.array(factors) - 1
    largest = np.abs(excess).max()
    return bool(largest < NEARLY_ONE and (len(excess) < 2 or np.ptp(excess) > 0.01 * largest))


def _factor_of(case: Case) -> float:
    """Return k if v = k r, else zero."""
    v, r = (np.concatenate([a.ravel() for a in arrays]) for arrays in (case.values, case.right))
    k = float(v @ r / (r @ r)) if r.any() else 0.0
    return k if k and case.right_if(lambda v, _: v / k) else 0.0


def _times(factor: float) -> str:
    if np.isclose(factor, -1, rtol=CLOSE):
        return "with the opposite sign"
    size = abs(factor)
    number = f"{size:.4g}" if abs(size - 1) > 1e-3 else f"(1 {size - 1:+.1e})"
    return f"times {'−' if factor < 0 else ''}{_named(factor) or number}"


def _named(factor: float) -> str:
    """Return the name of the absolute value of a factor, if it has one."""
    names = (n for n, value in FACTORS.items() if np.isclose(abs(factor), value, rtol=CLOSE))
    return next(names, "")


def _plausible(factor: float, wrong: Sequence[Case]) -> bool:
    """Return whether a factor says more than that one whole number stands for another."""
    whole = all((r == np.round(r)).all() for case in wrong for r in case.right)
    return not whole or factor < 0 or bool(_named(factor))


def _is_one_whole_number(wrong: Sequence[Case]) -> bool:
    """Return whether all right values are the same whole number, such as ranks of five."""
    sizes = np.unique(np.abs(np.concatenate([r.ravel() for case in wrong for r in case.right])))
    return len(sizes) == 1 and float(sizes[0]).is_integer()


def _signs(wrong: Sequence[Case]) -> str:
    if not all(case.right_if(np.copysign) for case in wrong):
        return ""
    return "The wrong numbers differ from the right ones only in sign."


def _offset(wrong: Sequence[Case]) -> str:
    """Recognize v = r + c, with one c for all entries of all cases."""
    c = float((wrong[0].values[0] - wrong[0].right[0]).flat[0])
    several = sum(r.size for case in wrong for r in case.right) > 2
    if not several or not all(case.right_if(lambda v, _: v - c) for case in wrong):
        return ""
    return f"The wrong values are all too {'large' if c > 0 else 'small'} by {abs(c):.4g}."


def _outputs(wrong: Sequence[Case]) -> str:
    """Recognize arrays that are exchanged, and right arrays beside wrong ones."""
    count = len(wrong[0].right)
    if frozenset.intersection(*(case.orders for case in wrong)):
        return "The returned arrays are the right ones in another order."
    right = [j for j in range(count) if all(c.same(c.values[j], c.right[j]) for c in wrong)]
    if len(right) != 1:
        return ""
    return f"Only the {ORDINALS[right[0]]} of the {count} returned arrays is right."


ORDERS: tuple[tuple[str, Callable[[np.ndarray], np.ndarray], bool], ...] = (
    ("The wrong arrays are the transposes of the right ones.", lambda a: a.T, False),
    ("The wrong arrays are right in the reverse order.", lambda a: a[::-1] if a.ndim else a, False),
    (
        "The wrong arrays are right with their columns in the reverse order.",
        lambda a: a[..., ::-1] if a.ndim else a,
        False,
    ),
    ("The wrong arrays have the right rows in another order.", rows_sorted, True),
    (
        "The wrong arrays have the right columns in another order.",
        lambda a: rows_sorted(a.T),
        True,
    ),
    ("The wrong values are the right ones at other positions.", lambda a: np.sort(a, None), True),
)
"""Sentence, a rearrangement of an array, and whether the right array is rearranged, too."""


def _order(wrong: Sequence[Case]) -> str:
    orders = ORDERS if all(map(_are_different, wrong)) else ORDERS[:-1]
    for sentence, arranged, both in orders:
        if all(
            case.same(arranged(v), arranged(r) if both else r)
            for case in wrong
            for v, r in case.pairs
        ):
            return sentence
    return ""


def _are_different(case: Case) -> bool:
    """Return whether most right values differ, so that equal ones elsewhere are no chance.

    The corners of a regular hexagon have few coordinates, up to the sign.
    """
    sizes = [np.abs(r) for r in case.right]
    return all(2 * len(np.unique(np.round(s / scale(s), 9))) > s.size for s in sizes)


def _positions(wrong: Sequence[Case]) -> str:
    """Recognize that only one entry, row or column is wrong, or right, and always the same one."""
    if len(wrong[0].right) > 1:
        return ""
    differ = [case.differ(case.values[0], case.right[0]) for case in wrong]
    each = [[*_statements(one), *_of_the_only_one(one)] for one in differ]
    told = _statements(max(differ, key=np.size))
    sentence = next((s for s in told if all(s in others for others in each)), "")
    is_by_size = sentence.endswith("right.") and not all(map(_right_by_themselves, wrong))
    return "" if is_by_size else sentence


def _right_by_themselves(case: Case) -> bool:
    """Return whether the entries that count as right are so beside smaller ones, too."""
    (v,), (r,) = case.values, case.right
    right = ~case.differ(v, r)
    return case.same(v[right], r[right])


def _of_the_only_one(wrong: np.ndarray) -> list[str]:
    """Return what holds for the only row, column or entry, which is the last one, too."""
    names = {1: ["entry"], 2: ["row", "column"]}.get(wrong.ndim, ())
    single = (name for name, n in zip(names, wrong.shape, strict=False) if n == 1)
    return [f"Only the last {name} is wrong." for name in single if wrong.any()]


def _statements(wrong: np.ndarray) -> list[str]:
    """Return the true statements on which entries are wrong."""
    statements = []
    if wrong.ndim == 2 and wrong.shape[0] == wrong.shape[1] > 1:
        i, j = np.indices(wrong.shape)
        parts = {"on": i == j, "above": i < j, "below": i > j}
        for name, part in parts.items():
            if not wrong[~part].any():
                statements.append(f"Only values {name} the diagonal are wrong.")
            if wrong[~part].all() and not wrong[part].any():
                statements.append(f"Only the values {name} the diagonal are right.")
    for axis, name in enumerate({1: ["entry"], 2: ["row", "column"]}.get(wrong.ndim, ())):
        along = np.asarray(wrong if wrong.ndim == 1 else wrong.any(axis=1 - axis))
        for word, chosen in (("wrong", along), ("right", ~along)):
            if chosen.sum() == 1 < len(chosen):
                k = int(chosen.argmax())
                statements.append(f"Only {name} [{k}] is {word}.")
                if k == len(chosen) - 1:
                    statements.append(f"Only the last {name} is {word}.")
    return statements
