"""Docstrings as reStructuredText: formulas in plain text keep their characters.

A docstring says |x - y| and (x)_+ as one reads them; reStructuredText takes these for markup.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

SPAN = re.compile(r"``.*?``|`[^`]*`_?")
MARKUP = re.compile(r"[|*\\]|_(?!\w)|(?<!\w)_(?=\w)")


def escaped(lines: list[str]) -> list[str]:
    """Return the lines with a backslash before each character that is not meant as markup."""
    out, in_code = [], False
    for line in lines:
        in_code = line.lstrip().startswith(">>>") or (in_code and bool(line.strip()))
        out.append(line if in_code or is_parameter(line) else escaped_line(line))
    return out


def is_parameter(line: str) -> bool:
    """Tell whether the line names arguments such as ``*solids``, which numpydoc escapes itself."""
    return bool(re.match(r"\s*\*{1,2}\w+(\s*:.*)?$", line))


def escaped_line(line: str) -> str:
    """Escape a line, except for what stands in backticks."""
    out, end = [], 0
    for span in SPAN.finditer(line):
        out += [escaped_text(line[end : span.start()]), span[0]]
        end = span.end()
    return "".join([*out, escaped_text(line[end:])])


def escaped_text(text: str) -> str:
    """Escape what reStructuredText takes for a substitution, emphasis or a reference."""
    return MARKUP.sub(r"\\\g<0>", text)


def process(
    _app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list
) -> None:
    """Escape a docstring before numpydoc reads its sections."""
    lines[:] = escaped(lines)


def setup(app: Sphinx) -> dict:
    """Register with Sphinx; a lower priority comes first, and numpydoc has 500."""
    app.connect("autodoc-process-docstring", process, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
