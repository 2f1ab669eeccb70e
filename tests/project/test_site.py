"""The site of the documentation: what it is assembled from, without Sphinx, which builds it."""

import html
import inspect
import operator
import os
import re
import runpy
import sys

import numpy as np
import pytest

import fieldrecon as fr
from checkout import ROOT

SITE = ROOT / "docs" / "site"
EXAMPLES = sorted((ROOT / "examples" / "gallery").glob("*.py"))


@pytest.fixture
def site(monkeypatch):
    """The modules of the site, which import each other from their folder."""
    monkeypatch.syspath_prepend(str(SITE))
    yield lambda name: __import__(name)
    for path in SITE.glob("*.py"):
        sys.modules.pop(path.stem, None)


def test_every_public_name_has_a_page(site):
    """The names at the top of the package, and those of all its namespaces."""
    api = site("api")
    documented = set(api.documented())
    assert set(fr.__all__) <= documented
    named = set(re.findall(r"``(\w+)``", fr.__doc__.partition("namespaces by topic")[2]))
    assert set(api.ROOMS) == named
    for room in named:
        for name in getattr(fr, room).__all__:
            assert {name, f"{room}.{name}"} & documented, name
    assert {f"api/names/fieldrecon.{name}.rst" for name in documented} <= set(api.pages())


@pytest.mark.parametrize(
    ("docstring", "markup"),
    [
        ("exp(|x - y|)", r"exp(\|x - y\|)"),
        ("h = (1 - r)_+ and x_i", r"h = (1 - r)\_+ and :formula:`x_i`"),
        ("N_k * N_0 * none", r":formula:`N_k * N_0` \* none"),
        ("`kernel.order - 1` and ``|x|``", "`kernel.order - 1` and ``|x|``"),
        (">>> abs(x) | y", ">>> abs(x) | y"),
        ("*solids : Solid", "*solids : Solid"),
    ],
)
def test_formulas_of_docstrings_are_no_markup(site, docstring, markup):
    """Code in backticks, examples, and names of arguments stay as they are."""
    assert site("docstrings").escaped([docstring]) == [markup]


def test_displayed_formulas_are_typeset_and_keep_their_symbols(site):
    """Without its tags a formula has the letters and numbers of the docstring, in their order."""
    formulas, docstrings = site("formulas"), site("docstrings")
    words = (formulas.GREEK | formulas.SIGNS).items()
    spelled = {sign.strip(): word.strip() for word, sign in words}
    found = []
    for name in site("api").documented():
        described = operator.attrgetter(name)(fr)
        lines = (inspect.getdoc(described) or "").splitlines() if callable(described) else []
        shown = [line for line in docstrings.with_formulas(lines) if 'class="formula"' in line]
        plain = [symbols(line, spelled) for line in lines if line.startswith("    ")]
        texts = [html.unescape(re.sub(r"<[^>]*>", "", line)) for line in shown]
        found += [(symbols(text, spelled), plain) for text in texts]
    assert len(found) >= 8
    assert [formula for formula, plain in found if formula not in plain] == []


def symbols(formula, spelled):
    """The letters, numbers and signs, without what lowers or raises and its brackets."""
    written = "".join(spelled.get(character, character) for character in formula)
    return re.sub(r"[\s_^(){}]", "", written)


@pytest.mark.parametrize(
    ("sentence", "formulas"),
    [
        (
            "Sums f(x) = b(x)^T c + sum_j c_j phi(|x - p_j|).",
            ["f(x) = b(x)^T c + sum_j c_j phi(|x - p_j|)"],
        ),
        ("of a p_i, and at a C^(2k), up to R^d", ["p_i", "C^(2k)", "R^d"]),
        ("n_folds of max_samples and 10_000 values a, b or (n, d)", []),
        ("p_i : array of f_j", []),
        ("an open (x_i - x_j", []),
    ],
)
def test_formulas_of_sentences_are_typeset(site, sentence, formulas):
    """Names of arguments, numbers, shapes and parts of formulas are none."""
    marked = site("docstrings").escaped_line(sentence)
    assert re.findall(":formula:`(.*?)`", marked) == formulas


def test_meanings_of_parameters_are_no_formulas(site):
    """A further paragraph of a meaning is indented as a formula is."""
    lines = [
        "Sum.",
        "",
        "    s = sum_i x_i",
        "",
        "Parameters",
        "----------",
        "x : float",
        "    One.",
    ]
    shown = site("docstrings").with_formulas([*lines, "", "    Two."])
    assert [line for line in shown if "<p" in line] == [
        '   <p class="formula"><i>s</i> = ∑<sub><i>i</i></sub> <i>x</i><sub><i>i</i></sub></p>'
    ]
    assert shown[-1] == "    Two."


@pytest.mark.parametrize(
    "path",
    [*(ROOT / "docs" / "images").glob("*.svg"), *(ROOT / "benchmarks" / "results").glob("*.svg")],
    ids=lambda path: path.stem,
)
def test_a_drawing_can_be_read_on_a_dark_page(site, path):
    """Its lines on the page, and its letters, which are light there, on each area."""
    drawings = site("drawings")
    shown = drawings.drawing(path.read_text(encoding="utf-8"), path.stem, "What is to be seen")
    assert shown.startswith('<svg class="picture" role="img" aria-label="What is to be seen"')
    dark = dict(re.findall(r"--d(\w+): #(\w+)", shown))
    kinds = dict.fromkeys(re.findall(r'(fill|stroke)(?:: |=")var\(--d(\w+),', shown))
    assert {color for _, color in kinds} == set(dark)
    ink, paper = "e4e4e4", "131313"
    for kind, color in kinds:
        is_area = kind == "fill" and contrast(color, paper) > 10
        assert contrast(dark[color], ink if is_area else paper) > (4.5 if is_area else 1.3), color


def contrast(one, other):
    """The contrast of two colours, by the Web Content Accessibility Guidelines."""
    dark, light = sorted(map(luminance, (one, other)))
    return (light + 0.05) / (dark + 0.05)


def luminance(color):
    channels = [int(color[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [c / 12.92 if c < 0.04 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_defaults_in_signatures_are_names(site):
    """Python prints a function or a class in angle brackets."""
    printed = "(x, f=<function silent>, m=functools.partial(<class 'a.b.RBF'>, k=1), n=<factory>)"
    shown, _ = site("docstrings").readable(None, "", "", None, None, printed, "")
    assert shown == "(x, f=silent, m=functools.partial(RBF, k=1), n=...)"
    assert site("docstrings").readable(None, "", "", None, None, "(x, y=1)", "") is None


def test_fields_of_named_tuples_have_no_entries_of_their_own(site):
    """Their docstring lists them as attributes; methods keep their entries."""
    state, skips = fr.advection.State, site("docstrings").is_described
    assert skips(None, "", "time", state.time, False, None)
    assert skips(None, "", "index", state.index, False, None) is None


def test_links_of_the_guides_lead_to_pages_or_to_copies(site, tmp_path):
    """Links between guides stay; other pages get their name on the site, other files a copy."""
    place = ROOT / "docs" / "for-this-test.md"
    text = (
        "[a](students.md#work) [b](../CHANGELOG.md) [c](../exercises/01_least_squares.ipynb) "
        "[d](images/terrain.png) [e](https://a.org) `fr.RBF` `fr.none`\n```\n[f](../x)\n```\n"
    )
    sources = site("sources")
    linked = sources.linked_text(text, place, tmp_path)
    assert re.findall(r"\]\((.*?)\)", linked) == [
        "students.md#work",
        "changes.md",
        "files/exercises-01_least_squares.ipynb",
        "images/terrain.png",
        "https://a.org",
        "../x",
    ]
    assert "{py:obj}`fr.RBF <fieldrecon.RBF>` `fr.none`" in linked
    assert (tmp_path / "files/exercises-01_least_squares.ipynb").is_file()


def test_names_of_chapters_in_the_guides_lead_to_the_report(site, tmp_path):
    """Other words in italics stay as they are, and so do links."""
    (tmp_path / "contents.json").write_text('["ls", "summary"]')
    (tmp_path / "ls.html").write_text('<h2><span class="secno">2</span> Least squares</h2>')
    (tmp_path / "summary.html").write_text('<h2 class="unnumbered">Summary</h2>')
    text = "*Least squares*, *Summary*, *not*, **Summary**, [*Summary*](a.md)"
    assert site("sources").named_chapters(text, tmp_path) == (
        "[*Least squares*](report/ls.chapter), [*Summary*](report/summary.chapter), "
        "*not*, **Summary**, [*Summary*](a.md)"
    )


@pytest.mark.parametrize(
    ("page", "asks"),
    [
        ('<a href="https://a.org">a</a><script src="_static/a.js"></script>', False),
        ('<script src="https://a.org/a.js"></script>', True),
        ('<link rel="stylesheet" href="//a.org/a.css">', True),
        ('<img alt="" src="http://a.org/a.png">', True),
    ],
)
def test_a_page_that_asks_the_network_is_found(site, page, asks, tmp_path):
    (tmp_path / "a.html").write_text(page)
    assert site("checks").asks_network(tmp_path / "a.html") is asks


def pages(folder, **texts):
    """Write pages; return their texts by path, as a check reads them."""
    for name, text in texts.items():
        (folder / f"{name}.html").write_text(text)
    return {folder / f"{name}.html": text for name, text in texts.items()}


def test_a_broken_link_is_found(site, tmp_path):
    """Links to pages, to places in pages and to other files; those to other hosts are not tried."""
    (tmp_path / "data.csv").touch()
    links = [
        "b.html",
        "b.html#there",
        "#here",
        "data.csv",
        "https://a.org/x",
        "c.html",
        "b.html#no",
    ]
    text = '<p id="here"></p>' + "".join(f'<a href="{link}">x</a>' for link in links)
    found = site("checks").broken_links(pages(tmp_path, a=text, b='<p id="there"></p>'))
    assert sorted(sentence.split(": ")[1] for sentence in found) == ["b.html#no", "c.html"]


def test_a_page_is_as_heavy_as_all_that_it_loads(site, tmp_path):
    """Each file counts once; the picture behind a living figure is loaded when it is shown."""
    for name in ("a", "b"):
        (tmp_path / f"{name}.webp").write_bytes(bytes(600_000))
    one, other = '<img src="a.webp">', '<figure><img src="b.webp"></figure>'
    hidden = f'<div class="widget" data-widget="terrain">{other}</div>'
    fine = pages(tmp_path, fine=one + one + hidden)
    checks = site("checks")
    assert checks.weight(*next(iter(fine.items()))) == 600_000 + len(one + one + hidden)
    assert checks.heavy_pages(fine) == []
    assert len(checks.heavy_pages(pages(tmp_path, heavy=one + other))) == 1


def test_the_page_how_to_cite_has_the_version(site):
    page = site("citation").page(ROOT)
    assert f"version = {{{fr.__version__}}}" in page
    assert "Wendland" in page


def test_there_are_examples_with_real_data():
    """At least twelve, each with a title; the terrain and the asteroid are measured."""
    assert len(EXAMPLES) >= 12
    texts = [path.read_text(encoding="utf-8") for path in EXAMPLES]
    assert all(re.match(r'"""\n(.+)\n=+\n\n', text) for text in texts)
    assert sum("datasets.terrain()" in text or "kleopatra()" in text for text in texts) >= 3


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_draws(example, monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.setitem(os.environ, "MPLBACKEND", "Agg")
    plt.switch_backend("Agg")
    plt.close("all")
    monkeypatch.chdir(example.parent)
    runpy.run_path(example.name)
    assert plt.get_fignums()
    plt.close("all")


def test_figures_of_the_gallery_have_the_colours_of_a_dark_page(site):
    """Lines, marks, letters and areas of one grey become light; those on a map stay."""
    from matplotlib.colors import to_rgb
    from matplotlib.figure import Figure

    page = Figure()
    plain, chart = page.subplots(1, 2)
    line, dots = (plain.plot([0, 1], [0, 1], look, color="black")[0] for look in ("-", "o"))
    level = plain.contour(np.outer([0, 1, 2], [1, 1, 1]), [1.0], colors="black")
    chart.imshow(np.eye(3))
    on_map = chart.plot([0, 1], [0, 1], "o", color="black")[0]
    site("gallery_figures").darken(page)
    light = [
        line.get_color(),
        dots.get_markerfacecolor(),
        plain.xaxis.label.get_color(),
        chart.spines["left"].get_edgecolor(),
        level.get_edgecolor()[0],
    ]
    assert min(min(to_rgb(color)) for color in light) > 0.8
    assert max(to_rgb(on_map.get_markerfacecolor())) == 0
    assert max(to_rgb(plain.get_facecolor())) < 0.1


def test_bodies_of_the_gallery_keep_their_shades_and_points_their_order_on_a_dark_page(site):
    """Once drawn, collections in space return their colours sorted by depth."""
    from matplotlib.collections import Collection
    from matplotlib.figure import Figure

    page = Figure()
    space = page.add_subplot(projection="3d")
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    body = space.plot_trisurf(*corners.T, triangles=faces, color="steelblue")
    points = space.scatter(*corners.T, c=["#000000", "#ffffff", "#000000", "#ffffff"], alpha=1)
    page.draw_without_rendering()
    shades = body.get_facecolor()
    site("gallery_figures").darken(page)
    page.draw_without_rendering()
    assert np.array_equal(body.get_facecolor(), shades)
    given = Collection.get_facecolor(points)[:, 0]
    assert list(given > 0.5) == [True, False, True, False]
