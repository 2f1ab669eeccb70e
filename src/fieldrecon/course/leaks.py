"""The guard: nothing of a solution, a hidden case or its answers reaches what students get."""

from __future__ import annotations

import ast
import io
import json
import keyword
import re
import tokenize
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from pathlib import Path

import numpy as np

from fieldcheck.calls import Call, Values
from fieldrecon.course.sources import Source

RUN = 8
"""So many tokens in a row, names with their dots as one, are nobody's accident."""
WORDS = 12
"""The same of the words of a model answer, or of a rubric."""
SIGNIFICANT, MOST_SIGNIFICANT = 9, 12
"""Numbers that agree in as many digits as are written are the same, if these are so many."""
LONG_NUMBER = re.compile(r"-?\d*\.?\d+(?:e[-+]?\d+)?", re.IGNORECASE)


def code_leaks(source: Source, tree: Iterable[Path]) -> Iterator[str]:
    """Yield each run of tokens of a solution that stands in a file for students."""
    solutions = [body for cell in source.cells for body in cell.solutions]
    runs = {run for body in solutions for run in token_runs(body)} - _signatures(source)
    told = {r for cell in source.cells if cell.answer or cell.rubric for r in word_runs(cell.text)}
    for path in tree:
        for text in _texts(path):
            for run in sorted(runs.intersection(token_runs(text))):
                yield f"{path.name} holds a part of a solution of {source.name}: {' '.join(run)}"
            for run in sorted(told.intersection(word_runs(text))):
                part = " ".join(run)
                yield f"{path.name} holds a part of a model answer of {source.name}: {part}"


def number_leaks(
    calls: Sequence[Call], answers: Sequence[Values], written: Mapping[str, Set[str]]
) -> Iterator[str]:
    """Yield each file for students with a number of a hidden input, or of the answer to one.

    Parameters
    ----------
    calls, answers : sequence
        Hidden inputs, and the right answers.
    written : mapping
        What `long_numbers` finds in the files, by their names.
    """
    arrays = [np.asarray(a, dtype=float) for call in calls for a in call.arguments]
    secret = _long([*arrays, *(v for values in answers for v in values)])
    for name, numbers in written.items():
        if found := numbers & secret:
            yield f"{name} holds a number of a hidden case: {min(found)}"


def long_numbers(text: str) -> set[str]:
    """Return the numbers in a text with all the digits that it has of them, up to twelve.

    Examples
    --------
    >>> sorted(long_numbers("1.5, 0.12345678901 and -12.34567890123456"))
    ['-12.3456789012', '0.12345678901']
    """
    return {
        _digits(float(number), min(count, MOST_SIGNIFICANT))
        for number in LONG_NUMBER.findall(text)
        if (count := _significant(number)) >= SIGNIFICANT
    }


def _signatures(source: Source) -> set[tuple[str, ...]]:
    """Return the runs in the first lines of the functions asked for, which everybody may call."""
    cells = source.answer_cells().values()
    lines = (line for cell in cells for line in cell.text.splitlines() if line.startswith("def "))
    return {run for line in lines for run in token_runs(line)}


def token_runs(text: str) -> set[tuple[str, ...]]:
    r"""Return all runs of so many tokens; comments, line ends and indents do not count.

    Examples
    --------
    >>> min(len(run) for run in token_runs("x = np.linalg.solve(a + b, c)"))
    8
    >>> " ".join(min(token_runs("f(np.linalg.solve(a, b),  # so\n  c)")))
    '( a , b ) , c )'
    """
    tokens = list(_tokens(text))
    return {tuple(tokens[i : i + RUN]) for i in range(len(tokens) - RUN + 1)}


SPACE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
    tokenize.STRING,
}


def _tokens(text: str) -> Iterator[str]:
    """Yield the tokens of code, as far as it is code; names and their attributes as one."""
    name = ""
    try:
        for token in tokenize.generate_tokens(io.StringIO(_dedented(text)).readline):
            part = token.string
            joins = part == "." or (part.isidentifier() and not keyword.iskeyword(part))
            if name and joins and (part == "." or name.endswith(".")):
                name += part
                continue
            if name:
                yield name
                name = ""
            if part.isidentifier() and not keyword.iskeyword(part):
                name = part
            elif token.type not in SPACE:
                yield part
    except (tokenize.TokenError, IndentationError, SyntaxError):
        return


def _dedented(text: str) -> str:
    lines = text.splitlines()
    indents = [len(line) - len(line.lstrip()) for line in lines if line.strip()]
    return "\n".join(line[min(indents, default=0) :] for line in lines) + "\n"


def _texts(path: Path) -> Iterator[str]:
    """Yield the texts of a file: cells and outputs of a notebook, strings of code and of JSON."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        for cell in json.loads(text)["cells"]:
            yield "".join(cell["source"])
            yield from _strings(cell.get("outputs", []))
    elif path.suffix == ".json":
        yield from _strings(json.loads(text))
    elif path.suffix == ".py":
        yield text
        constants = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant))
        yield from (node.value for node in constants if isinstance(node.value, str))
    else:
        yield text


def _strings(data: object) -> Iterator[str]:
    if isinstance(data, str):
        yield data
    elif isinstance(data, dict):
        for value in data.values():
            yield from _strings(value)
    elif isinstance(data, list):
        for value in data:
            yield from _strings(value)


def word_runs(text: str) -> set[tuple[str, ...]]:
    """Return all runs of so many words."""
    words = text.split()
    return {tuple(words[i : i + WORDS]) for i in range(len(words) - WORDS + 1)}


def _long(arrays: Iterable[np.ndarray]) -> set[str]:
    """Return the numbers that need all of the digits; short ones, as 0.5, are no secret."""
    numbers = {float(x) for array in arrays for x in np.ravel(array)}
    secret = [x for x in numbers if np.isfinite(x) and float(f"{x:.6g}") != x]
    return {_digits(x, k) for x in secret for k in range(SIGNIFICANT, MOST_SIGNIFICANT + 1)}


def _digits(x: float, count: int) -> str:
    return f"{x:.{count}g}"


def _significant(number: str) -> int:
    return len(number.lower().partition("e")[0].replace(".", "").lstrip("-0"))
