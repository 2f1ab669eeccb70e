"""Typing errors in the chapters, each with its file and line, before anything is computed.

The filters of pandoc find them, too, but only after all experiments have run, and pandoc itself
names neither file nor line.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fieldreport.framework.names import no_such

KINDS = "sec|app|fig|tbl|eq|lst|thm|lem|def|prop|cor|rem|exm|exr"
"""Kinds of labels in the chapters; every other ``@key`` is a citation."""
FENCE = re.compile(r"\s*(`{3,}|~{3,})(\s*\{.*|[^`]*)$")
DIV = re.compile(r"\s*:{3,}\s*([^:\s].*)?$")
UNDERLINE = re.compile(r"(=+|-+)\s*$")
IN_PARAGRAPH = r"(?:(?!\n[ \t]*\n).)"
"""A character of a paragraph: none of an empty line."""
SKIPPED = re.compile(
    rf"\\.|(?P<comment><!--.*?-->)"
    rf"|(?<!`)(?P<code>`+)(?!`){IN_PARAGRAPH}+?(?<!`)(?P=code)(?!`)",
    re.S,
)
FORMULA = re.compile(
    rf"\\.|\$\${IN_PARAGRAPH}+?\$\$|(?P<half>\$\$)"
    rf"|\$(?!\s)(?:\\.|(?!\$){IN_PARAGRAPH})*?(?<!\s)\$(?!\d)",
    re.S,
)
"""Also an escaped character, and the mark of a displayed formula without another one."""
PLACEHOLDER = re.compile(r"\{\{([^{}]*)\}\}")
HALF = re.compile(r"\{\{[^}\s]*|[^{\s]*\}\}")
HALF_OF_KNOWN = re.compile(r"\{\{(\w+)\.[\w.:+%]*")
QUOTED = re.compile(r"(\w+)\.(params\.)?(\w+)(?::(.*))?")
FORMAT = re.compile(r"\+?(\.\d+)?[defg%]?")
"""As ``parse`` in ``values.lua`` reads it."""
DEFINED = re.compile(rf"#((?:{KINDS}):[\w-]+)")
OURS = re.compile(rf"(?:{KINDS}):.*")
REFERENCE = re.compile(r"(?<![\w.@/])@(?:\{([^{}\s]+)\}|(\w[\w:-]*\w))")
NOTE = re.compile(r"\[\^([^\s\]^]+)\]")
NOTE_TEXT = re.compile(r"^ {0,3}\[\^([^\s\]^]+)\]:", re.M)
ENVIRONMENT = re.compile(
    r"\\begin\{((?:align|alignat|eqnarray|equation|flalign|gather|multline)\*?)\}"
)
"""Those of LaTeX that stand for a whole formula."""
PICTURE = re.compile(r"\]\(([\w-]+)\.svg\)")
RESULT = re.compile(r'^[ \t]*:{3,}[ \t]*\{(?=[^}"]*\.result\b)((?:[^{}"]|"[^"]*")*)\}', re.M)
ATTRIBUTE = re.compile(r'\b([\w-]+)=(?:"([^"]*)"|([^\s"{}]+))')
ENTRY = re.compile(r"^@\w+\{([^,\s]+),", re.M)
HIDDEN = "\0"
"""Stands for a character of code or of a formula, which is not checked."""

Lines = list[tuple[int, str]]


@dataclass(frozen=True)
class Quotable:
    """What a chapter may show of the experiments.

    Parameters
    ----------
    values : mapping
        For each experiment its parameters, as ``params.NAME``, and its facts; without any fact if
        they are not known yet.
    tables : mapping
        For each experiment whose result is known its tables, with their columns.
    figures : set of str
        The figures that the experiments draw.
    """

    values: Mapping[str, set[str]]
    tables: Mapping[str, Mapping[str, Sequence[str]]]
    figures: set[str]


@dataclass(frozen=True)
class Names:
    """What a chapter may name.

    Parameters
    ----------
    quotable : Quotable
        What the experiments have.
    keys : set of str
        The keys of the works in ``references.bib``.
    labels : set of str
        The labels that the chapters define.
    notes : set of str
        The names of the footnotes that have a text.
    """

    quotable: Quotable
    keys: set[str]
    labels: set[str]
    notes: set[str]


def errors_in(chapters: list[Path], references: Path, quotable: Quotable) -> Iterator[str]:
    """Yield the typing errors of the chapters: ``chapters/01-a.md:12: ...``.

    Found are bytes that are not UTF-8; blocks, comments and formulas without an end; missing,
    repeated and underlined headings; quoted facts of the wrong form, with a wrong format or with an
    unknown name; unknown figures, tables and columns; unknown labels, footnotes without a text, and
    citations of unknown works; environments of TeX that are refused.
    """
    texts = {path: path.read_bytes() for path in chapters}
    all_text = "\n".join(map(_as_text, texts.values()))
    keys = set(ENTRY.findall(_as_text(references.read_bytes())))
    labels, notes = set(DEFINED.findall(all_text)), set(NOTE_TEXT.findall(all_text))
    names = Names(quotable, keys, labels, notes)
    for path, text in texts.items():
        for number, message in sorted(_errors_of(text, names)):
            yield f"{path.parent.name}/{path.name}:{number}: {message}"


def _as_text(content: bytes) -> str:
    return content.decode("utf-8", "replace")


def _errors_of(content: bytes, names: Names) -> Iterator[tuple[int, str]]:
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        number = content[: error.start].count(b"\n") + 1
        yield number, f"the byte 0x{content[error.start]:02x} is not UTF-8"
        return
    prose, unclosed = _without_code(text)
    yield from unclosed
    plain = SKIPPED.sub(_without, prose)
    words = FORMULA.sub(lambda found: found["half"] or _hidden(found), plain)
    lines = _numbered(plain)
    yield from _unclosed_comment(plain)
    yield from _unclosed_divs(lines)
    yield from _headings(lines)
    yield from _unclosed_formulas(words)
    yield from _wrong_results(plain, names.quotable)
    for number, line in lines:
        yield from ((number, message) for message in _wrong_quotations(line, names.quotable))
        yield from ((number, message) for message in _unknown_figures(line, names.quotable))
        yield from ((number, message) for message in _refused_environments(line))
    for number, line in _numbered(words):
        yield from ((number, message) for message in _half_quotations(line, names.quotable))
        yield from ((number, message) for message in _unknown_references(line, names))


def _numbered(text: str) -> Lines:
    return list(enumerate(text.split("\n"), 1))


def _line_of(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def _without(found: re.Match[str]) -> str:
    """Return a comment as spaces, code as hidden characters, an escaped character as it is."""
    if found["comment"]:
        return re.sub(r"[^\n]", " ", found[0])
    return _hidden(found) if found["code"] else found[0]


def _hidden(found: re.Match[str]) -> str:
    return re.sub(r"[^\n]", HIDDEN, found[0])


def _without_code(text: str) -> tuple[str, Lines]:
    """Return the text with empty lines for blocks of code, and the error of one without an end."""
    prose: list[str] = []
    fence, begun = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        found = FENCE.match(line)
        if fence:
            if found and found[1].startswith(fence) and not found[2].strip():
                fence = ""
        elif found:
            fence, begun = found[1], number
        else:
            prose.append(line)
            continue
        prose.append("")
    unclosed = [(begun, f"this block of code has no end: {fence}")] if fence else []
    return "\n".join(prose), unclosed


def _unclosed_comment(plain: str) -> Iterator[tuple[int, str]]:
    if (start := plain.find("<!--")) >= 0:
        yield _line_of(plain, start), "this comment has no end: <!--"


def _unclosed_formulas(words: str) -> Iterator[tuple[int, str]]:
    """Yield the marks of displayed formulas that are left: each is one without the other."""
    for mark in re.finditer(r"\$\$", words):
        yield (
            _line_of(words, mark.start()),
            "this formula has no end, or no beginning, in its paragraph: $$",
        )


def _unclosed_divs(prose: Lines) -> Iterator[tuple[int, str]]:
    opened: list[int] = []
    for number, line in prose:
        if found := DIV.match(line):
            if found[1]:
                opened.append(number)
            elif opened:
                opened.pop()
            else:
                yield number, "these colons end no block"
    yield from ((number, "this block has no end: :::") for number in opened)


def _headings(prose: Lines) -> Iterator[tuple[int, str]]:
    first, *more = [number for number, line in prose if line.startswith("# ")] or [0]
    if not first:
        yield 1, "the chapter has no heading of the first level"
    for number in more:
        yield number, f"a second heading of the first level; the chapter has one in line {first}"
    yield from _underlined_headings([line for _, line in prose])


def _underlined_headings(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the headings that are underlined: single lines above a line of = or -.

    A line of - below an empty line begins a table of several lines, which ends with another one.
    """
    in_table = False
    for k, (over, title, line, under) in enumerate(
        zip(["", "", *lines], ["", *lines], lines, [*lines[1:], ""], strict=False)
    ):
        if not UNDERLINE.match(line):
            continue
        if line.startswith("-") and (in_table or not title.strip()):
            in_table = not in_table and bool(under.strip())
        elif title.strip() and _ends_block(over) and not _ends_block(title):
            sign = "#" if line.startswith("=") else "##"
            yield k, f"an underlined heading; write {sign} {title.replace(HIDDEN, '').strip()}"


def _ends_block(line: str) -> bool:
    """Whether a new block may begin below a line."""
    return not line.strip() or line.startswith("#") or DIV.match(line) is not None


def _wrong_quotations(line: str, quotable: Quotable) -> Iterator[str]:
    for inside in PLACEHOLDER.findall(line):
        found = QUOTED.fullmatch(inside)
        if not found:
            yield f"not of the form {{{{experiment.fact:format}}}}: {{{{{inside}}}}}"
            continue
        experiment, params, name, form = found.groups()
        if form and not FORMAT.fullmatch(form):
            yield f"{form!r} is no format [+][.digits][d e f g %]: {{{{{inside}}}}}"
        known = quotable.values.get(experiment)
        if known is None:
            yield no_such("experiment", experiment, sorted(quotable.values))
        elif params and params + name not in known:
            its = sorted(n.removeprefix(params) for n in known if n.startswith(params))
            yield no_such(f"parameter of {experiment}", name, its)
        elif not params and (facts := [n for n in known if "." not in n]) and name not in facts:
            yield f"{experiment} has no fact {name}"
    for half in HALF_OF_KNOWN.finditer(PLACEHOLDER.sub(" ", line)):
        if half[1] in quotable.values:
            yield f"no }}}} on the line of {half[0]}"


def _half_quotations(words: str, quotable: Quotable) -> Iterator[str]:
    """Yield the half placeholders outside formulas, where such braces have another meaning.

    Those that name an experiment are found within formulas, too, and told already.
    """
    for half in HALF.findall(PLACEHOLDER.sub(" ", words)):
        named = HALF_OF_KNOWN.match(half)
        if not (named and named[1] in quotable.values):
            missing = "}}" if half.startswith("{{") else "{{"
            yield f"no {missing} on the line of {half.replace(HIDDEN, '')}"


def _unknown_figures(line: str, quotable: Quotable) -> Iterator[str]:
    for figure in PICTURE.findall(line):
        if figure not in quotable.figures:
            yield f"no experiment draws the figure {figure}.svg"


def _wrong_results(plain: str, quotable: Quotable) -> Iterator[tuple[int, str]]:
    """Yield what is wrong in the tables of results: names and formats."""
    for block in RESULT.finditer(plain):
        attributes = {
            found[1]: (found[2] or found[3] or "", block.start(1) + found.start())
            for found in ATTRIBUTE.finditer(block[1])
        }
        experiment, table, columns, formats = (
            attributes.get(name, ("", 0))[0]
            for name in ("experiment", "table", "columns", "formats")
        )
        tables = quotable.tables.get(experiment)
        wrong = {
            "experiment": _wrong_name("experiment", [experiment], quotable.values),
            "table": _wrong_name(f"table of {experiment}", [table], tables),
            "columns": _wrong_name("column", _split(columns), (tables or {}).get(table)),
            "formats": [
                f"{form!r} is no format [+][.digits][d e f g %]"
                for form in _split(formats)
                if not FORMAT.fullmatch(form)
            ],
        }
        for name, (_, position) in attributes.items():
            for message in wrong.get(name, []):
                yield _line_of(plain, position), message


def _split(text: str) -> list[str]:
    return [" ".join(part.split()) for part in text.split(";")]


def _wrong_name(kind: str, names: list[str], known: Collection[str] | None) -> list[str]:
    """Return the messages about unknown names; none if nothing is known."""
    if known is None:
        return []
    return [no_such(kind, name, sorted(known)) for name in names if name not in known]


def _refused_environments(line: str) -> Iterator[str]:
    for name in ENVIRONMENT.findall(line):
        yield f"\\begin{{{name}}} is refused; write aligned, cases or bmatrix inside $$"


def _unknown_references(words: str, names: Names) -> Iterator[str]:
    for braced, bare in REFERENCE.findall(words):
        key = braced or bare
        if OURS.fullmatch(key):
            if key not in names.labels:
                yield f"reference to the unknown label @{key}"
        elif key not in names.keys:
            yield f"references.bib has no work with the key {key}"
    for note in NOTE.findall(words):
        if note not in names.notes:
            yield f"the footnote [^{note}] has no text; write it in a paragraph [^{note}]: …"
