"""Files of the figures for the screen: an SVG with letters as text, or a raster if it is long.

The one-file page and the chapters of the site contain them. They are drawn by pinned workers, as
the printed figures are, so that their bytes are the same everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import Colormap, ListedColormap

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.blas_threads import one_blas_thread
from fieldrecon._core.digests import json_digest
from fieldrecon.plotting.figure_files import figure_bytes
from fieldreport import experiments
from fieldreport.build import rerun
from fieldreport.build.code_dependencies import code_digests
from fieldreport.build.pinned_kernels import pins
from fieldreport.build.rerun import ExperimentJob
from fieldreport.build.screen_figures import EMBEDDED, PAPER, light, webp
from fieldreport.build.step_records import Steps, content_digest
from fieldreport.framework.result_files import read_result

LARGE: Final = 250_000
"""Length of a figure as text, without rasters in it, above which it becomes a raster."""
CROWD: Final = 3000
"""More markers become a raster within their frame, if the figure is too long."""
CONTRAST: Final = 3
"""Contrast with the dark page of markers whose colours stand for amounts, by WCAG 2."""
FAINTEST: Final = 0.6
"""The least opacity of such markers."""


def compute(
    jobs: Iterable[ExperimentJob], steps: Steps, processes: int, progress: Any
) -> list[Path]:
    """Bring the files of all figures up to date; return them."""
    keys = {(job, figure): _key(job, figure) for job in jobs for figure in job.experiment.plots}
    outdated = [one for one, key in keys.items() if not steps.done(f"screen-{one[1]}", key)]
    if outdated:
        progress.add(len(outdated))
        with rerun.workers(min(processes, len(outdated))) as pool:
            futures = [(*one, pool.submit(_drawn, one[0].folder, one[1])) for one in outdated]
            for job, figure, future in futures:
                path = _written(steps.out, job.name, figure, future)
                steps.record(f"screen-{figure}", keys[job, figure], [path])
                progress.done(f"drew {figure} for the screen")
    return sorted(path for _, figure in keys for path in steps.made(f"screen-{figure}"))


def _key(job: ExperimentJob, figure: str) -> str:
    printed = content_digest(job.figure_file(figure))
    return json_digest({"printed": printed, "code": code_digests(__name__), "pins": pins()})


def _written(out: Path, experiment: str, figure: str, future: Future) -> Path:
    suffix, content = future.result()
    path = out / "screen" / experiment / f"{figure}{suffix}"
    path.with_suffix(".webp").unlink(missing_ok=True)  # it would be taken for the current one
    return write_atomically(path, content)


def _drawn(folder: Path, figure: str) -> tuple[str, bytes]:
    """Return suffix and content of a figure: SVG, or a raster twice as fine as it is shown."""
    experiment = experiments.get(folder.name)
    with one_blas_thread():
        drawn = experiment.plots[figure](read_result(folder, experiment))
        drawn.svg_fonttype = "none"
        _brighten_markers(drawn)
        picture = _vectors(drawn)
        if _long(picture):
            _draw_crowds_as_rasters(drawn)
            picture = _vectors(drawn)
        if not _long(picture):
            return ".svg", picture.encode()
        raster = webp(figure_bytes(drawn, "png"))
    return (".webp", raster) if len(raster) < len(picture) else (".svg", picture.encode())


def _brighten_markers(drawn: Any) -> None:
    """Let markers whose colours stand for amounts be seen on the ground of a dark page.

    Their colours agree with a colour bar, or are in a raster, so they are the same on both pages.
    """
    for axes in drawn.axes:
        for markers in axes.collections:
            if _has_amounts(markers) and isinstance(markers, PathCollection) and not _is_map(axes):
                bright = bright_part(markers.get_cmap())
                with markers.callbacks.blocked():  # a colour bar that follows loses its ticks
                    markers.set_cmap(bright)
                if markers.colorbar and markers.colorbar.solids:
                    markers.colorbar.solids.set_cmap(bright)


def _is_map(axes: Axes) -> bool:
    areas = (one for one in axes.collections if not isinstance(one, PathCollection))
    return bool(axes.images) or any(map(_has_amounts, areas))


def _has_amounts(drawn: Any) -> bool:
    return drawn.get_array() is not None


def bright_part(colors: Colormap) -> Colormap:
    """Return the colours of a map that have contrast with the dark page."""
    shown = colors(np.linspace(0, 1, 256))
    bright = shown[(_luminance(shown[:, :3]) + 0.05) / (_luminance(PAPER / 255) + 0.05) >= CONTRAST]
    bright[:, 3] = np.maximum(bright[:, 3], FAINTEST)
    return ListedColormap(bright) if len(bright) else colors


def _luminance(colors: Any) -> Any:
    """Return the relative luminance, as WCAG 2 defines it, of colours or of greys in [0, 1]."""
    linear = np.where(
        np.asarray(colors) <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4
    )
    return linear @ [0.2126, 0.7152, 0.0722] if linear.ndim else linear


def _vectors(drawn: Any) -> str:
    return light(figure_bytes(drawn, "svg").decode())


def _long(picture: str) -> bool:
    return len(EMBEDDED.sub("", picture)) > LARGE


def _draw_crowds_as_rasters(drawn: Any) -> None:
    """Let rasters show many markers and the ground behind them, which stays on a dark page."""
    for axes in drawn.axes:
        if any(len(markers.get_offsets()) > CROWD for markers in axes.collections):
            for artist in (axes.patch, *axes.collections):
                artist.set_rasterized(True)
