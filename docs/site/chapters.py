"""Chapters of the report as pages of the site.

A chapter comes as HTML, with numbers, formulas and references in place. Its sections become
sections of Sphinx, so that the contents, the search and the links at headings know them; what is
between the headings goes into the page as it is.
"""

import html
import re
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.parsers import Parser

MARK = re.compile(
    r'<section id="(?P<id>[^"]+)" class="level\d[^"]*"[^>]*>\s*<h(\d)[^>]*>(?P<title>.*?)</h\2>'
    r"|</section>",
    flags=re.S,
)
NO_TEXT = re.compile(r"<(script|svg|template)\b.*?</\1>|<[^>]*>", flags=re.S)
FORMULA = re.compile(r"(<math\b.*?</math>)", flags=re.S)


class Fragment(nodes.General, nodes.Element):
    """HTML for the page; its child is the text without formulas, which the search reads."""


class ChapterParser(Parser):
    """Makes a document of a chapter."""

    supported = ("chapter",)

    def parse(self, inputstring: str, document: nodes.document) -> None:
        """Add the sections of a chapter to the document."""
        within, end = [document], 0
        for mark in MARK.finditer(inputstring):
            within[-1].extend(fragments(inputstring[end : mark.start()]))
            end = mark.end()
            if mark["id"]:
                section = nodes.section(ids=[html.unescape(mark["id"])], classes=["chapter"])
                section += nodes.title("", "", *inline(mark["title"]))
                within[-1] += section
                within.append(section)
            elif len(within) > 1:
                within.pop()
        within[-1].extend(fragments(inputstring[end:]))


def fragments(content: str) -> list[Fragment]:
    """Return HTML as a node, or nothing for white space and the end of the page's frame."""
    text = plain(FORMULA.sub(" ", content))
    return [Fragment("", nodes.Text(text), html=content)] if content.strip() else []


def inline(title: str) -> list[nodes.Node]:
    """Return a title as text, and as HTML where it has formulas."""
    parts = [part for part in FORMULA.split(title) if part]
    return [
        nodes.raw("", part, format="html") if part.startswith("<math") else nodes.Text(plain(part))
        for part in parts
    ]


def plain(content: str) -> str:
    """Return the text of HTML."""
    return html.unescape(NO_TEXT.sub("", content))


def write(translator: object, node: Fragment) -> None:
    """Put the HTML into the page."""
    translator.body.append(node["html"])  # type: ignore[attr-defined]
    raise nodes.SkipNode


def choose_styles(app: Sphinx, page: str, _template: str, context: dict, _: object) -> None:
    """Give the chapters the fonts of the report, and leave out what the gallery loads."""
    if page.startswith("report/"):
        app.add_css_file("../report/report.css")
        for kind in ("css_files", "script_files"):
            context[kind] = [file for file in context[kind] if not of_gallery(str(file.filename))]


def of_gallery(file: str) -> bool:
    """Tell whether sphinx-gallery adds this file to every page."""
    return Path(file).name.startswith(("sg_", "sg-"))


def setup(app: Sphinx) -> dict:
    """Register with Sphinx."""
    app.add_node(Fragment, html=(write, None))
    app.add_source_parser(ChapterParser)
    app.connect("html-page-context", choose_styles)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
