"""Rules for chapters: no computed result is typed, and the bibliography is complete."""

import re

from report_fixtures import REPORT

CHAPTERS = sorted((REPORT / "chapters").glob("*.md"))
ALLOWED: set[str] = set()
"""Decimals in prose that are not results, such as the version of a standard."""


def decimals_in_prose(text):
    """Return the decimals outside quoted facts, mathematics, code and attributes."""
    for hidden in (
        r"```.*?```",
        r"`[^`]*`",
        r"\{\{.*?\}\}",
        r"\$\$.*?\$\$",
        r"\$[^$]*\$",
        r"\{[#.][^}]*\}",
        r"\]\([^)]*\)",
    ):
        text = re.sub(hidden, " ", text, flags=re.S)
    return re.findall(r"(?<![\w.])\d+\.\d+(?:e[-+]?\d+)?", text)


def test_chapters_contain_no_typed_results():
    """A decimal in prose is quoted from an experiment or listed in ALLOWED."""
    typed = {p.name: set(decimals_in_prose(p.read_text("utf-8"))) - ALLOWED for p in CHAPTERS}
    assert {name: found for name, found in typed.items() if found} == {}


def test_a_typed_result_is_found():
    """The search finds a decimal in prose, in a caption and in a table cell, and nothing else."""
    text = 'It is 0.25, $x = 1.5$, {{a.b:.2f}}, `1.5`.\n\n![Of 3.5 m.](a.svg){#fig:a alt="0.1"}\n\n'
    assert decimals_in_prose(text + "| 1e3 | 7.5e-3 |\n\n$$ 2.5 $$\n") == ["0.25", "3.5", "7.5e-3"]


MANNERISMS = re.compile(
    r"\b(?:comes? back|came back|errs|(?:is|are) told|can be had)\b|(?:^|[.:] )Who(?:ever)? [a-z]",
    re.M,
)
"""For these the field has words: is reproduced, has an error of, is reported, is available."""


def test_chapters_use_the_words_of_the_field():
    found = {p.name: MANNERISMS.findall(p.read_text("utf-8")) for p in CHAPTERS}
    assert {name: phrases for name, phrases in found.items() if phrases} == {}


def test_a_mannerism_is_found():
    """It is found at the beginning of a line and within a sentence, and in no longer word."""
    text = "Who has two meshes\nknows that fields come back. It errs. Errors are reported.\n"
    assert MANNERISMS.findall(text) == ["Who h", "come back", "errs"]


def test_every_chapter_begins_with_its_heading():
    """Each file has one first-level heading, with a label."""
    for path in CHAPTERS:
        text = re.sub(r"```.*?```", "", path.read_text("utf-8"), flags=re.S)
        headings = re.findall(r"^# .*", text, re.M)
        assert len(headings) == 1, path.name
        assert re.search(r"\{#(sec|app):\w+", headings[0]), path.name
        assert text.startswith("# "), path.name


def test_the_bibliography_is_complete_sorted_and_without_duplicates():
    """Each entry has an author, a title, and a key that ends with the year."""
    entries = re.findall(
        r"^@\w+\{(\w+),(.*?)^\}", (REPORT / "references.bib").read_text(), re.S | re.M
    )
    keys = [key for key, _ in entries]
    assert keys == sorted(set(keys))
    for key, fields in entries:
        assert re.search(r"\bauthor = ", fields), key
        assert re.search(r"\btitle = ", fields), key
        year = re.search(r"\byear = \{(\d+)\}", fields)
        assert year is None or key.endswith(year.group(1)), key
