"""The report as fragments of HTML by chapter, which the site of the documentation puts into pages.

The folder has a fragment for each chapter, which contains its figures, the fonts, the rasters, and
the data of each figure. Everything is named relative to this folder.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Final

from fieldrecon._core.atomic_files import write_atomically
from fieldreport.build import widget_scripts
from fieldreport.build.errors import BuildError
from fieldreport.build.rerun import ExperimentJob
from fieldreport.build.screen_figures import (
    PICTURE,
    dark_values,
    element,
    raster,
    screen_file,
    with_pictures,
)
from fieldreport.build.typesetting import UPRIGHT_NABLA, Document
from fieldreport.framework.result_files import table_files

CONTENTS: Final = "contents.json"
"""The file with the chapters in their order, written last."""
CHAPTER: Final = re.compile(r'<section id="([^"]+)" class="level2\b')
PREVIEWED: Final = re.compile(
    r'<(span|div|table)\b(?=[^>]* class="(?:equation|statement|result|csl-entry)\b)'
    r'[^>]* id="([^"]+)"'
)
"""Equations, statements, tables and works, which a link to them shows under the pointer."""
TITLES: Final = [
    re.compile(r'<section id="([^"]+)"[^>]*>\s*<h\d[^>]*>(.*?)</h\d>', flags=re.S),
    re.compile(r'<figure id="([^"]+)">.*?<figcaption>(.*?)(?:<details|</figcaption>)', flags=re.S),
    re.compile(
        r'<div id="([^"]+)" class="statement[^"]*">\s*<p><strong>(.*?)</strong>', flags=re.S
    ),
]
LIVING: Final = re.compile(r"/\* Living figures:.*?\n(?=\n)", flags=re.S)
"""The part of the style sheet about living figures, up to an empty line."""
SOLUTION: Final = re.compile(r'<div(?: id="[^"]*")? class="statement solution">')
FOLD: Final = '<details class="statement solution"><summary>Solution</summary>'
HEADING: Final = re.compile(r"^# .*\{#([^\s}]+)", flags=re.M)
FIGURE: Final = re.compile(r"<figure\b.*?</figure>", flags=re.S)
DARK: Final = """@media not print {{
body[data-theme="dark"] {{ {0}}}
@media (prefers-color-scheme: dark) {{ body:not([data-theme="light"]) {{ {0}}} }}
}}
"""
"""Colours of figures where the theme of the site is dark."""
LINK: Final = re.compile(r'(?<=href=")#([^"]+)(?=")')
TEX: Final = re.compile(r"<annotation\b.*?</annotation>", flags=re.S)


@dataclass(frozen=True)
class Chapter:
    """A chapter of the report.

    Parameters
    ----------
    name : str
        Name of its page, that of its file without the number.
    content : str
        HTML.
    """

    name: str
    content: str


def write_pages(document: Document, jobs: Iterable[ExperimentJob]) -> list[Path]:
    """Write the fragments, the style, the figures and their data; return the files.

    Parameters
    ----------
    document : Document
        The report, whose text has been set.
    jobs : iterable of ExperimentJob
        The experiments, whose figures and tables are copied.
    """
    out = document.out / "pages"
    page = document.page.read_text(encoding="utf-8").replace("<mi>∇</mi>", UPRIGHT_NABLA)
    text = TEX.sub("", page)
    pictures = {job.name: Pictures(job, out) for job in jobs}
    chapters = chapters_of(text, page_names(labels_of(text), document.chapters))
    made, values = [], ""
    for chapter in chapters:
        text = FIGURE.sub(lambda figure: for_screen(figure[0], pictures), chapter.content)
        values += text
        text = with_folded_solutions(text) + widget_scripts.SCRIPTS
        content = widget_scripts.embedded(text, document.source, document.out).encode()
        made.append(write_atomically(out / f"{chapter.name}.html", content))
    style = _style(document) + DARK.format(dark_values(values))
    made.append(write_atomically(out / "report.css", style.encode()))
    contents = json.dumps([chapter.name for chapter in chapters])
    made.append(write_atomically(out / CONTENTS, contents.encode()))
    return sorted({*made, *(path for each in pictures.values() for path in each.written)})


def _style(document: Document) -> str:
    """Return the fonts, and the part of the style sheet that is about living figures."""
    fonts = (document.out / ".state" / "fonts.css").read_text(encoding="utf-8")
    living = LIVING.search((document.source / "style.css").read_text(encoding="utf-8"))
    return fonts + (living[0] if living else "")


def page_names(labels: list[str], paths: Iterable[Path]) -> list[str]:
    """Return the name of each chapter's page.

    It is the name of the file that begins with the chapter, without number; a chapter further down
    in a file is named by its label.

    Parameters
    ----------
    labels : list of str
        The labels of the chapters, such as ``"sec:least-squares"``.
    paths : iterable of Path
        The files.
    """
    headings = {
        first[1]: path.stem.lstrip("0123456789-")
        for path in paths
        if (first := HEADING.search(path.read_text(encoding="utf-8")))
    }
    return [headings.get(label, label.rpartition(":")[2]) for label in labels]


def labels_of(page: str) -> list[str]:
    """Return the labels of the chapters in their order."""
    return [html.unescape(label) for label in CHAPTER.findall(page)]


def chapters_of(page: str, names: list[str]) -> list[Chapter]:
    """Split a page at its chapters; links between chapters name the page.

    A chapter ends with the previews of what it refers to in other chapters. Sections and figures
    have no preview, and links to them a title.
    """
    body = page[page.index("<main") : page.index("</main>")]
    starts = [match.start() for match in CHAPTER.finditer(body)]
    parts = [body[a:b] for a, b in pairwise([*starts, len(body)])]
    home = {
        label: name
        for name, part in zip(names, parts, strict=True)
        for label in re.findall(r'\bid="([^"]+)"', part)
    }
    shown = previews_of(body)
    titles = {label: title for label, title in titles_of(page).items() if label not in shown}

    def target(link: re.Match[str], here: str) -> str:
        label = html.unescape(link[1])
        there = home.get(label, here)
        if there == here:
            return link[0]
        title = f'" title="{html.escape(titles[label])}' if label in titles else ""
        return f"{there}.html{link[0]}{title}"

    def chapter(name: str, part: str) -> Chapter:
        labels = dict.fromkeys(map(html.unescape, LINK.findall(part)))
        previews = [shown[k] for k in labels if k in shown and home[k] != name]
        hidden = f'<template class="previews">{"".join(previews)}</template>' if previews else ""
        return Chapter(name, LINK.sub(lambda link: target(link, name), part) + hidden)

    return [chapter(name, part) for name, part in zip(names, parts, strict=True)]


def previews_of(body: str) -> dict[str, str]:
    """Return the elements that a link shows, by label, without identifiers and links inside."""
    return {
        html.unescape(mark[2]): re.sub(
            r' id="[^"]*"|</?a\b[^>]*>',
            "",
            whole(body, mark.start()).replace(' id="', ' data-label="', 1),
        )
        for mark in PREVIEWED.finditer(body)
    }


def whole(page: str, start: int) -> str:
    """Return the element that begins at a position.

    Examples
    --------
    >>> whole("<p><b>1<b>2</b></b>3</p>", 3)
    '<b>1<b>2</b></b>'
    """
    name, depth = re.compile(r"<(\w+)").match(page, start)[1], 0  # type: ignore[index]
    for tag in re.compile(rf"<(/?){name}\b[^>]*>").finditer(page, start):
        depth += -1 if tag[1] else 1
        if not depth:
            return page[start : tag.end()]
    raise BuildError(f"the element {page[start : start + 60]} has no end")


def titles_of(page: str) -> dict[str, str]:
    """Return the titles of sections and statements, and the captions of figures, by label."""
    return {
        html.unescape(label): " ".join(_plain(title).split())
        for pattern in TITLES
        for label, title in pattern.findall(page)
    }


def _plain(content: str) -> str:
    return html.unescape(re.sub(r"<[^>]*>", "", content))


def with_folded_solutions(content: str) -> str:
    """Fold each solution, so that a reader can try the exercise first."""
    for solution in [whole(content, start.start()) for start in SOLUTION.finditer(content)]:
        inside = SOLUTION.sub("", solution, count=1).removesuffix("</div>")
        inside = inside.replace("<strong>Solution.</strong> ", "", 1)
        content = content.replace(solution, f"{FOLD}{inside}</details>", 1)
    return content


def for_screen(figure: str, pictures: Mapping[str, Pictures]) -> str:
    """Return a figure with its picture, its data, and the command that draws it."""

    def picture(figure: str, alt: str, width: str) -> str:
        experiment, stem = figure.split("/")
        return pictures[experiment].picture(stem, alt, width)

    experiments = {html.unescape(tag[0]).split("/")[0] for tag in PICTURE.findall(figure)}
    lines = [pictures[name].data_line() for name in sorted(experiments)]
    shown = with_pictures(figure, picture)
    return shown.replace("</figcaption>", "".join([*lines, "</figcaption>"]))


@dataclass(frozen=True)
class Pictures:
    """The figures and the tables of an experiment, for the chapters.

    Parameters
    ----------
    job : ExperimentJob
        The experiment.
    out : Path
        The folder of the chapters.
    written : set of Path
        The files that were written.
    """

    job: ExperimentJob
    out: Path
    written: set[Path] = field(default_factory=set)

    def picture(self, stem: str, alt: str, width: str) -> str:
        """Return the element of a figure; a raster is copied."""
        path = screen_file(self.out.parent, f"{self.job.name}/{stem}")
        if path.suffix == ".svg":
            return element(path.read_text(encoding="utf-8"), stem, alt, width)
        self._write(path.name, path.read_bytes())
        return raster(f"{self.job.name}/{path.name}", alt, width)

    def data_line(self) -> str:
        """Write the tables; return the line with the links to them and the command."""
        tables = table_files(self.job.folder)
        for path in tables:
            self._write(path.name, path.read_bytes())
        links = [
            f'<a href="{self.job.name}/{path.name}" download>{path.name}</a>' for path in tables
        ]
        data = f"Data: {', '.join(links)}. " if links else ""
        command = f"<code>fieldrecon report --only {self.job.name}</code>"
        return f'<span class="data">{data}Drawn by {command}.</span>'

    def _write(self, name: str, content: bytes) -> None:
        self.written.add(write_atomically(self.out / self.job.name / name, content))
