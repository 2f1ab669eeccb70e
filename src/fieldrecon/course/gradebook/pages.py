"""Pages that stand for themselves: no script, no network, light and dark, and fit to be printed."""

from __future__ import annotations

import base64
import subprocess
from html import escape
from pathlib import Path
from string import Template

from fieldrecon.reporting.document import pandoc

TEMPLATE = Path(__file__).parent / "page.html"


def page(title: str, subtitle: str, body: str) -> str:
    """Return a page; title and subtitle are text, the body is HTML."""
    form = Template(TEMPLATE.read_text(encoding="utf-8"))
    return form.substitute(title=escape(title), subtitle=escape(subtitle), body=body)


def picture(svg: str, alt: str) -> str:
    """Return a drawing as an image: within an image nothing is run."""
    content = base64.b64encode(svg.encode()).decode()
    return f'<img src="data:image/svg+xml;base64,{content}" alt="{escape(alt)}">'


def rendered(markdown: str) -> str:
    """Return Markdown of the course's own as HTML, with its formulas; never that of a student.

    Raises
    ------
    ValueError
        Pandoc does not understand it.
    """
    command = [
        str(pandoc()), "--from=markdown", "--to=html5", "--mathml", "--sandbox",
        "--fail-if-warnings",
    ]  # fmt: skip
    run = subprocess.run(
        command, input=markdown, capture_output=True, text=True, encoding="utf-8", check=False
    )
    if run.returncode:
        raise ValueError(f"pandoc: {run.stderr.strip()}")
    return run.stdout
