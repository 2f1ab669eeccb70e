"""Living figures in the build: data and scripts on the page, nothing of them in print."""

import json
import re

import pytest

from fieldreport import widgets
from fieldreport.build import typesetting, widget_scripts
from fieldreport.build import widgets as living
from report_fixtures import REPORT, SmallReport

FIGURE = """
::: {{.widget name={name}}}
![Another square.](fake_b.svg){{#fig:b alt="A parabola that rises from zero to one."}}

Drag the corners of the triangle.
:::

See @fig:b.
"""
NAME = "cell_velocity"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A report with one living figure, built once; the page, and the source of the PDF."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        report = SmallReport(tmp_path_factory.mktemp("living"), monkeypatch)
        report.write_chapter(FIGURE.format(name=NAME))
        assert report.build() == 0
        page = (report.out / "report.html").read_text(encoding="utf-8")
        yield report, page, (report.out / ".state" / "report.typ").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_page_contains_the_data_and_one_script(built):
    """The data are those of the library, and the script contains the shared files once."""
    _, page, _ = built
    (data,) = re.findall(
        rf'<script type="application/json" id="widget-{NAME}">(.*?)</script>', page
    )
    assert json.loads(data) == widgets.data(NAME)
    assert page.count("class Living {") == 1
    assert page.count(f'widget("{NAME}"') == 1
    assert page.count(f'data-widget="{NAME}"') == 1
    assert 'widget("terrain"' not in page


@pytest.mark.slow
def test_the_figure_stays_on_the_page_and_the_instruction_is_not_printed(built):
    """Without a script the page shows the picture; the PDF has the picture only."""
    _, page, typst = built
    assert re.search(rf'data-widget="{NAME}">\s*<figure id="fig:b">\s*<svg class="picture" ', page)
    assert "Drag the corners" in page
    assert "fake_b.svg" in typst
    assert "Drag the corners" not in typst


@pytest.mark.slow
def test_the_manifest_contains_the_data(built):
    report, _, _ = built
    manifest = json.loads((report.out / "manifest.json").read_text())
    assert f"widgets/{NAME}.json" in manifest["sha256"]


@pytest.mark.slow
def test_a_living_figure_that_is_no_longer_used_is_removed(built):
    report, *_ = built
    report.write_chapter()
    assert report.build() == 0
    assert not (report.out / "widgets" / f"{NAME}.json").exists()
    page = (report.out / "report.html").read_text(encoding="utf-8")
    assert "class Living" not in page
    assert widget_scripts.SCRIPTS not in page


def test_an_unknown_name_is_reported_with_its_place(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(typesetting.Document, "compile", None)  # the build stops before
    report = SmallReport(tmp_path, monkeypatch)
    report.write_chapter(FIGURE.format(name="cell_velocty"))
    assert report.build() == 1
    lines = (report.source / "chapters" / "01-all.md").read_text().splitlines()
    line = lines.index("::: {.widget name=cell_velocty}") + 1
    told = capfd.readouterr().err
    assert f"01-all.md:{line}: " in told
    assert "cell_velocity" in told


def test_a_text_in_the_data_cannot_end_its_element(tmp_path):
    """The page reads the data as they were."""
    path = widget_scripts.data_file(tmp_path, NAME)
    path.parent.mkdir()
    path.write_text('{"text":"</script><b>"}')
    page = widget_scripts.embedded(
        f'<div data-widget="{NAME}"></div>{widget_scripts.SCRIPTS}', REPORT, tmp_path
    )
    (data,) = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', page)
    assert json.loads(data) == {"text": "</script><b>"}


def test_every_living_figure_has_a_script_and_a_place_in_a_chapter():
    """And each script has a module with its data."""
    scripts = sorted(path.stem for path in (REPORT / "widgets").glob("*.js"))
    used = living.named_in(sorted((REPORT / "chapters").glob("*.md")))
    assert scripts == widgets.names() == sorted(used)
