"""The JSON of a notebook without its outputs, found without parsing the file.

A file of 20 MiB can take 1 GiB when it is parsed, and deeply nested data exhaust the stack.
Therefore size, depth and number of elements are limited before, by a scan that needs no memory.
Outputs, pictures in text cells and states of widgets are left out: they can be large, and nothing
in them is graded.
"""

from __future__ import annotations

import re

STRING = rb'"(?:[^"\\]++|\\.)*+"'
TOKEN = re.compile(STRING + rb'|["\[\]{},]', re.DOTALL)
BRACKET = re.compile(STRING + rb'|["\[\]{}]', re.DOTALL)
"""The last alternative finds a quotation mark without its other one."""
LEFT_OUT = {b'"outputs"', b'"attachments"', b'"widgets"'}
LONGEST = 16
TO_VALUE = re.compile(rb"\s*:\s*[\[{]")
OPEN, CLOSED, QUOTE = b"[{", b"]}", ord('"')
MOST_DEPTH = 50
MOST_ELEMENTS = 300_000
MOST_BYTES = 20 << 20
MOST_LEFT_OUT = 4_000_000
"""Strings and brackets of one value that is left out."""


def without_outputs(content: bytes) -> bytes:
    """Return JSON in UTF-8 without the outputs; broken JSON remains broken.

    Examples
    --------
    >>> without_outputs(b'{"cells": [{"outputs": [{"text": "]"}], "source": "x"}]}')
    b'{"cells": [{"outputs": [], "source": "x"}]}'

    Raises
    ------
    ValueError
        A limit is exceeded; the message says which.
    """
    kept: list[bytes] = []
    start = at = depth = elements = 0
    while found := TOKEN.search(content, at):
        begin, at = found.span()
        kind = content[begin]
        elements += 1
        if kind in OPEN:
            depth += 1
        elif kind in CLOSED:
            depth -= 1
        elif kind == QUOTE and at == begin + 1:
            break  # a string without an end: the parser stops here, too
        elif content[begin : min(at, begin + LONGEST)] in LEFT_OUT and (
            value := TO_VALUE.match(content, at)
        ):
            kept.append(content[start : value.end()])
            at = _end_of_value(content, value.end() - 1)
            if not at:
                return b"".join(kept)
            start = at - 1
        if depth > MOST_DEPTH:
            raise ValueError(f"it is nested more than {MOST_DEPTH} levels deep")
        if elements > MOST_ELEMENTS:
            raise ValueError(f"it has more than {MOST_ELEMENTS} elements, outputs not counted")
    if sum(map(len, kept)) + len(content) - start > MOST_BYTES:
        raise ValueError(f"it has more than {MOST_BYTES >> 20} MiB, outputs not counted")
    return b"".join([*kept, content[start:]])


def _end_of_value(content: bytes, begin: int) -> int:
    """Return the end of the array or object that begins here; 0 if it does not end."""
    depth = 0
    for count, found in enumerate(BRACKET.finditer(content, begin)):
        kind = content[found.start()]
        if kind in OPEN:
            depth += 1
        elif kind in CLOSED:
            depth -= 1
        elif found.end() == found.start() + 1:
            return 0
        if not depth:
            return found.end()
        if count > MOST_LEFT_OUT:
            raise ValueError(f"its outputs have more than {MOST_LEFT_OUT} elements")
    return 0
