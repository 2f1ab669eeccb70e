"""The map of the course agrees with the sources, and is readable on light and dark pages."""

import re
import zipfile
from itertools import combinations
from xml.etree import ElementTree

import pytest
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from checkout import ROOT
from fieldgrade.authoring import build, bundle
from fieldgrade.authoring.course_map import (
    COLORS,
    DIAGRAM,
    HEIGHT,
    PAGE,
    WIDTH,
    map_diagram,
    map_page,
)
from fieldgrade.authoring.leaks import code_leaks
from fieldgrade.authoring.outline import Outline, minutes
from fieldgrade.class_folder.self_assessment import self_assessment, write_self_assessment

SOURCES = build.all_sources(ROOT)
SVG = "{http://www.w3.org/2000/svg}"
LINK = re.compile(r"\]\(([^)]+)\)")


def test_the_map_is_up_to_date_with_the_sources():
    assert (ROOT / PAGE).read_text(encoding="utf-8") == map_page(SOURCES)
    assert (ROOT / DIAGRAM).read_text(encoding="utf-8") == map_diagram(SOURCES)


def test_the_map_has_each_question_once_and_the_minutes_of_each_notebook():
    page = map_page(SOURCES)
    for outline in map(Outline, SOURCES):
        for item in outline.items:
            row = re.findall(rf"^\| {item.question} \| (.*) \|$", page, re.MULTILINE)
            assert len(row) == 1
            assert row[0].endswith(f"| {item.points:g} | {item.minutes}")
            assert ("(optional)" in row[0]) == item.is_optional
        name = re.escape(outline.source.title)
        (row,) = re.findall(rf"^\| \[{outline.source.number} {name}\].*$", page, re.MULTILINE)
        for part in filter(None, (outline.core, outline.optional)):
            worth = sum(item.points for item in part)
            assert f"| {minutes(part)} min, {worth:g} points |" in row


@pytest.fixture(scope="module")
def diagram():
    return ElementTree.fromstring(map_diagram(SOURCES))


def boxes(diagram):
    """The corners (x, y) of the boxes of notebooks."""
    return [
        (float(r.get("x")), float(r.get("y")))
        for r in diagram.iter(f"{SVG}rect")
        if float(r.get("height")) == HEIGHT
    ]


def test_the_diagram_has_a_box_for_each_notebook_and_an_arrow_for_each_dependence(diagram):
    """Boxes do not overlap, and each arrow leads from a box to one further right."""
    corners = boxes(diagram)
    assert len(corners) == len(SOURCES)
    for (x, y), (u, v) in combinations(corners, 2):
        assert abs(x - u) >= WIDTH or abs(y - v) >= HEIGHT
    arrows = [p.get("d") for p in diagram.iter(f"{SVG}path") if p.get("marker-end")]
    assert len(arrows) == sum(len(Outline(source).builds_on) for source in SOURCES)
    exits = {(x + WIDTH, y + HEIGHT / 2) for x, y in corners}
    entries = {(x, y + HEIGHT / 2) for x, y in corners}
    for arrow in arrows:
        x, y, *_, to_x, to_y = map(float, re.findall(r"-?[\d.]+", arrow))
        assert (x, y) in exits
        assert (to_x, to_y) in entries
        assert to_x > x


@pytest.mark.slow
def test_the_text_of_each_box_fits_into_it(diagram):
    """Measured in DejaVu Sans, which is wider than most sans-serif fonts."""
    corners = boxes(diagram)
    texts = [t for t in diagram.iter(f"{SVG}text") if t.text not in COLORS]
    inside = 0
    for text in texts:
        x, y = float(text.get("x")), float(text.get("y"))
        font = FontProperties(family="DejaVu Sans", weight=text.get("font-weight", "normal"))
        width = TextPath((0, 0), text.text, size=13, prop=font).get_extents().width
        box = [c for c in corners if c[0] < x < c[0] + WIDTH and c[1] < y < c[1] + HEIGHT]
        assert len(box) == 1
        assert x + width < box[0][0] + WIDTH, text.text
        inside += 1
    assert inside >= 2 * len(SOURCES)


def luminance(color):
    """Relative luminance of WCAG 2."""
    parts = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_the_diagram_is_readable_on_light_and_dark_pages(diagram):
    """Contrasts that WCAG 2 requires: 4.5 for text, 3 for lines."""
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    text = {t.get("fill") for t in diagram.iter(f"{SVG}text")}
    assert all(contrast(t, fill) >= 4.5 for t in text for fill in COLORS.values())
    lines = {p.get("stroke") for p in diagram.iter(f"{SVG}path")} - {None}
    for page in ("#ffffff", "#0d1117"):
        assert lines
        assert all(contrast(line, page) >= 3 for line in lines)


def test_the_links_of_the_map_exist_in_the_checkout_and_in_the_bundle(tmp_path):
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    links = LINK.findall(page)
    assert len(links) == len(SOURCES) + 1
    assert all((ROOT / PAGE.parent / link).is_file() for link in links)
    with zipfile.ZipFile(bundle.write_bundle(ROOT, tmp_path / "bundle.zip")) as archive:
        names = set(archive.namelist())
        for name in ("course.md", "README.md"):
            text = archive.read(f"{bundle.FOLDER}/{name}").decode()
            linked = [link for link in LINK.findall(text) if "//" not in link]
            assert {f"{bundle.FOLDER}/{link}" for link in linked} <= names


# Self-assessment.


@pytest.mark.parametrize("source", SOURCES, ids=[s.name for s in SOURCES])
def test_the_page_for_self_assessment_has_all_model_answers_and_rubrics(source):
    text = self_assessment(source)
    secret = [cell.text for cell in source.cells if cell.answer or cell.rubric]
    assert secret
    assert all(part in text for part in secret)
    assert text.count("### Rubric") == len(source.written_points)


def test_no_model_answer_or_rubric_is_in_the_bundle(tmp_path):
    """The guard of the build finds the page if it is among the files for students."""
    first = SOURCES[0]
    with zipfile.ZipFile(bundle.write_bundle(ROOT, tmp_path / "bundle.zip")) as archive:
        assert not [name for name in archive.namelist() if "assessment" in name]
    found = list(code_leaks(first, {"page.md": self_assessment(first)}))
    assert any("model answer" in leak for leak in found)


@pytest.mark.slow
def test_the_page_for_self_assessment_is_written_as_markdown_and_html(tmp_path):
    markdown, html = write_self_assessment(SOURCES[0], tmp_path)
    assert "## 01.7 (3 points)" in markdown.read_text(encoding="utf-8")
    text = html.read_text(encoding="utf-8")
    assert "<math" in text
    assert "$" not in re.sub(r"<annotation.*?</annotation>", "", text, flags=re.DOTALL)
