"""In which cases values are wrong: all but one, in space, for long tables, for integers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.question import scale
from fieldcheck.wrong_values.compared import Case, are_single_whole_numbers

LOST = 1e-3
"""Relative errors below this one are no decimals that an array of integers has lost."""

FEWEST_ROWS = 4
"""Tables of up to so many rows are special: their points may just determine the coefficients."""

HERE = "Among the inputs of this check, your values are"
"""What holds for these inputs need not hold for all others."""

OTHERS_RIGHT = "Your values are right for all other inputs of this check."
"""What is special in the only wrong one need not be the reason, so it is not named again."""

SPACES = {1: "on a line", 2: "in the plane", 3: "in space"}
"""Where points with so many coordinates are; wider tables contain something else."""


def which(cases: Sequence[Case], wrong: Sequence[Case], are_permuted: bool) -> str:
    """Recognize a single wrong case, or a single right one.

    The values zero are right by chance, and so may be a single number of something, those for the
    fewest points, and values with an error: two points are always neighbours, one square may happen
    to have the right orientation, and large coordinates hide small errors.
    """
    right = [case for case in cases if case not in wrong]
    if len(wrong) == 1 < len(cases):
        return OTHERS_RIGHT
    if not all(case.is_exact for case in right):
        return ""
    if len(right) == 1:
        is_special = 0 < right[0].rows <= FEWEST_ROWS and all(
            case.rows > right[0].rows for case in wrong
        )
        is_zero = not any(r.any() for r in right[0].right)
        is_number = are_single_whole_numbers([case.right for case in cases])
        is_chance = is_special or is_zero or is_number or are_permuted
        return "" if is_chance else f"{HERE} right only for {right[0].name}."
    return _dimensions({case.dimension for case in right}, {case.dimension for case in wrong})


def _dimensions(right: set[int], wrong: set[int]) -> str:
    """Recognize that all cases are right up to a dimension, and all others are wrong."""
    if not right or not right | wrong <= SPACES.keys() or max(right) >= min(wrong):
        return ""
    below, above = (" and ".join(SPACES[d] for d in sorted(these)) for these in (right, wrong))
    return f"{HERE} right {below}, and wrong {above}."


def sizes(cases: Sequence[Case], wrong_cases: Sequence[Case]) -> str:
    """Recognize that all short tables are wrong and all long ones are right, or the opposite.

    Small errors say nothing: whether they are above the tolerance is chance. Neither do right cases
    of few points, which may just determine the coefficients, or one more, which may be special.
    """
    right_cases = [case for case in cases if case not in wrong_cases]
    right, wrong = ({case.rows for case in these} for these in (right_cases, wrong_cases))
    if not right or 0 in right | wrong or not all(case.is_far_off for case in wrong_cases):
        return ""
    if not all(case.is_exact for case in right_cases):
        return ""
    if len(right) == 1:
        return ""  # such as the triangles among polygons, which are special
    if sum(case.rows > FEWEST_ROWS for case in right_cases) < 2 or max(wrong) <= FEWEST_ROWS:
        return ""
    if max(wrong) < min(right):
        these, others = f"{min(right)} or more", f"{max(wrong)} or fewer"
    elif max(right) < min(wrong):
        these, others = f"{max(right)} or fewer", f"{min(wrong)} or more"
    else:
        return ""
    return f"{HERE} right where the first table has {these} rows, and wrong where it has {others}."


def integers(cases: Sequence[Case], wrong: Sequence[Case]) -> str:
    """Recognize that the wrong cases are those in which an argument is an array of integers.

    Where the right values are integers, too, an array of integers loses nothing.
    """
    right = [case.whole for case in cases if case not in wrong and not case.is_right_whole]
    always = frozenset.intersection(*(case.whole for case in wrong))
    if not (right and always.difference(*right)):
        return ""
    cut = all(
        case.same(v, r) or ((v == np.trunc(v)) & (np.abs(v - r) < 1)).all()
        for case in wrong
        for v, r in case.pairs
    )
    if cut:
        return (
            "Where an argument is an array of integers, the decimals are lost. They are cut by "
            "`//`, and in arrays of integers: a copy, or what `np.zeros_like` makes. "
            "`a.astype(float)` and `np.zeros(a.shape)` hold decimals."
        )
    if len(wrong) == 1:
        return ""
    only = "Your values are wrong only where an argument is an array of integers."
    if not all((np.abs(v - r) <= LOST * scale(r)).all() for case in wrong for v, r in case.pairs):
        only += (
            " Do you divide with `//`, or store decimals in an array of integers, such as "
            "`np.zeros_like` makes?"
        )
    return only


def single_precision(cases: Sequence[Case], wrong: Sequence[Case]) -> str:
    """Recognize right values that are rounded to float32, which makes most cases wrong."""
    close = 2 * len(wrong) > len(cases) and all(
        case.single and all((np.abs(v - r) <= 1e-4 * scale(r)).all() for v, r in case.pairs)
        for case in wrong
    )
    if not close:
        return ""
    return "The wrong values have the seven digits of float32: compute with float64."
