"""Displayed formulas of docstrings, typeset: subscripts, superscripts, Greek letters and signs.

A docstring writes a formula in plain text, as ``sum_j lambda_j phi(|x - p_j|)``, in a line of its
own that is indented. A terminal shows it so; a page shows the formula.
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
UPRIGHT |= {"sqrt", "vol", "with"}

TOKEN = re.compile(r"[_^](?=[\w({\-])|[^\W\d_]+'*|\d+(?:\.\d+)?| \. |<=|>=| {2,}|.", flags=re.S)
ARGUMENT = re.compile(r"-?[^\W_]+")
CLOSING = {"(": ")", "{": "}"}


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
