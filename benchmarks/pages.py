"""Result files: JSON for programs, and one Markdown page with charts for readers."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

PREFACE = """# Results of the benchmarks

Written by `make bench`. A ratio is the time of fieldrecon divided by that of the peer in the same
round, on the same machine; given are the median and the range over the rounds. Below one,
fieldrecon is faster. Seconds are for orientation only. What is compared, and why the numbers are
what they are, stands in [docs/performance.md](../../docs/performance.md).
"""


def write(name: str, result: Mapping, folder: Path) -> None:
    """Write one result, and the page with all results in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps(result, indent=2, ensure_ascii=False) + "\n")
    if result.get("charts"):
        from benchmarks import charts  # imports Matplotlib only where it is needed

        charts.draw(result, folder / f"{name}.svg")
    read = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))}
    sections = [section(result, f"{name}.svg") for name, result in read.items()]
    (folder / "README.md").write_text("\n".join([PREFACE, *sections]))


def with_tables(text: str, folder: Path) -> str:
    """The text with each table below <!-- table N of NAME --> replaced by that of the results."""

    def marked(match: re.Match[str]) -> str:
        file = folder / f"{match['name']}.json"
        if not file.exists():
            return match[0]
        result = json.loads(file.read_text())
        table = result["tables"][int(match["number"]) - 1]
        return f"{match['mark']}\n{_table(table['columns'], table['rows'])}\n"

    mark = r"(?P<mark><!-- table (?P<number>\d+) of (?P<name>\w+) -->)\n(\|.*\n)*"
    return re.sub(mark, marked, text)


def section(result: Mapping, figure: str | None = None) -> str:
    """One benchmark in Markdown; `figure` is the file of its charts."""
    parts = [f"## {result['title']}", _listed(result["parameters"])]
    if result["comparisons"]:
        rows = [_compared(c) for c in result["comparisons"]]
        columns = ("what", "against", "ratio", "range", "at most", "s", "s of peer")
        parts.append(_table(columns, rows))
    for table in result["tables"]:
        parts += [f"{table['caption']}:", _table(table["columns"], table["rows"])]
    if figure and result.get("charts"):
        parts.append(f"![{'; '.join(chart['title'] for chart in result['charts'])}]({figure})")
    parts += result["notes"]
    parts.append("Measured on: " + _listed(result["machine"]))
    return "\n\n".join(parts) + "\n"


def _compared(c: Mapping) -> tuple[str, ...]:
    limit = c["at_most"]
    met = "" if limit is None else f"{_ratio(limit)} ({_kept(c['ratio'] <= limit)})"
    spread = f"{_ratio(c['least'])}–{_ratio(c['most'])}"
    seconds = _cell(c["seconds"]), _cell(c["seconds_of_peer"])
    return (_separated(c["what"]), c["peer"], _ratio(c["ratio"]), spread, met, *seconds)


def _ratio(number: float) -> str:
    return f"{number:.2f}" if number >= 0.095 else f"{number:.2g}"


def _kept(is_kept: bool) -> str:
    return "met" if is_kept else "NOT met"


def _table(columns: Sequence[str], rows: Sequence[Sequence]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)


def _cell(value: object) -> str:
    if not isinstance(value, float):
        return _separated(value)
    three = f"{value:.3g}"
    return f"{float(three):,.0f}" if 1e3 <= abs(value) < 1e6 else three


def _separated(value: object) -> str:
    """A text with commas between thousands: 1,000,000 sites."""
    return re.sub(r"(?<![\d.,])\d{4,}(?![\d.])", lambda number: f"{int(number[0]):,}", str(value))


def _listed(mapping: Mapping) -> str:
    return "; ".join(f"{key.replace('_', ' ')}: {_value(v)}" for key, v in mapping.items()) + "."


def _value(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else _separated(value)
