"""The text of the report: numbering in both outputs, quoted facts, and reported errors."""

import html
import json
import re
import shutil

import pytest
import typst

from fieldreport.build.errors import BuildError
from fieldreport.build.typesetting import Document, typeset, unquoted_facts
from fieldreport.build.webfonts import code_points, font_faces
from fieldreport.framework.orders_of_magnitude import OrderOfMagnitude
from report_fixtures import REPORT

VALUES = {
    "bumps": {
        "title": "Bumps",
        "facts": {
            "small": 0.0012,
            "ratio": -2.5,
            "count": 12345,
            "rounding": OrderOfMagnitude(1e-16),
            "one_digit": 9.6e-5,
            "order_one": OrderOfMagnitude(1.0),
            "word": "fine",
            "large": 123456.789,
            "unquoted": 1.0,
        },
        "params": {"points": 1000, "epsilon": 0.00001, "powers": [1, 2, 3, 4, 5, 6, 7, 8]},
        "fields": [
            {"name": "points", "meaning": "number of points"},
            {"name": "epsilon", "meaning": ""},
            {"name": "powers", "meaning": "the powers $n$"},
        ],
        "tables": {
            "errors": {
                "columns": ["n", "error, rms [m]", "exact"],
                "rows": [[1, OrderOfMagnitude(1e-16), "yes"], [2, 0.00123, "no"], [3, -12.5, "no"]],
            }
        },
        "figures": ["bumps", "bumps_far"],
    },
    "other": {
        "title": "Other",
        "facts": {"x": 3},
        "params": {},
        "fields": [],
        "tables": {},
        "figures": [],
    },
}

WHOLE = r"""# First {#sec:first}

See [@fig:bumps; @fig:far], @tbl:errors, @tbl:which, @eq:one, [-@eq:two], @sec:first, @sec:inner,
@app:more, @thm:one, [@exr:one]{.with-page}, @lst:one and [@wendland2005, chapter 8].
The slides of @erleben; @erleben [p. 39]; the slides [@erleben, p. 3-4].

Prose: {{bumps.small:.1e}}, {{bumps.ratio:.1f}}, {{bumps.count}}, {{bumps.rounding:.0e}},
{{bumps.word}}, {{bumps.order_one:.0e}}, {{bumps.one_digit:.0e}},
{{bumps.params.powers}}, {{bumps.large:.1f}},
{{bumps.ratio:.0%}}. Length {{bumps.params.points}} m. Math: $a = {{bumps.small:.1e}}$,
$b = {{bumps.count}}$, $c = {{bumps.rounding:.0e}}$, $d = {{bumps.params.epsilon}}$. Code:
`{{bumps.small:.1e}}`.

$$ \mathbf{B} \mathbf{c} = \nabla \phi $$ {#eq:one}

$$ \bigcap_i \lVert x_i \rVert $$ {#eq:two}

## Inner {#sec:inner}

![Bumps, {{bumps.count}} of them.](bumps.svg){#fig:bumps
alt="Bumps at {{bumps.small:.1e}} < 1 and \"so\" on the left."}

![Bumps far away.](bumps_far.svg){#fig:far alt="Bumps that lie far away to the right."}

::: {.result #tbl:errors experiment=bumps table=errors columns="n; error, rms [m]; exact"
     heads="$n$; *error*; exact" formats="; .1e; " rows="1, 2-2"}
Errors for {{bumps.params.points}} points.
:::

| Case | Method |
|:-----|-------:|
| few  | {{bumps.small:.1e}} |
| many | {{other.x}} |

: Which. {#tbl:which}

::: {.theorem #thm:one title="@micchelli1986"}
It is so.
:::

::: {.exercise #exr:one title="On $x$"}
Show it.
:::

::: solution
Shown.
:::

```{.python #lst:one caption="A sum, `a + b`."}
a + b
```

# More {#app:more .appendix}

$$ x $$ {#eq:three} and @eq:three.

::: parameters
:::

# References {#sec:references .unnumbered}

::: {#refs}
:::
"""

DAMAGE = {
    "a fact that is missing": ("{{bumps.gone:.1f}}", r"01-all.md:\d+: bumps has no fact gone"),
    "a parameter that is missing": ("{{bumps.params.gone}}", "bumps has no parameter gone"),
    "an order of magnitude with digits": (
        "{{bumps.rounding:.1e}}",
        r"an order of magnitude has no digits: write \.0e, not \"\.1e\"",
    ),
    "an experiment that is missing": ("{{gone.x}}", r"there is no experiment for {{gone.x}}"),
    "decimals without a format": (
        "{{bumps.large}}",
        r"needs a format, such as {{bumps.large:.2f}}",
    ),
    "a format that does not fit": ("{{bumps.large:d}}", r'the format "d" does not fit'),
    "a format that is none": ("{{bumps.large:zz}}", r'the format "zz" does not fit'),
    "a text with a format": ("{{bumps.word:.2f}}", "a text has no number format"),
    "a quotation that is none": ("{{bumps large}}", "not of the form"),
    "an unknown label": ("@fig:gone", "reference to the unknown label @fig:gone"),
    "a label given twice": ("$$ x $$ {#eq:one}", "the label eq:one is given twice"),
    "reference and citation together": ("[@fig:far; @franke1982]", "a reference and a citation"),
    "a figure nobody refers to": (
        '![Lone.](bumps.svg){#fig:lone alt="A figure that is all alone here."}',
        "the text never refers to @fig:lone",
    ),
    "a table nobody refers to": (
        "| a |\n|---|\n| b |\n\n: Lone. {#tbl:lone}",
        "the text never refers to @tbl:lone",
    ),
    "a figure without words": (
        "![Mute.](bumps.svg){#fig:mute}\n\n@fig:mute",
        "(fig:mute needs an alternative text|only repeats the caption)",
    ),
    "words that repeat the caption": (
        '![The same words twice over.](bumps.svg){#fig:same alt="The same words twice over."}',
        "fig:same: the alternative text only repeats the caption",
    ),
    "a figure without a label": (
        '![Anonymous.](bumps.svg){alt="A figure that has no label at all."}',
        "every figure needs a label",
    ),
    "a figure nobody draws": (
        '![Gone.](gone.svg){#fig:drawn alt="A figure that nobody has drawn."}',
        "no experiment draws the figure gone.svg",
    ),
    "a table without a caption": ("| a |\n|---|\n| b |", "every table needs a label"),
    "a column that is missing": (
        "::: {.result #tbl:c experiment=bumps table=errors columns=gone}\nC.\n:::",
        'tbl:c: no column "gone"; the table has n; error, rms',
    ),
    "a table that is missing": (
        "::: {.result #tbl:t experiment=bumps table=gone}\nC.\n:::",
        "tbl:t: bumps has no table gone",
    ),
    "rows that are missing": (
        '::: {.result #tbl:r experiment=bumps table=errors rows="2-9"}\nC.\n:::',
        "must lie within 1-3",
    ),
    "a head too few": (
        '::: {.result #tbl:h experiment=bumps table=errors heads="a; b"}\nC.\n:::',
        "tbl:h: as many heads and formats as columns",
    ),
    "raw TeX in a paragraph": (r"so \begin{equation}x\end{equation}", "raw TeX would vanish"),
    "raw TeX by itself": ("\\begin{align}\nx\n\\end{align}", "raw TeX would vanish"),
    "bars that pandoc spoils": (r"$\|x\|_2$", r"instead of \\| write \\lVert"),
    "a matrix with lines": (
        r"$\begin{array}{c|c}1&2\end{array}$",
        "write matrix, cases or aligned",
    ),
}


class Text:
    """Chapters with made-up values, and their conversion."""

    def __init__(self, folder):
        source, out = folder / "text", folder / "out"
        shutil.copytree(REPORT, source, ignore=shutil.ignore_patterns("build", "chapters"))
        (source / "chapters").mkdir()
        drawn = [out / kind / "bumps" for kind in ("experiments", "screen")]
        for name in ("bumps", "bumps_far"):
            svg = '<svg xmlns="http://www.w3.org/2000/svg" width="212.6pt" viewBox="0 0 9 9"></svg>'
            for place in drawn:
                place.mkdir(parents=True, exist_ok=True)
                (place / f"{name}.svg").write_text(svg)
        self.document = Document(source, out)

    def convert(self, chapter):
        (self.document.source / "chapters" / "01-all.md").write_text(chapter)
        text = self.document.convert(VALUES, {"version": "0"})
        return text | {"page": self.document.with_figures(text["page"])}


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    return Text(tmp_path_factory.mktemp("text"))


@pytest.fixture(scope="module")
def outputs(text):
    return text.convert(WHOLE)


@pytest.fixture(scope="module")
def page(outputs):
    return outputs["page"]


@pytest.fixture(scope="module")
def typ(outputs):
    return outputs["print"]


@pytest.fixture(scope="module")
def problems(text):
    """All errors reported for a text with every kind of damage."""
    damaged = WHOLE + "\n\n".join(damage for damage, _ in DAMAGE.values()) + "\n"
    with pytest.raises(BuildError) as caught:
        text.convert(damaged)
    return str(caught.value)


def words(markup):
    """Return the text of HTML, without mathematics."""
    markup = re.sub(r"<(style|script|math)\b.*?</\1>", " ", markup, flags=re.S)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", "", markup)))


@pytest.mark.slow
def test_references_have_the_same_numbers_in_html_and_pdf(page, typ):
    """All kinds of references are tested."""
    in_page = re.findall(r'<a\s+href="#([\w:]+)"\s+class="xref">(.*?)</a>', page, re.S)
    in_print = re.findall(r"#link\(<(\w+:\w+)>\)\[(.*?)\]", typ)
    read = [(label, words(t).replace("\xa0", " ")) for label, t in in_page]
    assert read == [(label, re.sub(r"[~\xa0]", " ", t.replace("\\", ""))) for label, t in in_print]
    assert dict(read) == {
        "fig:bumps": "Figures 1.1",
        "fig:far": "1.2",
        "tbl:errors": "Table 1.1",
        "tbl:which": "Table 1.2",
        "eq:one": "Equation (1.1)",
        "eq:two": "(1.2)",
        "sec:first": "Chapter 1",
        "sec:inner": "Section 1.1",
        "app:more": "Appendix A",
        "thm:one": "Theorem 1.1",
        "exr:one": "Exercise 1.1",
        "lst:one": "Listing 1.1",
        "eq:three": "Equation (A.1)",
    }


@pytest.mark.slow
def test_numbered_elements_show_the_number_of_their_references(page, typ):
    """Captions, equations and headings show their numbers in both outputs."""
    for shown in ("Figure 1.1.", "Figure 1.2.", "Table 1.1.", "Table 1.2.", "Theorem 1.1"):
        assert shown in words(page).replace("\xa0", " ")
        assert shown in typ.replace("~", " ").replace("\xa0", " ")
    for number in ("(1.1)", "(1.2)", "(A.1)"):
        assert f'<span class="eqno">{number}</span>' in page
        assert f"numbering: (..n) => [{number}]" in typ
    assert re.findall(r'<span class="secno">(.*?)</span>', page) == ["1", "1.1", "A"] * 2


def test_a_reference_with_its_page_has_the_page_in_print_only(page, typ):
    """The page number belongs to the target; on the screen the link suffices."""
    assert re.search(r"#link\(<exr:one>\)\[Exercise.1\.1\]\s*#page-of\(<exr:one>\)", typ)
    assert typ.count("#page-of(<exr:one>)") == 1
    assert "page-of" not in page


def test_a_work_without_a_date_is_cited_by_its_author_and_the_page(page):
    text = html.unescape(re.sub(r"<[^>]+>", "", page))
    cited = "slides of Erleben; Erleben (p.\u00a039); the slides (Erleben, p.\u00a03–4)."
    assert cited in re.sub(r"[ \n]+", " ", text)
    assert page.count('href="#ref-erleben"') == 3


def test_internal_links_have_targets(page, typ):
    ids = set(re.findall(r'\bid="([^"]+)"', page))
    assert set(re.findall(r'href="#([^"]+)"', page)) <= ids
    labels = set(re.findall(r"<([\w:.-]+)>", re.sub(r"#link\(<[^>]+>\)", "", typ)))
    assert set(re.findall(r"#link\(<([^>]+)>\)", typ)) <= labels


def test_numbers_in_prose_are_formatted(page):
    """Minus signs, separators from 1,000 on, and percentages; tuples are shown as lists."""
    shown = words(page)
    for text_ in ("−2.5, 12,345,", ", 1, 2, 3, 4, 5, 6, 7, 8, 123,456.8, −250 %"):
        assert text_ in shown
    for kept_together in ("250\xa0%", "1,000\xa0m."):
        assert kept_together in html.unescape(page)
    assert "{{bumps.small:.1e}}" in shown  # in code
    assert shown.count("{{") == 1


def test_powers_of_ten_are_set_as_mathematics(page, typ):
    """0.0012 as .1e reads 1.2 × 10⁻³; one digit 1 × 10⁻⁴, an order of magnitude 10⁻⁴."""
    tex = re.findall(r'<annotation encoding="application/x-tex">(.*?)</annotation>', page)
    assert tex.count(r"1.2 \times 10^{-3}") == 3  # in prose and in two tables
    assert {"a = 1.2 \\times 10^{-3}", r"b = \text{12,345}", "c = 10^{-16}", "10^{-16}"} <= set(tex)
    assert {"d = 10^{-5}", r"1 \times 10^{-4}", "1"} <= set(tex)
    assert "1.2 times 10^(- 3)" in typ
    assert '"12,345"' in typ  # Typst would set a space behind a comma of mathematics


def test_figures_have_alternative_texts_and_their_origin(page, typ):
    """Alternative texts contain facts as plain text; the origin names the experiment.

    The page folds its parameters; the print refers to their list.
    """
    alt = 'Bumps at 1.2 × 10⁻³ < 1 and "so" on the left.'
    assert alt in [html.unescape(a) for a in re.findall(r'aria-label="([^"]*)"', page)]
    assert 'alt: "{}"'.format(alt.replace('"', r"\"")) in typ
    origin = "Experiment bumps: points = 1,000; epsilon = ; powers = 1, 2, …, 8."
    assert words(page).count(origin) == 3
    assert page.count('<details class="provenance"><summary>Experiment ') == 3
    assert page.count('<span class="colon">:</span></summary>') == 3  # not shown when folded
    origins = re.findall(r"#provenance\[.*", typ)
    assert len(origins) == 4
    assert [("#page-of(<experiment-bumps>)" in x, "points" in x) for x in origins[:3]] == [
        (True, False)
    ] * 3
    assert "Experiments bumps and other." in words(page)


def test_tables_are_made_from_results(page):
    """They have the requested columns, rows and formats."""
    table = re.search(r'<table[^>]*class="result".*?</table>', page, re.S).group(0)
    rows = re.findall(r"<tr.*?</tr>", table, re.S)
    assert len(rows) == 3
    assert "<em>error</em>" in rows[0]
    assert re.findall(r'x-tex">(.*?)<', rows[1] + rows[2]) == ["10^{-16}", r"1.2 \times 10^{-3}"]
    assert "yes" in rows[1]


def test_no_markup_is_shown_to_the_reader(page, typ):
    """Neither output contains TeX or Markdown."""
    assert not re.search(r"\\[a-zA-Z]{2,}|\$\$|:::|\{#", words(page))
    assert not re.search(r"\\\$|:::|\{\\#", typ)


def test_the_page_loads_nothing(page):
    assert not re.search(r'<(?:script|img|link|iframe|source)\b[^>]*(?:src|href)="(?!data:)', page)
    css = (REPORT / "style.css").read_text()
    assert not re.search(r"@import|url\(", css)


@pytest.mark.slow
def test_in_print_a_page_may_begin_below_a_formula_that_ends_a_sentence(text):
    """Other paragraphs stay whole, at the top level and in a solution."""
    body = "Let\n$$ x = 1 . $$\nThen it is so.\n\nLet\n$$ y = 1 , $$\nwhere it is so.\n\n"
    printed = text.convert(f"# A {{#sec:a}}\n\n{body}::: solution\n{body}:::\n")["print"]
    assert printed.count("#whole[") == 6
    inside = printed[printed.index('#statement("solution")[') :]
    assert inside.count("#whole[") == 3


@pytest.mark.slow
def test_in_print_a_page_may_begin_between_items_of_a_long_list(text):
    """A short list stays whole, and so does each item of a long one."""
    for words_, blocks in ((5, 1), (80, 3)):
        item = "- " + "word " * words_ + "\n"
        printed = text.convert("# A {#sec:a}\n\n" + 3 * item)["print"]
        assert printed.count("#whole[") == blocks


@pytest.mark.slow
def test_in_print_no_line_ends_within_a_unit(text):
    printed = text.convert("# A {#sec:a}\n\nAt 254 m/s, or 0.4 kg/m³, in m and s.\n")["print"]
    assert re.findall(r"#box\[(.*?)\]", printed.partition("sec:a")[2]) == ["m/s,", "kg/m³,"]


def test_typst_code_from_pandoc_is_corrected(typ):
    """Names that Typst has removed do not occur; formulas have their TeX as alternative text."""
    assert "sect" not in re.sub(
        r'"[^"]*"', "", re.search(r"#math.equation\(block.*bigcap.*", typ).group(0)
    )
    assert 'alt: "\\\\mathbf{B} \\\\mathbf{c} = \\\\nabla \\\\phi"' in typ


def is_typst_symbol(name):
    """Whether a name has a meaning in a Typst formula; a name with a hyphen cannot have one."""
    try:
        typst.compile(f"$ {name} $".encode())
    except typst.TypstError as error:
        return "unknown variable" not in str(error)
    return "-" not in name


@pytest.mark.slow
def test_formulas_on_the_page_keep_their_primes_and_punctuation(text):
    """Primes are no superscripts; no line begins with the comma behind a formula."""
    body = "The slope $f'_1$, with ($s'' = 0$), and $x$ alone."
    page = text.convert(f"# A {{#sec:a}}\n\n{body}\n")["page"]
    assert "<mo>′</mo>" not in page
    whole = re.findall(r'<span class="unbroken">(.*?)</span>', page, flags=re.S)
    plain = [re.sub(r"<annotation.*?</annotation>|<[^>]*>", "", part) for part in whole]
    assert plain == ["f′1,", "(s″=0),"]


@pytest.mark.slow
def test_bars_parentheses_and_functions_of_printed_formulas_have_no_gaps(text):
    """Typst sets a space inside bars of text, and between a word and its argument."""
    body = r"Let $\lvert S\rvert = 1$, $\operatorname{rank}(B)$ and $\bigl( a \bigr)$."
    printed = text.convert(f"# A {{#sec:a}}\n\n{body}\n")["print"]
    assert "$lr(|S|) = 1$" in printed
    assert r'$op("rank") \( B \)$' in printed
    assert r"[\(]a#scale" in printed


def test_the_template_defines_no_name_of_a_typst_symbol():
    """A colour called `hat` would replace the accent in every formula."""
    assert is_typst_symbol("accent")
    names = re.findall(r"^#let ([\w-]+)", (REPORT / "template.typ").read_text(), re.M)
    assert len(names) > 3
    assert [name for name in names if is_typst_symbol(name)] == []


def test_every_damaged_part_is_reported_at_once(problems):
    """The undamaged text is converted without an error."""
    assert len(problems.splitlines()) >= len(DAMAGE)


@pytest.mark.parametrize("what", DAMAGE)
def test_each_kind_of_damage_is_reported(problems, what):
    assert re.search(DAMAGE[what][1], problems)


def test_errors_are_reported_with_file_and_line(text, problems):
    line = next(k for k, t in enumerate(text_lines(text), 1) if "{{bumps.gone:.1f}}" in t)
    assert f"text/chapters/01-all.md:{line}: bumps has no fact gone" in problems


def text_lines(text):
    damaged = WHOLE + "\n\n".join(damage for damage, _ in DAMAGE.values()) + "\n"
    path = text.document.source / "chapters" / "01-all.md"
    path.write_text(damaged)
    return damaged.splitlines()


def test_unquoted_facts_are_listed(text):
    """Facts that no chapter quotes are listed by name."""
    (text.document.source / "chapters" / "01-all.md").write_text(WHOLE)
    assert unquoted_facts(text.document.chapters, VALUES) == {"bumps": ["unquoted"]}


def test_an_unknown_citation_stops_the_build(text):
    """The bibliography lacks this key."""
    with pytest.raises(BuildError, match="nobody1900"):
        text.convert("# A {#sec:a}\n\nAs in @nobody1900.\n")


@pytest.mark.slow
def test_an_unknown_macro_of_tex_has_its_file_and_line(text):
    """Also in a formula that is shown, and with a number that is filled in."""
    for formula in (r"$a \nowhere{b}$", r"$$ x + \nowhere $$", r"$\nowhere {{bumps.ratio:.1f}}$"):
        with pytest.raises(BuildError, match=r"chapters/01-all\.md:3: \\nowhere is no TeX"):
            text.convert(f"# A {{#sec:a}}\n\nAs {formula}.\n")


def test_embedded_fonts_contain_the_characters_of_the_page(page):
    """A character that no font contains is refused by name."""
    mathematics, letters = code_points(page)
    assert {ord("∇"), ord("𝑥"), ord("𝐁")} <= mathematics
    assert ord("ψ") not in letters
    with pytest.raises(BuildError, match=r"have no 🦆 \(U\+1F986\)"):
        font_faces("<p>🦆</p>")


def test_embedded_fonts_contain_the_root_sign():
    """The browser draws it for an element, although it is not a character of the page."""
    root = "<math><msqrt><mn>3</mn></msqrt></math>"
    assert ord("√") in code_points(root)[0]
    assert ord("√") not in code_points("<math><mn>3</mn></math>")[0]


PARTS = """# Before {#sec:before}

@sec:slides is next; @app:speed and [@tbl:speed] are on the site.

# The slides {#sec:slides .part pages=1}

# One {#sec:one}

LONG

# Speed {#app:speed .appendix .online}

| a |
|---|
| b |

: Seconds. {#tbl:speed}
"""


@pytest.fixture(scope="module")
def parts(text):
    return text.convert(PARTS.replace("LONG", "Short."))


def test_a_part_has_a_number_and_the_numbers_of_its_chapters_run_on(parts):
    for output in ("page", "site"):
        shown = words(parts[output]).replace("\xa0", " ")
        assert "Part I The slides" in shown.replace("\u2002", " ")
        assert "Part I is next" in shown
    numbers = re.findall(r'<span class="secno">(.*?)</span>', parts["site"].partition("</nav>")[2])
    assert numbers == ["1", "Part\xa0I", "2", "A"]


def test_an_online_appendix_is_on_the_site_alone(parts):
    """Elsewhere a reference to it is text, since there is nothing to lead to."""
    assert 'href="#app:speed"' in parts["site"]
    assert "Seconds." in words(parts["site"])
    for output in ("page", "print"):
        assert "Seconds." not in parts[output]
        assert "app:speed" not in parts[output]
        assert re.search("Appendix.A and Table.A.1 are on the site", words(parts[output]))


@pytest.mark.slow
def test_a_part_with_more_pages_than_its_heading_allows_stops_the_build(text):
    """The part ends where the appendix begins; a part of one page is allowed."""
    after = "\n\n# Rest {#app:rest .appendix}\n\nMore.\n"
    for words_, fails in ((10, False), (1500, True)):
        chapter = PARTS.replace("LONG", "word. " * words_).partition("# Speed")[0] + after
        source = text.document.out / "part.typ"
        source.write_text(text.convert(re.sub("@app:.*", "", chapter))["print"])
        if fails:
            with pytest.raises(BuildError, match="a part has 3 pages; its heading allows 1"):
                typeset(source, text.document.out)
        else:
            assert typeset(source, text.document.out).startswith(b"%PDF")


FLOAT = """
#floating(<sec:first>)[#figure(rect(height: HEIGHT), kind: table, caption: [Wide.<caption>])<wide>]
"""
NEARLY_FULL = f"""
#pagebreak() #lorem(420) {FLOAT.replace("HEIGHT", "110mm")} {FLOAT}
#block[#whole[#lorem(250)] #whole[#lorem(80)]]
"""
LONG_PROOF = f"""
#v(100mm) {FLOAT.replace("HEIGHT", "60mm")}
#block[#statement("proof")[#whole[#lorem(220)] FLOAT #whole[#lorem(220)]<conclusion>]]
"""


@pytest.fixture
def typeset_with(text):
    """Typeset a first chapter followed by Typst code; return the path of the source."""

    def typeset_with(code):
        source = text.document.out / "floats.typ"
        source.write_text(text.convert("# First {#sec:first}")["print"] + code)
        assert typeset(source, text.document.out).startswith(b"%PDF")
        return source

    return typeset_with


def position(source, label):
    """Page and height of a label in the PDF."""
    found = source.with_name("position.typ")
    found.write_text(f"{source.read_text()}\n#context [#metadata(locate({label}).position())<at>]")
    at = json.loads(typst.query(str(found), "<at>", field="value", one=True))
    return at["page"], float(at["y"].removesuffix("pt"))


@pytest.mark.slow
def test_a_paragraph_for_which_floats_leave_no_room_stops_the_build(typeset_with):
    """Two floats leave too little of a page for the next paragraph, or enough."""
    typeset_with(NEARLY_FULL.replace("HEIGHT", "60mm"))
    with pytest.raises(BuildError, match=r"page \d: floats leave too little room for a paragraph"):
        typeset_with(NEARLY_FULL.replace("HEIGHT", "100mm"))


@pytest.mark.slow
def test_a_float_is_above_the_text_of_its_page_but_not_above_its_chapter(typeset_with):
    """On later pages the float is at the top, although it is called below two paragraphs."""
    called = "#lorem(90)\n\n" + FLOAT.replace("HEIGHT", "60mm") + "#lorem(90)<after>\n"
    opening = typeset_with(called)
    assert position(opening, "<after>") < position(opening, "<caption>")
    later = typeset_with("#pagebreak()\n#lorem(20)<before>\n\n" + called)
    assert position(later, "<caption>") < position(later, "<before>")


@pytest.mark.slow
def test_the_caption_of_a_long_table_is_on_the_page_of_its_first_row(typeset_with):
    """Little room is left on the page of the heading; the caption would fit there alone."""
    rows = "[#metadata(none)<row> first], " + "[next], " * 50
    table = f"figure(table({rows}), kind: table, caption: [Long.<caption>])"
    source = typeset_with(f"#pagebreak() #block(height: 226mm)[Full.] #long-table[#{table}]")
    assert position(source, "<caption>")[0] == position(source, "<row>")[0]


@pytest.mark.slow
def test_a_long_proof_is_divided_between_paragraphs_but_not_by_a_float(typeset_with):
    """A proof that fits is not divided."""
    divided = typeset_with(LONG_PROOF.replace("FLOAT", ""))
    assert position(divided, "<proof>")[0] < position(divided, "<conclusion>")[0]
    short = typeset_with(LONG_PROOF.replace("FLOAT", "").replace("220", "90"))
    assert position(short, "<proof>")[0] == position(short, "<conclusion>")[0]
    with pytest.raises(BuildError, match=r"page \d: a figure or table is printed within a proof"):
        typeset_with(LONG_PROOF.replace("FLOAT", "#figure(rect(), caption: [Inside.])"))


@pytest.mark.slow
def test_a_float_in_a_proof_is_named_with_its_line_and_that_of_the_statement(text):
    """A longer label that begins with the same letters, on an earlier line, is another one."""
    figure = '![Bumps, all of them.](bumps.svg){#fig:%s alt="Bumps, which rise to the right."}'
    paragraph = "Word. " * 220 + "\n\n"
    proof = f"{4 * paragraph}{figure % 'low'}\n\n{6 * paragraph}"
    chapter = (
        f"# First {{#sec:first}}\n\nSee @fig:low, @fig:low-far.\n\n{figure % 'low-far'}\n\n"
        f"::: {{.theorem #thm:one}}\nSo.\n:::\n\n{paragraph}"
        f"::: proof\n{proof}\n:::\n"
    )
    source = text.document.out / "proof.typ"
    source.write_text(text.convert(chapter)["print"])
    with pytest.raises(
        BuildError,
        match=r"<fig:low> \(text/chapters/01-all.md:22\) is printed within the proof "
        r"below <thm:one> \(text/chapters/01-all.md:7\); call it elsewhere",
    ):
        text.document.typeset(source)


WAITING = """
#v(60mm) #floating(<sec:first>)[#figure(rect(height: 50mm), caption: [First.])<fig:first>]
#pagebreak() #v(HEIGHT)
#floating(<sec:first>)[#figure(rect(height: 150mm), caption: [Wide.<caption>])<fig:second>]
#before-proof
#block[#statement("proof")[#whole[#lorem(220)] #whole[#lorem(LAST)]<conclusion>]]
"""


@pytest.mark.slow
def test_a_float_that_waits_for_a_page_is_above_a_proof_that_would_be_divided(typeset_with):
    """It is printed below a proof that fits."""
    long = typeset_with(WAITING.replace("HEIGHT", "100mm").replace("LAST", "220"))
    assert position(long, "<caption>")[0] == position(long, "<before-proof>")[0] + 1
    assert position(long, "<caption>") < position(long, "<proof>")
    short = typeset_with(WAITING.replace("HEIGHT", "100mm").replace("LAST", "50"))
    assert position(short, "<proof>")[0] == position(short, "<before-proof>")[0]
    assert position(short, "<conclusion>") < position(short, "<caption>")


@pytest.mark.slow
def test_below_a_float_at_the_foot_a_proof_begins_on_the_next_page(typeset_with):
    """Without this, the float would be between the parts of the proof."""
    divided = LONG_PROOF.replace("FLOAT", "").replace("#lorem(220)]<", "#lorem(180)]<")
    divided = divided.replace("220", "60")
    with pytest.raises(BuildError, match="is printed within a proof"):
        typeset_with(divided)
    source = typeset_with(divided.replace("#block[", "#before-proof\n#block["))
    assert position(source, "<caption>")[0] + 1 == position(source, "<proof>")[0]
    assert position(source, "<proof>")[0] == position(source, "<conclusion>")[0]


@pytest.mark.slow
def test_a_float_called_below_the_rest_of_a_proof_is_at_the_foot_of_the_page(typeset_with):
    """At the top it would be between the parts of the proof; it may push the call to a new page."""
    for height in ("60mm", "120mm"):
        called = f"\n#pagebreak()\n#v(100mm)\n#block{LONG_PROOF.partition('#block')[2]}"
        called = called.replace("FLOAT", "") + "#lorem(30)\n" + FLOAT.replace("HEIGHT", height)
        source = typeset_with(called + "#lorem(20)<after>\n")
        assert position(source, "<proof>")[0] < position(source, "<conclusion>")[0]
        assert position(source, "<caption>")[0] == position(source, "<conclusion>")[0]
        assert position(source, "<caption>") > position(source, "<conclusion>")


@pytest.mark.slow
def test_a_page_above_its_limit_names_its_longest_figures(text, monkeypatch):
    monkeypatch.setattr("fieldreport.build.typesetting.PAGE_LIMIT", 1000)
    with pytest.raises(BuildError, match=r"bytes, more than 1,000; draw fewer .*bumps"):
        text.document._whole_page("<p>" + "word " * 500 + "</p>", "")
