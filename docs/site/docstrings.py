"""Docstrings as reStructuredText: formulas in plain text keep their characters.

A docstring says |x - y| and (x)_+ as one reads them; reStructuredText takes these for markup. A
formula in a line of its own, which is indented, is typeset, and so is one within a sentence.
"""

from __future__ import annotations

import inspect
import re
from typing import TYPE_CHECKING

from formulas import parts, typeset

if TYPE_CHECKING:
    from docutils.nodes import Node
    from sphinx.application import Sphinx

SPAN = re.compile(r"``.*?``|`[^`]*`_?")
MARKUP = re.compile(r"[|*\\]|_(?!\w)|(?<!\w)_(?=\w)")


ENTRY = re.compile(r"\S.* : ")
INDENT = 4
SECTION = re.compile(r"-{3,}$")
PROSE = (None, "Notes")
"""The sections in which what is indented is a formula, and not the meaning of a parameter."""


def with_formulas(lines: list[str]) -> list[str]:
    """Return the lines with displayed formulas as HTML, and the others escaped."""
    out, plain, section = [], [], None
    for k, line in enumerate(lines):
        section = line if k + 1 < len(lines) and SECTION.match(lines[k + 1]) else section
        before = lines[k - 1] if k else ""
        within = out[-1:] == [""] and not plain and bool(before.strip())
        starts = not before.strip() and section in PROSE
        if line.startswith(" " * INDENT) and (starts or within):
            out += [*escaped(plain), *displayed(line.strip())]
            plain = []
        else:
            plain.append(line)
    return [*out, *escaped(plain)]


def displayed(formula: str) -> list[str]:
    """Return the directive that shows a formula."""
    return ["", ".. raw:: html", "", f'   <p class="formula">{typeset(formula)}</p>', ""]


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
    """Mark formulas; escape what reStructuredText takes for markup, except for ``name : type``."""
    if ENTRY.match(text):
        return MARKUP.sub(r"\\\g<0>", text)
    return "".join(
        f":formula:`{part}`" if is_formula else MARKUP.sub(r"\\\g<0>", part)
        for part, is_formula in parts(text)
    )


def formula(
    _role: str, _raw: str, text: str, _line: int, _inliner: object, *_: object
) -> tuple[list[Node], list]:
    """Return the formula of a sentence, typeset."""
    from docutils import nodes  # only the site needs it, the tests of docstrings do not

    return [nodes.raw("", f'<span class="term">{typeset(text)}</span>', format="html")], []


def process(
    _app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list
) -> None:
    """Escape a docstring before numpydoc reads its sections."""
    lines[:] = with_formulas(lines)


def is_described(
    _app: Sphinx, _what: str, _name: str, member: object, _skip: bool, _options: object
) -> bool | None:
    """Leave out the fields of a named tuple, which its docstring lists as attributes."""
    is_field = (inspect.getdoc(member) or "").startswith("Alias for field number")
    return True if is_field else None


OBJECT = re.compile(r"<function (?:\w+\.)*(\w+)>|<class '(?:\w+\.)*(\w+)'>|<factory>")
"""An object as Python prints it."""


def readable(
    _app: Sphinx, _what: str, _name: str, _object: object, _options: object, signature: str, to: str
) -> tuple[str, str] | None:
    """Return a signature whose defaults are the names of functions and classes."""
    if not OBJECT.search(signature or ""):
        return None
    return OBJECT.sub(lambda found: found[1] or found[2] or "...", signature), to


def setup(app: Sphinx) -> dict:
    """Register with Sphinx; a lower priority comes first, and numpydoc has 500."""
    app.add_role("formula", formula)
    app.connect("autodoc-skip-member", is_described)
    app.connect("autodoc-process-signature", readable, priority=400)
    app.connect("autodoc-process-docstring", process, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
