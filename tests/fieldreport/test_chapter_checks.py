"""Typing errors in chapters are found with file and line, and right chapters have none."""

import pytest

from checkout import ROOT
from fieldreport import experiments
from fieldreport.build.chapter_checks import Quotable, errors_in

BOOK = "% the works\n@book{a2000,\n  title = {A}\n}\n@article{b:2001, title = {B}}\n"
QUOTABLE = Quotable(
    values={"waves": {"params.points", "error"}, "new": {"params.seed"}},
    tables={"waves": {"errors": ("n", "error, rms [m]")}},
    figures={"waves", "waves_far"},
)
RIGHT = """# Waves {#sec:waves}

The error is {{waves.error:.1e}} with {{waves.params.points}} points [@a2000, p. 3; @b:2001],
as $\\frac{a}{{b}c}$ in @sec:waves and [-@eq:one], told by a@b.org, not \\@nobody.
This is code: `{{ shown }}` and `# no heading`, ``<!-- ` {{``, `$$`, `[^none]`, `@{none}` and `of
two lines }}`. It costs \\$$x$ {{waves.error:d}} at \\$5, with $a$$b_{c_{d}}$ and [@{a2000}].[^why]
The fact {{new.fact}} is not computed yet.

$$ x^{{{waves.error:+.2%}}} = \\mathbf{y_{i_{j}}},
\\begin{aligned} a &= [^2_1] \\end{aligned} $$ {#eq:one}

[^why]: A note <!-- {{ `@nobody and $$ of

# no heading --> with an end.

![The waves, $a_{\\mathbf{b}}$.](waves_far.svg){#fig:far alt="A wave of $a_{\\mathbf{b}}$."}

Two lines
of text
---

---

-----------
A     table
of    lines

one   more
-----------

``` {.python #lst:a caption="With `code` in it."}
# a comment, {{ waves }} and @nobody
{{ $$ <!-- [^none] @{none} \\begin{align}
Title
=====
```

::: {.result #tbl:errors
     experiment=waves table=errors
     columns="error, rms [m]; n" heads="$e_{\\mathbf{r}}$; n" formats=".1e; "}
:::: exercise
Why?
::::
:::
"""
RESULT = b"\n::: {.result #tbl:a %s}\nThe errors.\n:::"
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
    "a format that is none": (b"{{waves.error:.xx}}", "6: '.xx' is no format [+][.digits]"),
    "a format of spaces": (b"{{waves.error: .1e}}", "6: ' .1e' is no format [+][.digits]"),
    "a placeholder without an end": (b"{{waves.error", "6: no }} on the line of {{waves.error"),
    "a placeholder of two lines": (b"{{wave.\nerror", "6: no }} on the line of {{wave."),
    "a placeholder without an end in a formula": (
        b"$x = {{waves.error$",
        "6: no }} on the line of {{waves.error",
    ),
    "a placeholder without a beginning": (
        b"It is waves.error}} today.",
        "6: no {{ on the line of waves.error}}",
    ),
    "an underlined heading": (b"Second\n=====\n", "6: an underlined heading; write # Second"),
    "an underlined section": (b"Second\n-----\n", "6: an underlined heading; write ## Second"),
    "a formula without an end": (
        b"where $$ x = 1 and $y$\n\n$$ z $$\n",
        "6: this formula has no end, or no beginning, in its paragraph: $$",
    ),
    "a formula without a beginning": (
        b"$$ z $$\nthen x $$\n",
        "7: this formula has no end, or no beginning, in its paragraph: $$",
    ),
    "a comment without an end": (b"a <!-- b --> <!-- c", "6: this comment has no end: <!--"),
    "a footnote without a text": (b"So it is.[^one]", "6: the footnote [^one] has no text; write"),
    "an unknown work in braces": (
        b"As in [see @{a2001}].",
        "6: references.bib has no work with the key a2001",
    ),
    "an unknown label in braces": (b"See @{sec:wave}.", "6: reference to the unknown label @sec:"),
    "an environment": (
        b"\\begin{align*}\nx\n\\end{align*}",
        "6: \\begin{align*} is refused; write aligned, cases or bmatrix inside $$",
    ),
    "an environment in a formula": (
        b"$$\n\\begin{align} x \\end{align}\n$$",
        "7: \\begin{align} is refused; write aligned, cases or bmatrix inside $$",
    ),
    "an unknown figure": (
        b"![Far,\nfar.](wave.svg){#fig:a}",
        "7: no experiment draws the figure wave.svg",
    ),
    "a table of an unknown experiment": (
        RESULT % b"experiment=wave table=errors",
        "7: no experiment 'wave'; did you mean waves?",
    ),
    "an unknown table": (
        RESULT % b"experiment=waves\n  table=error",
        "8: no table of waves 'error'; did you mean errors?",
    ),
    "an unknown column": (
        RESULT % b'experiment=waves table=errors\ncolumns="n; m"',
        "8: no column 'm'; there are error, rms [m], n",
    ),
    "a wrong format in a table": (
        RESULT % b'experiment=waves table=errors formats=".1e; 3f"',
        "7: '3f' is no format [+][.digits][d e f g %]",
    ),
    "a second heading": (b"\n# Again\n", "7: a second heading of the first level; the chapter has"),
}


def found(folder, content):
    (folder / "chapters").mkdir()
    chapter, references = folder / "chapters" / "01-waves.md", folder / "references.bib"
    chapter.write_bytes(content)
    references.write_text(BOOK)
    return list(errors_in([chapter], references, QUOTABLE))


def test_a_right_chapter_has_no_error(tmp_path):
    """Code, comments, e-mail addresses, braces of TeX and facts not known yet are no errors."""
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
    """Facts and tables are known after a build only; everything else is known here."""
    chapters = sorted((ROOT / "report" / "chapters").glob("*.md"))
    known = [experiments.get(name) for name in experiments.names()]
    quotable = Quotable(
        values={one.name: {f"params.{field}" for field in one.meanings} for one in known},
        tables={},
        figures={figure for one in known for figure in one.plots},
    )
    assert list(errors_in(chapters, ROOT / "report" / "references.bib", quotable)) == []
