"""A small report for tests: two fake experiments, a short text, and builds in this process."""

import argparse
import importlib
import shutil
import sys
from contextlib import nullcontext
from pathlib import Path

from checkout import ROOT
from fieldrecon._core.chunks import Inline
from fieldreport import experiments
from fieldreport.build import code_dependencies, rerun
from fieldreport.commands.report import add_arguments, main

REPORT = ROOT / "report"

FAKE = '''"""A line of the power {name}."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldreport.framework.experiment import Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter
from fieldrecon.plotting.style import figure, line

SCALE = 1.0


@dataclass(frozen=True)
class Params(Parameters):
    points: int = parameter(1000, "number of points")
    epsilon: float = parameter(0.0012, "a small length")
    powers: tuple[int, ...] = parameter((1, 2, 3), "powers")
    seed: int = parameter(7, "seed")


QUICK = Params(points=10)


def run(params, each=map):
    with Path("{log}").open("a") as file:
        file.write("run {name}\\n")
    x = np.linspace(0, 1, 5)
    rows = tuple((k, SCALE * params.epsilon * 10.0**-k, "yes") for k in range(3))
    return Result(
        params,
        {{"errors": ResultTable(("k", "error [m]", "exact"), rows)}},
        dict(small=params.epsilon, ratio=-2.5, count=12345, rounding=1e-16, word="fine"),
        {{"x": x}},
    )


def plot(result):
    """Draw the line."""
    with Path("{log}").open("a") as file:
        file.write("draw {name}\\n")
    with figure(height=2) as (page, axes):
        axes.plot(result.arrays["x"], result.arrays["x"] ** 2, **line("MLS"))
    return page
'''

CHAPTER = """# Beginning {{#sec:beginning}}

The error is {{{{fake_a.small:.1e}}}} with {{{{fake_a.params.points}}}} points,
see @fig:a, @tbl:errors and [@eq:one].

$$ \\varepsilon = {{{{fake_a.small:.1e}}}}, \\quad n = {{{{fake_a.params.points}}}} $$ {{#eq:one}}

![The square, of {{{{fake_a.count}}}} points.](fake_a.svg){{#fig:a
alt="A parabola that rises from zero to one,
with error {{{{fake_a.small:.1e}}}}."}}

::: {{.result #tbl:errors experiment=fake_a table=errors
     columns="k; error [m]; exact" heads="$k$; error [m]; exact?" formats="; .2e; "}}
Errors for $\\varepsilon = {{{{fake_a.params.epsilon}}}}$.
:::

{body}
"""
REFERENCES = """# References {#sec:refs .unnumbered}

::: {#refs}
:::
"""


class SmallReport:
    """A report in a folder, with its experiments and a log of their calls."""

    def __init__(self, folder: Path, monkeypatch) -> None:
        self.folder = folder
        self.source, self.log = folder / "text", folder / "log"
        self.code = folder / "code" / "topic"
        self.code.mkdir(parents=True)
        self.log.touch()
        shutil.copytree(REPORT, self.source, ignore=shutil.ignore_patterns("build", "chapters"))
        (self.source / "experiments.toml").write_text("")
        for name in ("fake_a", "fake_b"):
            self.write_experiment(name)
        self.write_chapter()
        # A change within the same second that keeps the length would leave the compiled file valid.
        monkeypatch.setattr(sys, "dont_write_bytecode", True)
        monkeypatch.setattr(rerun, "workers", lambda count: nullcontext(Inline()))  # noqa: ARG005
        monkeypatch.setattr(experiments, "_HERE", self.code.parent)
        monkeypatch.setattr(experiments, "__path__", [str(self.code.parent), *experiments.__path__])

    def write_experiment(self, name: str, *changes: str) -> None:
        """Write an experiment; `changes` alternates old and new text."""
        text = FAKE.format(name=name, log=self.log)
        for old, new in zip(changes[::2], changes[1::2], strict=True):
            assert old in text
            text = text.replace(old, new)
        (self.code / f"{name}.py").write_text(text)

    def write_chapter(self, body: str = "") -> None:
        """Write the only chapter, with an additional paragraph, and the references."""
        (self.source / "chapters").mkdir(exist_ok=True)
        (self.source / "chapters" / "01-all.md").write_text(CHAPTER.format(body=body))
        (self.source / "chapters" / "99-references.md").write_text(REFERENCES)

    def build(self, *options: str) -> int:
        """Build with cleared caches, as in a new process, and return the exit status."""
        for name in [n for n in sys.modules if n.startswith("fieldreport.experiments.topic")]:
            del sys.modules[name]
        code_dependencies.clear_caches()
        importlib.invalidate_caches()
        return main(self.options(*options))

    def options(self, *options: str) -> argparse.Namespace:
        """Return the options of a build."""
        parser = argparse.ArgumentParser()
        add_arguments(parser)
        return parser.parse_args(["--source", str(self.source), "--jobs=1", *options])

    def did(self) -> list[str]:
        """Return the logged calls of the experiments since the last call."""
        lines = self.log.read_text().splitlines()
        self.log.write_text("")
        return lines

    @property
    def out(self) -> Path:
        """The build folder."""
        return self.source / "build"

    def outputs(self, out: Path | None = None) -> dict[str, bytes]:
        """Return the bytes of all outputs."""
        out = out or self.out
        return {
            str(path.relative_to(out)): path.read_bytes()
            for path in sorted(out.rglob("*"))
            if path.is_file() and path.relative_to(out).parts[0] not in {".state", ".lock"}
        }
