"""What a user gets for a file of samples: the grid, its picture, and how well each method fits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.experiments.files import csv_bytes, npz_bytes, write_atomically, write_figure
from fieldrecon.gridding import Grid, Trial
from fieldrecon.reporting.style import METHOD_COLORS, figure
from fieldrecon.samples import Samples

PICTURE_FORMATS = ("png", "svg")
METHODS = ("method", "what it is", "rms error", "largest error", "remark")


def write_reconstruction(
    folder: Path, samples: Samples, grid: Grid, trials: list[Trial], chosen: Trial
) -> list[Path]:
    """Write ``grid.csv``, ``grid.npz``, ``methods.csv`` and the picture; return the files."""
    columns = (*samples.names, "extrapolated")
    arrays = {"x": grid.x, "y": grid.y, "values": grid.values, "extrapolated": grid.extrapolated}
    return [
        write_atomically(folder / "grid.csv", csv_bytes(columns, _grid_rows(grid))),
        write_atomically(folder / "grid.npz", npz_bytes(arrays)),
        write_atomically(folder / "methods.csv", csv_bytes(METHODS, _method_rows(trials))),
        *write_figure(
            plot(samples, grid, trials, chosen), folder / "reconstruction", PICTURE_FORMATS
        ),
    ]


def _method_rows(trials: Iterable[Trial]) -> Iterator[tuple[str, str, object, object, str]]:
    """Yield a row for each method: its errors at samples left out, or why there are none."""
    for trial in sorted(trials, key=lambda trial: trial.rms):
        errors = ("", "") if trial.residuals is None else (trial.rms, trial.largest)
        yield trial.candidate.name, trial.candidate.meaning, *errors, trial.reason


def _grid_rows(grid: Grid) -> Iterator[tuple[float, float, float, int]]:
    nodes = grid.nodes.tolist()
    for (x, y), value, outside in zip(
        nodes, grid.values.ravel().tolist(), grid.extrapolated.ravel().tolist(), strict=True
    ):
        yield x, y, value, int(outside)


def plot(samples: Samples, grid: Grid, trials: list[Trial], chosen: Trial) -> Figure:
    """Draw field and samples, hatched where extrapolated, and the errors of the methods."""
    with figure(height=3.3, columns=2, width_ratios=[2.1, 1]) as (page, (field, bars)):
        _draw_field(page, field, samples, grid)
        field.set_title(chosen.candidate.meaning)
        _draw_errors(bars, trials, chosen)
        bars.set_xlabel("rms error where left out")
    return page


def _draw_field(page: Figure, axes: Axes, samples: Samples, grid: Grid) -> None:
    edges = (*_outer(grid.x), *_outer(grid.y))
    # Wild values where nothing was measured must not take the colours from where something was.
    inside = grid.values if grid.extrapolated.all() else grid.values[~grid.extrapolated]
    picture = axes.imshow(
        grid.values,
        extent=edges,
        vmin=inside.min(),
        vmax=inside.max(),
        interpolation="bilinear",
        aspect="auto",
    )
    if np.ptp(grid.values) > 1e-9 * np.abs(grid.values).max():
        axes.contour(grid.x, grid.y, grid.values, 10, colors="white", linewidths=0.4, alpha=0.7)
    if grid.extrapolated.any():
        outside = grid.extrapolated.astype(float)
        axes.contourf(grid.x, grid.y, outside, [0.5, 1.5], colors=["#ffffff66"], hatches=["////"])
        axes.contour(grid.x, grid.y, outside, [0.5], colors="black", linewidths=0.7)
    # Thousands of samples are dust that must not hide the field.
    size = float(np.clip(40 / np.sqrt(len(samples.points)), 0.2, 3.0))
    axes.plot(*samples.points.T, ".", markersize=size, markeredgewidth=0, color="black")
    axes.set(xlabel=samples.names[0], ylabel=samples.names[1], xlim=edges[:2], ylim=edges[2:])
    if 0.4 < np.ptp(grid.y) / np.ptp(grid.x) < 2.5:
        axes.set_aspect("equal")
    axes.ticklabel_format(useOffset=False, style="plain")  # as on a map, every metre told
    axes.grid(visible=False)
    page.colorbar(picture, ax=axes, label=samples.names[2], extend="both", shrink=0.85)


def _draw_errors(axes: Axes, trials: list[Trial], chosen: Trial) -> None:
    tried = sorted((t for t in trials if t.residuals is not None), key=lambda t: -t.rms)
    names = [t.candidate.name for t in tried]
    colors = [METHOD_COLORS[t.candidate.family] for t in tried]
    axes.barh(names, [t.rms for t in tried], color=colors)
    axes.get_yticklabels()[tried.index(chosen)].set_fontweight("bold")
    axes.set_title("methods (bold: drawn)")
    axes.set_xlim(left=0)
    axes.locator_params(axis="x", nbins=3)
    axes.xaxis.set_major_formatter("{x:.3g}")
    axes.grid(visible=False, axis="y")


def _outer(ticks: np.ndarray) -> tuple[float, float]:
    """Return the outer edges of cells of which the ticks are the middles."""
    half = (ticks[1] - ticks[0]) / 2
    return ticks[0] - half, ticks[-1] + half
