"""The page *How to cite*, from CITATION.cff."""

from pathlib import Path

import yaml

PAGE = """\
# How to cite

If fieldrecon is of use in your work, please cite it in the version that you
used.

> {authors}: *{title}*. Version {version}. Software, {license} licence.

```bibtex
@software{{fieldrecon,
  author  = {{{{{authors}}}}},
  title   = {{{{{title}}}}},
  version = {{{version}}}
}}
```

The file [`CITATION.cff`](files/CITATION.cff) has the same in the Citation File Format, which
reference managers and code hosts read.

For a proof, a comparison or a figure, please cite the report, with the date on its first page:

> {authors}: *{report}*. Report of fieldrecon, version {version}.

## Sources

Please cite the works whose methods you use. The library follows

{references}

Each page of the reference names the work and the page that its formula comes from.
"""


def page(root: Path) -> str:
    """Return the page in Markdown."""
    cited = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    report = (root / "report" / "metadata.yaml").read_text(encoding="utf-8")
    authors = " and ".join(author["name"] for author in cited["authors"])
    return PAGE.format(
        authors=authors,
        title=cited["title"],
        report=yaml.safe_load(report)["title"],
        version=cited["version"],
        license=cited["license"],
        references="\n".join(f"- {reference(work)}" for work in cited["references"]),
    )


def reference(work: dict) -> str:
    """Return a work as authors, title, and publisher or institution with the year."""
    authors = ", ".join(f"{who['given-names']} {who['family-names']}" for who in work["authors"])
    where = work.get("publisher") or work.get("institution")
    year = f", {work['year']}" if "year" in work else ""
    return f"{authors}: *{work['title']}*. {where['name']}{year}."
