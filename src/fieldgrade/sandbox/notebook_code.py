"""A cell of a notebook as plain Python: magics and shell commands are translated or removed."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

CELL_MAGIC = re.compile(r"\s*%%(\w*)[ \t]*([^\n]*)")
RUNS_IN_PLACE = ("time", "capture", "prun")
"""Magics that run the code after them in the notebook."""
WRITES_FILE = ("writefile", "file")

TOKEN = re.compile(
    r"""\#[^\n]*
    |\"{3}(?:\\.|[^\\])*?(?:\"{3}|\Z)|'{3}(?:\\.|[^\\])*?(?:'{3}|\Z)
    |"(?:\\.|[^"\\\n])*"?|'(?:\\.|[^'\\\n])*'?
    |\\\n
    |(?P<opens>[(\[{])|(?P<closes>[)\]}])
    |(?P<ends>\n)
    |[^\#"'\\()\[\]{}\n]+|\\""",
    re.VERBOSE | re.DOTALL,
)
"""Pieces of Python by which the end of a logical line is found."""
LINE_MAGIC = re.compile(
    r"(?P<indent>[ \t]*)(?P<target>\w[\w, ]*=[ \t]*)?[%!?](?P<magic>\w*)[ \t]*"
    r"(?P<rest>(?:\\\n|[^\n])*)"
    r"|(?P<help>[ \t]*)%{0,2}[\w.]+\?{1,2}[ \t]*(?=\n|\Z)"
)

FILE = re.compile(r"\"[^\"]*\"|'[^']*'|\S*")


def plain(cell: str) -> str:
    r"""Return a cell as plain Python, with the same numbers of lines.

    Examples
    --------
    >>> plain("%matplotlib inline\nfiles = !ls\nx = 1"), plain("%%time\nx = 1"), plain("%%bash\nls")
    ('pass\nfiles = None\nx = 1', '\nx = 1', '')
    >>> plain("%time x = 7\n!echo \\\n  it's\ny = (x\n  % 2)")
    'x = 7\npass\n\ny = (x\n  % 2)'
    """
    magic = CELL_MAGIC.match(cell)
    if magic and magic[1] in WRITES_FILE:
        return _writing(magic[2], cell[magic.end() + 1 :])
    if magic:
        cell = cell[magic.end() :] if magic[1] in RUNS_IN_PLACE else ""
    return cell if _is_python(cell) else "".join(_lines(cell))


def _is_python(cell: str) -> bool:
    try:
        ast.parse(cell)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return True


def _writing(arguments: str, text: str) -> str:
    """Return code that writes a file, which can be imported at once."""
    words = arguments.split()
    mode = "a" if {"-a", "--append"} & set(words) else "w"
    name = " ".join(w for w in words if w not in ("-a", "--append")).strip("'\"")
    return (
        f"__import__('io').open({name!r}, {mode!r}, encoding='utf-8').write({text!r})\n"
        "__import__('importlib').invalidate_caches()"
    )


def _lines(cell: str) -> Iterator[str]:
    """Yield the logical lines of a cell; a line is a magic only where a logical line begins."""
    start = at = depth = 0
    while at < len(cell):
        magic = LINE_MAGIC.match(cell, at) if at == start else None
        if magic:
            yield _translated(magic)
            start = at = magic.end()
            if cell.startswith("\n", at):
                yield "\n"
                start = at = at + 1
            continue
        token = TOKEN.match(cell, at)
        if token is None:
            break
        at, kind = token.end(), token.lastgroup
        depth = max(0, depth + (kind == "opens") - (kind == "closes"))
        if kind == "ends" and not depth:
            yield cell[start:at]
            start = at
    yield cell[start:]


def _translated(magic: re.Match[str]) -> str:
    """Return Python in place of a magic: what ``%time`` times, a script that ``%run`` runs."""
    if magic["help"] is not None:
        return f"{magic['help']}pass"
    name, rest, target = magic["magic"], magic["rest"].strip(), magic["target"] or ""
    lines = "\n" * magic["rest"].count("\n")
    if magic[0].strip().startswith("!") or not rest:
        name = ""
    if name == "time":
        return f"{magic['indent']}{target}{rest}"
    if name == "run":
        file = _script(rest)
        run = f"exec(compile(__import__('io').open({file!r}).read(), {file!r}, 'exec'))"
        return f"{magic['indent']}{run}{lines}"
    nothing = f"{target}None" if target else "pass"
    return f"{magic['indent']}{nothing}{lines}"


def _script(arguments: str) -> str:
    """Return the file that ``%run`` runs: after its options, and with an ending.

    Examples
    --------
    >>> _script("-i helper one"), _script("'my work.py'")
    ('helper.py', 'my work.py')
    """
    words = (word.strip("'\"") for word in FILE.findall(arguments))
    file = next((word for word in words if word and not word.startswith("-")), "")
    return file if "." in file else f"{file}.py"
