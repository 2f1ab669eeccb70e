"""Living figures on the page: their data as JSON, and one script.

Only what the page names is embedded: the shared files of the scripts, once, and for each living
figure its own script and its data.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

EMBEDDED: Final = re.compile(r'data-widget="(\w+)"')
SCRIPTS: Final = "<!-- widgets -->"
"""The place of data and scripts in the template."""


def data_file(out: Path, name: str) -> Path:
    """Return the path of the data of a living figure."""
    return out / "widgets" / f"{name}.json"


def embedded(page: str, source: Path, out: Path) -> str:
    """Return the page with the data and the scripts of its living figures.

    Parameters
    ----------
    page : str
        HTML with elements ``data-widget="NAME"``.
    source : Path
        The folder with ``widgets/shared/*.js`` and ``widgets/NAME.js``.
    out : Path
        The build folder with the data.
    """
    names = list(dict.fromkeys(EMBEDDED.findall(page)))
    parts = [_data_element(out, name) for name in names]
    return page.replace(SCRIPTS, "\n".join([*parts, script(source, names)]) if names else "", 1)


def script(source: Path, names: Sequence[str]) -> str:
    """Return one script with the shared files and those of the named living figures.

    Each living figure has a block of its own, so that the names it declares stay there.
    """
    folder = source / "widgets"
    shared = [path.read_text(encoding="utf-8") for path in sorted((folder / "shared").glob("*.js"))]
    own = ["{\n" + (folder / f"{name}.js").read_text(encoding="utf-8") + "}\n" for name in names]
    return "\n".join(
        ['<script>\n(() => {\n"use strict";', *shared, *own, "begin();\n})();\n</script>"]
    )


def _data_element(out: Path, name: str) -> str:
    # "<" would end the element if a text of the data contained "</script>"
    text = data_file(out, name).read_text(encoding="utf-8").replace("<", "\\u003c")
    return f'<script type="application/json" id="widget-{name}">{text}</script>'
