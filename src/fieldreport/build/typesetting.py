"""Typesetting: from chapters to one HTML file and one PDF, by pandoc, Lua filters, and Typst."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, cast

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.digests import json_digest
from fieldreport.build.code_dependencies import code_digests
from fieldreport.build.errors import BuildError
from fieldreport.build.manifest import versions
from fieldreport.build.screen_figures import (
    address,
    dark_values,
    element,
    raster,
    screen_file,
    with_pictures,
)
from fieldreport.build.step_records import Steps
from fieldreport.build.widget_scripts import embedded
from fieldreport.framework.orders_of_magnitude import mark_orders

PDF_STANDARD: Final = "ua-1"
OUTPUTS: Final = {
    "page": ("html5", "html"),
    "site": ("html5", "html"),
    "print": ("typst-citations", "typ"),
}
"""Format of pandoc and suffix of the template for each output.

Citations are text already, so Typst must not process them again.
"""
PAGE_LIMIT: Final = 8_000_000
"""Bytes of the one-file page at most."""
NO_DATE = 0
"""The time of creation for Typst, in seconds since 1970; the document does not show it."""


@dataclass(frozen=True)
class Document:
    """The source files of the report and its build folder.

    Parameters
    ----------
    source : Path
        Folder with ``chapters``, ``filters``, the templates, ``style.css``, ``metadata.yaml`` and
        ``references.bib``.
    out : Path
        The build folder.
    """

    source: Path
    out: Path

    @property
    def chapters(self) -> list[Path]:
        """The chapters in order of their names."""
        return sorted((self.source / "chapters").glob("*.md"))

    @property
    def page(self) -> Path:
        """The page for the site, without style, fonts and figures."""
        return self.out / ".state" / "page.html"

    @property
    def inputs(self) -> list[Path]:
        """All source files of the report."""
        names = ("style.css", "template.html", "template.typ", "metadata.yaml", "references.bib")
        return [
            *self.chapters,
            *sorted((self.source / "filters").glob("*.lua")),
            *sorted((self.source / "widgets").rglob("*.js")),
            *(self.source / name for name in names),
        ]

    def compile(self, values: Mapping[str, Any], metadata: Mapping[str, str]) -> list[Path]:
        """Write ``report.html`` and ``report.pdf``; return them.

        Parameters
        ----------
        values : mapping
            Facts, parameters, tables and figures of each experiment, for the Lua filters.
        metadata : mapping
            Added to ``metadata.yaml``.

        Raises
        ------
        BuildError
            If the text has errors: all of them, with file and line where known.
        """
        text = self.convert(values, metadata)
        write_atomically(self.page, text["site"].encode())
        source = write_atomically(self.out / ".state" / "report.typ", text["print"].encode())
        page = self._whole_page(text["page"], self.with_figures(text["site"]))
        return [
            write_atomically(self.out / "report.html", page),
            write_atomically(self.out / "report.pdf", self.typeset(source)),
        ]

    def typeset(self, source: Path) -> bytes:
        """Return the PDF of a Typst file; its errors say where the labels that they name stand."""
        try:
            return typeset(source, self.out)
        except BuildError as error:
            raise BuildError(LABEL.sub(self._with_place, str(error))) from error

    def convert(self, values: Mapping[str, Any], metadata: Mapping[str, str]) -> dict[str, str]:
        """Return the text as HTML, without style and fonts, for page and site, and as Typst."""
        state = self.out / ".state"
        write_atomically(state / "values.json", json.dumps(mark_orders(values)).encode())
        places = {"values": state / "values.json", "figures": self.out / "experiments"}
        combined = {**metadata, **{key: str(path.resolve()) for key, path in places.items()}}
        document = self._read(combined)
        with ThreadPoolExecutor(len(OUTPUTS)) as pool:
            texts = {output: pool.submit(self._written, output, document) for output in OUTPUTS}
            problems = _all_lines(*(text.exception() for text in texts.values()))
        if problems:
            raise BuildError("\n".join(problems))
        return {output: text.result() for output, text in texts.items()}

    def _read(self, metadata: Mapping[str, str]) -> str:
        """Return the chapters with numbers and citations as JSON of pandoc, for all outputs."""
        return self._pandoc(
            "--from=markdown",
            "--to=json",
            "--metadata-file=metadata.yaml",
            *(f"--metadata={key}:{value}" for key, value in metadata.items()),
            "--lua-filter=filters/report.lua",
            "--bibliography=references.bib",
            *(str(path.relative_to(self.source)) for path in self.chapters),
        )

    def _written(self, output: str, document: str) -> str:
        to, suffix = OUTPUTS[output]
        return self._pandoc(
            *(["--metadata=site:true"] if output == "site" else []),
            "--from=json",
            f"--to={to}",
            "--standalone",
            "--wrap=none",
            f"--template=template.{suffix}",
            "--lua-filter=filters/output.lua",
            "--toc",
            "--toc-depth=3",
            "--section-divs",
            "--mathml",
            document=document,
        )

    def _pandoc(self, *options: str, document: str | None = None) -> str:
        command = [str(pandoc()), *options, "--fail-if-warnings"]
        run = subprocess.run(
            command,
            cwd=self.source,
            input=document,
            capture_output=True,
            text=True,
            encoding="utf-8",
            check=False,
        )
        if run.returncode:
            raise BuildError(self._explained(run.stderr))
        return run.stdout

    def _explained(self, stderr: str) -> str:
        """Return the errors of the filters with file and line, or else the message of pandoc."""
        lines = [line.split("\t") for line in stderr.splitlines() if line.startswith("PROBLEM\t")]
        if lines:
            return "\n".join(self._place(token) + message for _, message, token in lines)
        formulas = dict.fromkeys(WRONG_FORMULA.findall(stderr))
        if formulas:
            return "\n".join(
                f"{self._place(formula) or self._place(what)}"
                f"{what} is no TeX that pandoc knows, in the formula {formula}"
                for formula, what in formulas
            )
        return f"pandoc: {stderr.strip()}"

    def _with_place(self, label: re.Match[str]) -> str:
        place = self._place_of(re.compile(rf"#{label[1]}(?![\w-])"))
        return f"{label[0]} ({place})" if place else label[0]

    def _place(self, token: str) -> str:
        place = self._place_of(re.compile(re.escape(token))) if token else ""
        return f"{place}: " if place else ""

    def _place_of(self, pattern: re.Pattern[str]) -> str:
        for path in self.chapters:
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if pattern.search(line):
                    return f"{self.source.name}/chapters/{path.name}:{number}"
        return ""

    def _whole_page(self, page: str, site: str) -> bytes:
        """Return the one-file page, which must not be longer than its limit.

        Its fonts also have the characters of the site.
        """
        content = self._dressed(page, site).encode()
        if len(content) > PAGE_LIMIT:
            figures = sorted(self.out.glob("screen/*/*.*"), key=lambda path: -path.stat().st_size)
            raise BuildError(
                f"report.html has {len(content):,} bytes, more than {PAGE_LIMIT:,}; draw fewer "
                f"elements in the longest figures: {', '.join(p.stem for p in figures[:3])}"
            )
        return content

    def _dressed(self, page: str, site: str) -> str:
        """Embed figures, living figures, style sheet and fonts in the page."""
        css = (self.source / "style.css").read_text(encoding="utf-8")
        page = self.with_figures(page.replace("<mi>∇</mi>", UPRIGHT_NABLA))
        page = embedded(page, self.source, self.out)
        style = self._fonts(page + site) + css + DARK.format(dark_values(page))
        return page.replace("/* style */", style, 1)

    def with_figures(self, page: str) -> str:
        """Embed the figures that the page refers to."""
        return with_pictures(page, self._picture)

    def _fonts(self, page: str) -> str:
        """Return the font rules; fonts are subset again only if the characters have changed."""
        from fieldreport.build.webfonts import code_points, faces_of

        points = code_points(page)
        key = json_digest(
            {
                "points": [sorted(some) for some in points],
                "versions": versions(),
                "code": code_digests("fieldreport.build.webfonts"),
            }
        )
        steps, path = Steps(self.out), self.out / ".state" / "fonts.css"
        if not steps.done("fonts", key):
            write_atomically(path, faces_of(*points).encode())
            steps.record("fonts", key, [path])
        return path.read_text(encoding="utf-8")

    def _picture(self, figure: str, alt: str, width: str) -> str:
        path = screen_file(self.out, figure)
        if path.suffix == ".webp":
            return raster(address(path), alt, width)
        return element(path.read_text(encoding="utf-8"), path.stem, alt, width)


WRONG_FORMULA = re.compile(
    r"Could not convert TeX math\s+(.*?)\s*, rendering as TeX:"
    r".*?unexpected (?:control sequence )?(\S+)",
    re.S,
)
"""The formula and the part of it that pandoc does not understand."""
LABEL = re.compile(r"<(\w+:[\w-]+)>")
"""A label in an error of Typst."""
UPRIGHT_NABLA = '<mi mathvariant="normal">∇</mi>'
"""Without this, a browser would slant the operator like a variable."""
DARK = "@media screen and (prefers-color-scheme: dark) {{ :root {{ {0}}} }}\n"
QUOTATION = re.compile(r"\{\{(\w+)\.(params\.)?(\w+)(?::[^{}]*)?\}\}")


def pandoc() -> Path:
    """Return the path of pandoc in the wheel, even if another pandoc is installed."""
    import pypandoc

    name = "pandoc.exe" if sys.platform == "win32" else "pandoc"
    return Path(pypandoc.__file__).parent / "files" / name


def typeset(source: Path, root: Path) -> bytes:
    """Return the PDF of a Typst file that reads files below `root`, without a date.

    Raises
    ------
    BuildError
        Typst reported an error or a warning.
    """
    import typst

    fonts = typst.Fonts(include_system_fonts=False)
    compiler = typst.Compiler(str(source), root=str(root), font_paths=fonts)
    try:
        pdf, warnings = compiler.compile_with_warnings(
            format="pdf", timestamp=NO_DATE, pdf_standards=[PDF_STANDARD]
        )
    except typst.TypstError as error:
        raise BuildError(f"typst: {error.diagnostic}") from error
    if warnings:
        raise BuildError("\n".join(f"typst: {warning.diagnostic}" for warning in warnings))
    return cast(bytes, pdf)


def unquoted_facts(chapters: list[Path], values: Mapping[str, Any]) -> dict[str, list[str]]:
    """List the facts that no chapter quotes, for each experiment that has some."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in chapters)
    quoted = {(name, fact) for name, params, fact in QUOTATION.findall(text) if not params}
    left = {
        name: [fact for fact in experiment["facts"] if (name, fact) not in quoted]
        for name, experiment in values.items()
    }
    return {name: facts for name, facts in left.items() if facts}


def _all_lines(*errors: BaseException | None) -> list[str]:
    """Return the lines of all errors, each once, in order."""
    found: dict[str, None] = {}
    for error in errors:
        if isinstance(error, BuildError):
            found |= dict.fromkeys(str(error).splitlines())
        elif error is not None:
            raise error
    return list(found)
