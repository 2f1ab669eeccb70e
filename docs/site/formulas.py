"""Formulas of docstrings, typeset: subscripts, superscripts, Greek letters and signs.

A docstring writes a formula in plain text, as ``sum_j lambda_j phi(|x - p_j|)``, in a line of its
own that is indented, or within a sentence. A terminal shows it so; a page shows the formula.
"""

import re
from html import escape

GREEK = {
    "alpha": "α",
    "beta": "β",
    "epsilon": "ε",
    "eta": "η",
    "lambda": "λ",
    "mu": "μ",
    "nu": "ν",
    "omega": "ω",
    "phi": "φ",
    "pi": "π",
    "psi": "ψ",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "zeta": "ζ",
}
SIGNS = {"sum": "∑", "prod": "∏", "int": "∫", "<=": "≤", ">=": "≥", "-": "−", " . ": " · "}
WIDE = "\N{EM SPACE}"
"""Between two formulas of a line."""
UPRIGHT = {"and", "atan", "cos", "det", "diag", "exp", "for", "log", "max", "min", "of", "sin"}
UPRIGHT |= {"argmin", "grad", "sqrt", "vol", "with"}

TOKEN = re.compile(r"[_^](?=[\w({\-])|[^\W\d_]+'*|\d+(?:\.\d+)?| \. |<=|>=| {2,}|.", flags=re.S)
ARGUMENT = re.compile(r"-?[^\W_]+")
CLOSING = {"(": ")", "{": "}"}

NAMES = "|".join(
    sorted({*GREEK, *UPRIGHT, "sum", "prod", "int", "dt"} - {"and", "for", "of", "with"})
)
LETTER = rf"(?<![^\W\d_])(?:{NAMES}|[^\W\d_])'*(?![^\W\d_])"
WORD = (
    rf"(?:{LETTER}|[_^][^\W_]{{1,2}}(?![^\W\d_])|\d+(?:\.\d+)?|\.(?=[|)])|[-+*/=<>|(){{}}\[\],^_])+"
)
FORMULA = re.compile(rf"(?<!\S){WORD}(?: +(?:\. +)?{WORD})*(?![^\s.,;:])")
"""Words of single letters, numbers and signs; in a sentence, it is a formula if it has an index."""
INDEX = re.compile(r"(?:(?<=[^\W\d_]|[)}\]|'])_|(?<=[\w)}\]|'])\^)(?=[\w({\-])|phi\(")
AROUND = re.compile(r"^(?:[aI-] )?(?P<formula>.*?)(?:(?<=[\w)|]) [aI]| [-*/=])?[ ,]*$")
"""An article or a sign beside a formula."""


def parts(text: str) -> list[tuple[str, bool]]:
    """Return the parts of a sentence, each with whether it is a formula.

    Examples
    --------
    >>> parts("Values f(x_i) of n_folds.")
    [('Values ', False), ('f(x_i)', True), (' of n_folds.', False)]
    """
    out, end = [], 0
    for found in FORMULA.finditer(text):
        inside = AROUND.match(found[0])
        start, stop = (found.start() + at for at in inside.span("formula"))  # type: ignore[union-attr]
        if INDEX.search(text[start:stop]) and is_balanced(text[start:stop]):
            out += [(text[end:start], False), (text[start:stop], True)]
            end = stop
    return [(part, is_formula) for part, is_formula in [*out, (text[end:], False)] if part]


def is_balanced(formula: str) -> bool:
    """Tell whether each bracket is closed, so that no formula ends within."""
    pairs = ("()", "{}", "[]")
    return (
        all(formula.count(a) == formula.count(b) for a, b in pairs) and not formula.count("|") % 2
    )


def typeset(formula: str) -> str:
    """Return a formula in plain text as HTML.

    Examples
    --------
    >>> typeset("lambda_j^-2 = sum_(i+1) x")
    '<i>λ</i><sub><i>j</i></sub><sup>−2</sup> = ∑<sub><i>i</i>+1</sub> <i>x</i>'
    """
    out, at = [], 0
    while at < len(formula):
        token = TOKEN.match(formula, at)[0]  # type: ignore[index]
        at += len(token)
        if token in "_^":
            inside, at = argument(formula, at)
            tag = "sub" if token == "_" else "sup"
            out.append(f"<{tag}>{typeset(inside)}</{tag}>")
        else:
            out.append(symbol(token))
    return "".join(out)


def argument(formula: str, at: int) -> tuple[str, int]:
    """Return what is lowered or raised, without the brackets around it, and where it ends."""
    if formula[at] not in CLOSING:
        found = ARGUMENT.match(formula, at)
        return (found[0], found.end()) if found else (formula[at], at + 1)
    depth, end = 1, at + 1
    while depth and end < len(formula):
        depth += (formula[end] == formula[at]) - (formula[end] == CLOSING[formula[at]])
        end += 1
    return formula[at + 1 : end - 1], end


def symbol(token: str) -> str:
    """Return a name, a number or a sign as HTML; names are italic, except those of functions."""
    if token in SIGNS:
        return SIGNS[token]
    if token.isspace() and len(token) > 1:
        return WIDE
    if not token[0].isalpha() or token in UPRIGHT:
        return escape(token)
    return f"<i>{GREEK.get(token, token)}</i>"
