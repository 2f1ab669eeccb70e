"""Typing errors in chapters are found with file and line, and right chapters have none."""

import pytest

from checkout import ROOT
from fieldreport import experiments
from fieldreport.build.chapter_checks import errors_in

BOOK = "% the works\n@book{a2000,\n  title = {A}\n}\n@article{b:2001, title = {B}}\n"
QUOTABLE = {"waves": {"params.points", "error"}, "new": {"params.seed"}}
RIGHT = """# Waves {#sec:waves}

The error is {{waves.error:.1e}} with {{waves.params.points}} points [@a2000, p. 3; @b:2001],
as $\\frac{a}{{b}c}$ in @sec:waves and [-@eq:one], told by a@b.org.
This is code: `{{ shown }}` and `# no heading`.
The fact {{new.fact}} is not computed yet.

$$ x $$ {#eq:one}

``` {.python #lst:a caption="With `code` in it."}
# a comment, {{ waves }} and @nobody
```

::: {.result #tbl:errors
     experiment=waves}
:::: exercise
Why?
::::
:::
"""
WRONG = {
    "a bad byte": (b"text\n\xff\n", "7: the byte 0xff is not UTF-8"),
    "a placeholder with spaces": (b"{{ waves.error }}", "6: not of the form {{experiment.fact"),
    "a fact without its experiment": (b"{{error}}", "6: not of the form {{experiment.fact"),
    "an unknown fact": (b"{{waves.erorr}}", "6: waves has no fact erorr"),
    "an unknown parameter": (
        b"{{waves.params.point}}",
        "6: no parameter of waves 'point'; did you mean points?",
    ),
    "an unknown experiment": (b"{{wave.error}}", "6: no experiment 'wave'; did you mean waves?"),
    "an unknown work": (b"As in [see @a2001].", "6: references.bib has no work with the key a2001"),
    "an unknown label": (b"\nSee @sec:wave.", "7: reference to the unknown label @sec:wave"),
    "code without an end": (b"~~~ {.python}\nx = 1\n", "6: this block of code has no end: ~~~"),
    "a block without an end": (b"::: exercise\n", "6: this block has no end: :::"),
    "an end without a block": (b":::", "6: these colons end no block"),
    "a second heading": (b"\n# Again\n", "7: a second heading of the first level; the chapter has"),
}


def found(folder, content):
    (folder / "chapters").mkdir()
    chapter, references = folder / "chapters" / "01-waves.md", folder / "references.bib"
    chapter.write_bytes(content)
    references.write_text(BOOK)
    return list(errors_in([chapter], references, QUOTABLE))


def test_a_right_chapter_has_no_error(tmp_path):
    """Code, e-mail addresses and braces of TeX are no errors, and no fact that is not known yet."""
    assert found(tmp_path, RIGHT.encode()) == []


@pytest.mark.parametrize("what", WRONG)
def test_each_error_has_its_file_and_line(tmp_path, what):
    """The chapter has five lines before the error, and no other error."""
    wrong, words = WRONG[what]
    (message,) = found(tmp_path, b"# Waves\n\nText.\n\n\n" + wrong + b"\n")
    assert message.startswith(f"chapters/01-waves.md:{words}")


def test_a_chapter_without_heading_is_an_error(tmp_path):
    (message,) = found(tmp_path, b"## Waves\n")
    assert message == "chapters/01-waves.md:1: the chapter has no heading of the first level"


def test_the_chapters_of_the_report_have_no_error():
    """Facts are known after a build only; everything else is known here."""
    chapters = sorted((ROOT / "report" / "chapters").glob("*.md"))
    quotable = {
        name: {f"params.{field}" for field in experiments.get(name).meanings}
        for name in experiments.names()
    }
    assert list(errors_in(chapters, ROOT / "report" / "references.bib", quotable)) == []
