"""Linear algebra in rational arithmetic, with exact zeros and ranks."""

from collections.abc import Sequence
from fractions import Fraction

Row = list[Fraction]
Rows = Sequence[Sequence[Fraction | int | float]]


def rational(rows: Rows) -> list[Row]:
    """The same numbers as fractions; floating-point numbers are converted without rounding."""
    return [[Fraction(x) for x in row] for row in rows]


def dot(a: Sequence, b: Sequence) -> Fraction:
    return sum((Fraction(x) * Fraction(y) for x, y in zip(a, b, strict=True)), Fraction(0))


def minus(a: Sequence, b: Sequence) -> Row:
    return [Fraction(x) - Fraction(y) for x, y in zip(a, b, strict=True)]


def transposed(a: Rows) -> list[Row]:
    return rational(zip(*a, strict=True))


def product(a: Rows, b: Rows) -> list[Row]:
    columns = transposed(b)
    return [[dot(row, column) for column in columns] for row in a]


def times(a: Rows, x: Sequence) -> Row:
    return [dot(row, x) for row in a]


def _eliminated(a: Rows) -> tuple[list[Row], list[int], int]:
    """Reduced row echelon form without scaling of the pivots, the pivot columns, and the sign."""
    rows, pivots, sign = rational(a), [], 1
    for j in range(len(rows[0])):
        at = len(pivots)
        best = next((i for i in range(at, len(rows)) if rows[i][j]), None)
        if best is None:
            continue
        if best != at:
            rows[at], rows[best], sign = rows[best], rows[at], -sign
        for i, row in enumerate(rows):
            if i != at and row[j]:
                factor = row[j] / rows[at][j]
                rows[i] = [x - factor * p for x, p in zip(row, rows[at], strict=True)]
        pivots.append(j)
    return rows, pivots, sign


def rank(a: Rows) -> int:
    return len(_eliminated(a)[1])


def determinant(a: Rows) -> Fraction:
    rows, pivots, result = _eliminated(a)
    for i in range(len(rows)):
        result *= rows[i][i]
    return Fraction(result) if len(pivots) == len(rows) else Fraction(0)


def solved(a: Rows, b: Sequence) -> Row:
    """The solution of a regular square system."""
    rows, pivots, _ = _eliminated([[*row, x] for row, x in zip(a, b, strict=True)])
    if pivots != list(range(len(a))):
        raise ZeroDivisionError("the matrix is singular")
    return [row[-1] / row[i] for i, row in enumerate(rows)]


def least_squares(a: Rows, b: Sequence, weights: Sequence | None = None) -> Row:
    """The solution of A^T M A c = A^T M b with M = diag(weights)."""
    m = [1] * len(a) if weights is None else weights
    at = [[Fraction(w) * x for w, x in zip(m, column, strict=True)] for column in transposed(a)]
    return solved(product(at, a), times(at, b))


def inverse(a: Rows) -> list[Row]:
    unit = [[int(i == j) for j in range(len(a))] for i in range(len(a))]
    return transposed([solved(a, column) for column in unit])


def circumcentre(corners: Rows) -> Row:
    """The point at equal distances from all corners."""
    first, *others = rational(corners)
    edges = [minus(p, first) for p in others]
    return [
        x + y for x, y in zip(first, solved(edges, [dot(e, e) / 2 for e in edges]), strict=True)
    ]
