"""Publish solved notebooks as HTML and PDF, without a network."""

from __future__ import annotations

import base64
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from fieldgrade.authoring.build import solved_file
from fieldgrade.authoring.sources import Source
from fieldreport.build.errors import BuildError
from fieldreport.build.typesetting import UPRIGHT_NABLA, pandoc, typeset
from fieldreport.build.webfonts import font_faces

TEMPLATE = Path(__file__).parent / "template"
STYLE = """
.output pre { border: 0; background: none; border-left: 3px solid var(--line); border-radius: 0; }
.output { margin-top: -.6em; } img { max-width: 100%; height: auto; background: #fff; }
details { border-left: 3px solid var(--line); padding-left: 1em; }
summary { cursor: pointer; color: var(--accent); }
"""


def publish(root: Path, source: Source, out: Path) -> Iterator[Path]:
    """Write the solved notebook of a source as HTML and as PDF, and yield the files.

    Raises
    ------
    BuildError
        Pandoc or Typst reported an error or a warning.
    """
    out.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as scratch:
        folder = Path(scratch)
        _export(solved_file(root, source), folder)
        page = _pandoc(root, source, folder, "html5").replace("<mi>∇</mi>", UPRIGHT_NABLA)
        css = (root / "report/style.css").read_text(encoding="utf-8") + STYLE
        html = out / f"{source.name}.html"
        page = page.replace("/* style */", font_faces(page) + css, 1)
        html.write_text(_with_pictures(page, folder), encoding="utf-8")
        yield html
        (folder / "page.typ").write_text(_pandoc(root, source, folder, "typst"), encoding="utf-8")
        pdf = out / f"{source.name}.pdf"
        pdf.write_bytes(typeset(folder / "page.typ", folder))
        yield pdf


def _export(notebook: Path, folder: Path) -> None:
    """Write the notebook as Markdown with its pictures, by the template of the course."""
    from nbconvert import MarkdownExporter

    exporter = MarkdownExporter(
        template_name=TEMPLATE.name,
        extra_template_basedirs=[str(TEMPLATE.parent)],
        template_file="index.md.j2",
        filters={"picture_title": picture_title},
    )
    body, resources = exporter.from_filename(str(notebook))
    (folder / "page.md").write_text(body, encoding="utf-8")
    for name, content in resources["outputs"].items():
        (folder / name).write_bytes(content)


def picture_title(code: str) -> str:
    r"""Return a description of a picture, from the name of the function that draws it.

    Examples
    --------
    >>> picture_title("@draw()\ndef plane_and_points():\n    ...")
    'plane and points'
    """
    names = re.findall(r"^def (\w+)\(", code, flags=re.MULTILINE)
    return names[-1].replace("_", " ") if names else "picture"


def _pandoc(root: Path, source: Source, folder: Path, to: str) -> str:
    suffix = "typ" if to == "typst" else "html"
    command = [
        str(pandoc()),
        "--from=markdown-implicit_figures",
        f"--to={to}",
        "--standalone",
        "--wrap=none",
        f"--template=template.{suffix}",
        "--mathml",
        f"--metadata=title:{source.title}",
        "--metadata=lang:en",
        "--metadata=subtitle:Solved exercises",
        f"--lua-filter={TEMPLATE / 'notebook.lua'}",
        "--fail-if-warnings",
        *(["--toc", "--toc-depth=3"] if to != "typst" else []),
        str(folder / "page.md"),
    ]
    # Run in the report's folder, whose Lua filters are used: Lua's search path gives ";" and "?" a
    # meaning, so it cannot contain every absolute path.
    run = subprocess.run(
        command, cwd=root / "report", capture_output=True, text=True, encoding="utf-8", check=False
    )
    if run.returncode:
        raise BuildError(f"{source.path.name}: {run.stderr.strip()}")
    return run.stdout


def _with_pictures(page: str, folder: Path) -> str:
    """Return the page with embedded pictures."""

    def inside(match: re.Match[str]) -> str:
        content = base64.b64encode((folder / match[1]).read_bytes()).decode()
        return f'src="data:image/svg+xml;base64,{content}"'

    return re.sub(r'src="(output_\w+\.svg)"', inside, page)
