"""What a finished site must fulfil: no network, no broken link, and no page over one megabyte."""

import re
from html import unescape
from pathlib import Path
from urllib.parse import unquote

LIMIT = 1_000_000
"""Bytes of a page with all that it loads."""

REQUEST = re.compile(
    r"""<(?:script|img|iframe|video|source)\b[^>]*\bsrc=["'](?:https?:)?//"""
    r"""|<link\b(?=[^>]*\brel=["'](?:stylesheet|preload|preconnect|icon))"""
    r"""[^>]*href=["'](?:https?:)?//"""
)
STYLE_REQUEST = re.compile(r"""(?:@import|url\()\s*["']?(?:https?:)?//""")
LINK = re.compile(r'<a\b[^>]*\bhref="([^"]*)"')
TARGET = re.compile(r'\b(?:id|name)="([^"]+)"')
LOADED = re.compile(
    r'<(?:script|img)\b[^>]*\bsrc="([^"]+)"|<link rel="stylesheet"[^>]*href="([^"]+)"'
)
NOT_LOADED = re.compile(r"<div[^>]* data-widget=.*?</figure>", flags=re.S)
"""Hidden pictures, behind living figures, are loaded when they are shown."""


def problems(site: Path) -> list[str]:
    """Return a sentence for each thing that is wrong."""
    pages = sorted(site.rglob("*.html"))
    texts = {page: page.read_text(encoding="utf-8") for page in pages}
    found = [f"{path} asks the network" for path in sorted(site.rglob("*")) if asks_network(path)]
    return [*found, *broken_links(texts), *heavy_pages(texts)]


def asks_network(path: Path) -> bool:
    """Tell whether a page or a style loads a script, a picture or a style from another host."""
    if path.suffix not in {".html", ".css"}:
        return False
    pattern = REQUEST if path.suffix == ".html" else STYLE_REQUEST
    return bool(pattern.search(path.read_text(encoding="utf-8")))


def broken_links(texts: dict[Path, str]) -> list[str]:
    """Return the links to files and to places in pages that do not exist."""
    targets = {page: set(map(unescape, TARGET.findall(text))) for page, text in texts.items()}
    broken = []
    for page, text in texts.items():
        for link in set(LINK.findall(text)):
            name, _, place = unquote(unescape(link)).partition("#")
            if ":" in name:
                continue
            to = (page.parent / name).resolve() if name else page
            known = to in targets and (not place or place in targets[to])
            if not (known or (to not in targets and to.is_file())):
                broken.append(f"{page} has a broken link: {link}")
    return broken


def heavy_pages(texts: dict[Path, str]) -> list[str]:
    """Return the pages that load more than the limit."""
    weights = {page: weight(page, text) for page, text in texts.items()}
    return [f"{page} loads {w} bytes" for page, w in weights.items() if w > LIMIT]


def weight(page: Path, text: str) -> int:
    """Return the bytes of a page with its scripts, styles and pictures, each once."""
    names = {
        unquote(unescape(a or b)).partition("?")[0]
        for a, b in LOADED.findall(NOT_LOADED.sub("", text))
    }
    files = {(page.parent / name).resolve() for name in names if ":" not in name}
    return len(text.encode()) + sum(path.stat().st_size for path in files if path.is_file())
