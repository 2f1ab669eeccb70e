"""The site of the documentation: what it is assembled from, without Sphinx, which builds it."""

import os
import re
import runpy
import sys

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
        ("phi(|x - y|)", r"phi(\|x - y\|)"),
        ("h = (1 - r)_+ and x_i", r"h = (1 - r)\_+ and x_i"),
        ("N_k * N_0", r"N_k \* N_0"),
        ("`kernel.order - 1` and ``|x|``", "`kernel.order - 1` and ``|x|``"),
        (">>> abs(x) | y", ">>> abs(x) | y"),
        ("*solids : Solid", "*solids : Solid"),
    ],
)
def test_formulas_of_docstrings_are_no_markup(site, docstring, markup):
    """Code in backticks, examples, and names of arguments stay as they are."""
    assert site("docstrings").escaped([docstring]) == [markup]


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
