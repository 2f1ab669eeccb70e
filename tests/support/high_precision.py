"""High-precision reference: the formulas of the slides in five hundred decimal digits.

With weights of 1e60 and steps of 1e-80, normal equations and difference quotients are accurate
enough in this precision, though not in sixteen digits. Points and values are the floating-point
numbers, converted without rounding.
"""

from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from functools import wraps
from itertools import product

import numpy as np

DIGITS = 500
STEP = Decimal("1e-80")

Vector = list[Decimal]
OfSquare = Callable[[Decimal], Decimal]


def in_digits(function):
    """Run in DIGITS digits; the caller rounds the result once, to a float."""

    @wraps(function)
    def run(*arguments, **options):
        with localcontext() as context:
            context.prec = DIGITS
            return function(*arguments, **options)

    return run


def exact(x) -> Vector:
    return [Decimal(float(v)) if not isinstance(v, Decimal) else v for v in x]


def squared_distance(x: Vector, p: Vector) -> Decimal:
    return sum((a - b) ** 2 for a, b in zip(x, p, strict=True))


def basis(x: Vector, degree: int) -> Vector:
    """Monomials of total degree at most `degree`."""
    powers = (a for a in product(range(degree + 1), repeat=len(x)) if sum(a) <= degree)
    return [_product(v**k for v, k in zip(x, a, strict=True) if k) for a in powers]


def _product(factors) -> Decimal:
    result = Decimal(1)
    for factor in factors:
        result *= factor
    return result


def dot(a: Sequence[Decimal], b: Sequence[Decimal]) -> Decimal:
    return sum((x * y for x, y in zip(a, b, strict=True)), Decimal(0))


def solved(matrix: list[Vector], right: Vector) -> Vector:
    """Gaussian elimination with row pivoting."""
    rows = [[*row, b] for row, b in zip(matrix, right, strict=True)]
    n = len(rows)
    for j in range(n):
        best = max(range(j, n), key=lambda i: abs(rows[i][j]))
        rows[j], rows[best] = rows[best], rows[j]
        for i in range(j + 1, n):
            factor = rows[i][j] / rows[j][j]
            for k in range(j, n + 1):
                rows[i][k] -= factor * rows[j][k]
    x = [Decimal(0)] * n
    for j in reversed(range(n)):
        x[j] = (rows[j][n] - dot(rows[j][j + 1 : n], x[j + 1 :])) / rows[j][j]
    return x


# --- weights and kernels as functions of s = r² ----------------------------------------------


def inverse_square(epsilon: float) -> OfSquare:
    return lambda s: 1 / (s + Decimal(epsilon) ** 2)


def gaussian(scale: float) -> OfSquare:
    return lambda s: (-s / Decimal(scale) ** 2).exp()


def thin_plate(s: Decimal) -> Decimal:
    return s * s.ln() if s else Decimal(0)


def minus_distance(s: Decimal) -> Decimal:
    return -s.sqrt()


def cube(s: Decimal) -> Decimal:
    return s * s.sqrt()


def multiquadric(scale: float) -> OfSquare:
    return lambda s: -(1 + s / Decimal(scale) ** 2).sqrt()


# --- methods -----------------------------------------------------------------------------------


def moving_coefficients(points, values, x: Vector, weight: OfSquare, degree: int) -> Vector:
    """c(x) of BᵀW²B c = BᵀW²V, in monomials of p - x."""
    w2 = [weight(squared_distance(x, p)) ** 2 for p in points]
    b = [basis([c - a for a, c in zip(x, p, strict=True)], degree) for p in points]
    q = len(b[0])
    h = [[dot(w2, [r[i] * r[j] for r in b]) for j in range(q)] for i in range(q)]
    right = [dot(w2, [r[i] * f for r, f in zip(b, values, strict=True)]) for i in range(q)]
    return solved(h, right)


@in_digits
def moving(points, values, x, weight: OfSquare, degree: int = 1) -> Decimal:
    """f_MLS(x), the coefficient of 1 in monomials of p - x."""
    points, values, x = [exact(p) for p in points], exact(values), exact(x)
    return moving_coefficients(points, values, x, weight, degree)[0]


@in_digits
def moving_objective(points, values, x, weight: OfSquare, degree: int = 1) -> float:
    """ψ_MLS(x) = ½ Σ w² (bᵀc - f)²."""
    points, values, x = [exact(p) for p in points], exact(values), exact(x)
    c = moving_coefficients(points, values, x, weight, degree)
    total = Decimal(0)
    for p, f in zip(points, values, strict=True):
        residual = dot(basis([b - a for a, b in zip(x, p, strict=True)], degree), c) - f
        total += (weight(squared_distance(x, p)) * residual) ** 2
    return float(total / 2)


@in_digits
def rbf_coefficients(points, values, kernel: OfSquare, degree: int, smoothing: float = 0.0):
    """(λ, c) of the saddle-point system, in monomials of the coordinates."""
    points, values = [exact(p) for p in points], exact(values)
    b = [basis(p, degree) if degree >= 0 else [] for p in points]
    q = len(b[0])
    rows = []
    for i, p in enumerate(points):
        row = [kernel(squared_distance(p, other)) for other in points]
        row[i] += Decimal(smoothing)
        rows.append([*row, *b[i]])
    rows += [[r[k] for r in b] + [Decimal(0)] * q for k in range(q)]
    solution = solved(rows, [*values, *[Decimal(0)] * q])
    return solution[: len(points)], solution[len(points) :]


@in_digits
def rbf(points, coefficients, x, kernel: OfSquare, degree: int) -> Decimal:
    """f_RBF(x) = Σ λ φ(|x - p|) + b(x)ᵀ c."""
    x = exact(x)
    lam, c = coefficients
    near = [kernel(squared_distance(x, exact(p))) for p in points]
    return dot(lam, near) + (dot(basis(x, degree), c) if c else Decimal(0))


@in_digits
def gradient(f: Callable[[Vector], Decimal], x) -> np.ndarray:
    """Central differences with a step of 1e-80."""
    x, result = exact(x), []
    for k in range(len(x)):
        there, back = x.copy(), x.copy()
        there[k] += STEP
        back[k] -= STEP
        result.append(float((f(there) - f(back)) / (2 * STEP)))
    return np.array(result)


@in_digits
def beside(x, offset: str = "1e-60") -> Vector:
    """A point so close to x that a continuous function has its value at x there."""
    return [c + Decimal(offset) * (k + 1) for k, c in enumerate(exact(x))]
