"""The source files of the site, assembled from where they are kept.

The guides stay in ``docs``, the change log and the rest at the root; a build reads them there. Only
links that leave ``docs`` are changed: to the page of the site, or to a copy of the file.
"""

import html
import json
import os
import re
from pathlib import Path

import api
import citation

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]

ELSEWHERE = {
    "CHANGELOG.md": "changes.md",
    "CONTRIBUTING.md": "contributing.md",
    "examples/README.md": "sample-files.md",
    "benchmarks/results/README.md": "measurements.md",
}
"""Pages that are kept outside ``docs``, with their names on the site."""
HOME = {"README.md": "index.md", "CITATION.cff": "citing.md"}
"""Files whose contents are on another page."""
REPORT = """\
```{toctree}
:hidden:
:caption: Read

report/index
```
"""
REPORT_INDEX = """\
# The report

The report derives the methods, compares them, and answers the questions of the lecture slides.
Below each figure are its data and the command that draws it. `make report` also writes it as one
page and as PDF, without the comparison of speed and the table of all parameters.
"""
LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#)([^)#\s]+)")
NAME = re.compile(r"(?<!`)`fr\.([\w.]+)`(?!`)")
"""A public name in a text, which becomes a link to its page."""
CHAPTER = re.compile(r"(?<![*\[])\*([^*\n]+)\*(?![*\]])")
"""A name in italics, which may be that of a chapter."""
TITLE = re.compile(r'<h2[^>]*>(?:<span class="secno">.*?</span>)?\s*([^<]*)</h2>')
KIND = re.compile(r'<section[^>]* class="level2 (part|appendix)\b')
"""Begins a part of the report, or is one of its appendices."""
PICTURES = {".png", ".svg"}


def assemble(to: Path, report: Path | None) -> None:
    """Write all source files of the site; files whose content is the same keep their time."""
    texts = {path.name: path for path in sorted((ROOT / "docs").glob("*.md"))}
    texts |= {name: ROOT / place for place, name in ELSEWHERE.items()}
    files = {name: linked(place, to).encode() for name, place in texts.items()}
    files |= {path.name: path.read_bytes() for path in sorted((HERE / "pages").iterdir())}
    files |= {name: text.encode() for name, text in api.pages().items()}
    files["citing.md"] = citation.page(ROOT).encode()
    if report:
        files |= {name: named_chapters(files[name].decode(), report).encode() for name in texts}
        files |= report_pages(report)
        files["index.md"] = files["index.md"].replace(b"% report\n", REPORT.encode())
    copied("CITATION.cff", to)
    for name, content in files.items():
        write(to / name, content)
    remove_others(to, set(files))


def report_pages(folder: Path) -> dict[str, bytes]:
    """Return the chapters of the report and their contents."""
    names = json.loads((folder / "contents.json").read_text(encoding="utf-8"))
    chapters = {f"report/{name}.chapter": (folder / f"{name}.html").read_bytes() for name in names}
    groups: dict[str, list[str]] = {"": []}
    for name, chapter in zip(names, chapters.values(), strict=True):
        found = KIND.search(chapter.decode())
        kind = found[1] if found else ""
        if kind in ("part", "appendix"):
            title = title_of(folder / f"{name}.html") if kind == "part" else "Appendices"
            groups.setdefault(title, [])
        groups[[*groups][-1]].append(name)
    contents = [REPORT_INDEX, *(listed(title, some) for title, some in groups.items())]
    return {"report/index.md": "\n".join(contents).encode(), **chapters}


def listed(title: str, names: list[str]) -> str:
    """Return a list of chapters below the title of their part."""
    heading = f"## {title}\n\n" if title else ""
    return f"{heading}```{{toctree}}\n:maxdepth: 1\n\n" + "\n".join(names) + "\n```\n"


def named_chapters(text: str, folder: Path) -> str:
    """Return a guide whose names of chapters, as ``*Least squares*``, are links to them."""
    names = json.loads((folder / "contents.json").read_text(encoding="utf-8"))
    of_title = {title_of(folder / f"{name}.html"): name for name in names}

    def link(title: re.Match[str]) -> str:
        name = of_title.get(title[1])
        return f"[{title[0]}](report/{name}.chapter)" if name else title[0]

    return CHAPTER.sub(link, text)


def title_of(chapter: Path) -> str:
    """Return the title of a chapter, without its number."""
    title = TITLE.search(chapter.read_text(encoding="utf-8"))
    return html.unescape(title[1]) if title else ""


def linked(place: Path, to: Path) -> str:
    """Return a page whose links lead to pages of the site and to copies of other files."""
    return linked_text(place.read_text(encoding="utf-8"), place, to)


def linked_text(text: str, place: Path, to: Path) -> str:
    """Return the text of a file with the links of the site, and with public names as links."""

    def target(link: re.Match[str]) -> str:
        inside = os.path.relpath(place.parent / link[1], ROOT)
        if inside.startswith("docs/") and inside.endswith(".md"):
            return inside.removeprefix("docs/")
        name = (ELSEWHERE | HOME).get(inside)
        return name or copied(inside, to)

    def name(code: re.Match[str]) -> str:
        known = code[1] in api.documented()
        return f"{{py:obj}}`fr.{code[1]} <fieldrecon.{code[1]}>`" if known else code[0]

    parts = re.split(r"(^```.*?^```)", text, flags=re.M | re.S)
    return "".join(
        part if part.startswith("```") else NAME.sub(name, LINK.sub(target, part)) for part in parts
    )


def copied(inside: str, to: Path) -> str:
    """Copy a file of the checkout beside the pages; return the link to it."""
    folder = "images" if Path(inside).suffix in PICTURES else "files"
    name = f"{folder}/{inside.removeprefix('docs/images/').replace('/', '-').lstrip('.')}"
    write(to / name, (ROOT / inside).read_bytes())
    return name


def write(path: Path, content: bytes) -> None:
    """Write a file, unless it has this content already."""
    if not (path.exists() and path.read_bytes() == content):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def remove_others(folder: Path, names: set[str]) -> None:
    """Remove pages of an earlier build whose sources are gone."""
    examples = {path.stem for path in (ROOT / "examples" / "gallery").glob("*.py")}
    for path in folder.glob("gallery/plot_*"):
        if path.name.partition(".")[0] not in examples:
            path.unlink()
    for path in [*folder.glob("*.md"), *folder.glob("api/**/*.rst"), *folder.glob("report/*")]:
        if path.relative_to(folder).as_posix() not in names:
            path.unlink()
