"""Typing errors in the chapters, each with its file and line, before anything is computed.

The filters of pandoc find them, too, but only after all experiments have run, and pandoc itself
names neither file nor line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from fieldreport.framework.names import no_such

KINDS = "sec|app|fig|tbl|eq|lst|thm|lem|def|prop|cor|rem|exm|exr"
"""Kinds of labels in the chapters; every other ``@key`` is a citation."""
FENCE = re.compile(r"\s*(`{3,}|~{3,})(\s*\{.*|[^`]*)$")
DIV = re.compile(r"\s*:{3,}\s*([^:\s].*)?$")
CODE = re.compile(r"(`+).+?\1")
PLACEHOLDER = re.compile(r"\{\{([^{}]*)\}\}")
QUOTED = re.compile(r"(\w+)\.(params\.)?(\w+)(:.*)?")
DEFINED = re.compile(rf"#((?:{KINDS}):[\w-]+)")
OURS = re.compile(rf"(?:{KINDS}):.*")
REFERENCE = re.compile(r"(?<![\w.@/])@(\w[\w:-]*\w)")
ENTRY = re.compile(r"^@\w+\{([^,\s]+),", re.M)

Lines = list[tuple[int, str]]


@dataclass(frozen=True)
class Names:
    """What a chapter may name.

    Parameters
    ----------
    quotable : mapping
        For each experiment its parameters, as ``params.NAME``, and its facts; without any fact if
        they are not known yet.
    keys : set of str
        The keys of the works in ``references.bib``.
    labels : set of str
        The labels that the chapters define.
    """

    quotable: Mapping[str, set[str]]
    keys: set[str]
    labels: set[str]


def errors_in(
    chapters: list[Path], references: Path, quotable: Mapping[str, set[str]]
) -> Iterator[str]:
    """Yield the typing errors of the chapters: ``chapters/01-a.md:12: ...``.

    Found are bytes that are not UTF-8, blocks without an end, missing or repeated headings of the
    first level, quoted facts of the wrong form or with an unknown name, unknown labels, and
    citations of unknown works.
    """
    texts = {path: path.read_bytes() for path in chapters}
    labels = {label for text in texts.values() for label in DEFINED.findall(_as_text(text))}
    keys = set(ENTRY.findall(_as_text(references.read_bytes())))
    names = Names(quotable, keys, labels)
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
    yield from _unclosed_divs(prose)
    yield from _headings(prose)
    for number, line in prose:
        plain = CODE.sub("", line)
        yield from ((number, message) for message in _wrong_quotations(plain, names))
        yield from ((number, message) for message in _unknown_references(plain, names))


def _without_code(text: str) -> tuple[Lines, Lines]:
    """Return the numbered lines outside blocks of code, and the error of a block without an end."""
    prose: Lines = []
    fence, begun = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        found = FENCE.match(line)
        if fence:
            if found and found[1].startswith(fence) and not found[2].strip():
                fence = ""
        elif found:
            fence, begun = found[1], number
        else:
            prose.append((number, line))
    return prose, [(begun, f"this block of code has no end: {fence}")] if fence else []


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


def _wrong_quotations(line: str, names: Names) -> Iterator[str]:
    for inside in PLACEHOLDER.findall(line):
        found = QUOTED.fullmatch(inside)
        if not found:
            yield f"not of the form {{{{experiment.fact:format}}}}: {{{{{inside}}}}}"
            continue
        experiment, params, name, _ = found.groups()
        known = names.quotable.get(experiment)
        if known is None:
            yield no_such("experiment", experiment, sorted(names.quotable))
        elif params and params + name not in known:
            its = sorted(n.removeprefix(params) for n in known if n.startswith(params))
            yield no_such(f"parameter of {experiment}", name, its)
        elif not params and (facts := [n for n in known if "." not in n]) and name not in facts:
            yield f"{experiment} has no fact {name}"


def _unknown_references(line: str, names: Names) -> Iterator[str]:
    for key in REFERENCE.findall(line):
        if OURS.fullmatch(key):
            if key not in names.labels:
                yield f"reference to the unknown label @{key}"
        elif key not in names.keys:
            yield f"references.bib has no work with the key {key}"
