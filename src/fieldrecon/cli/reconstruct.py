"""The command that turns a file of samples into a field at places, for engineers."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from fieldrecon._core.atomic_files import whole_file, write_atomically
from fieldrecon._core.chunks import Progress
from fieldrecon._core.extras import PICTURES, absent
from fieldrecon._core.memory import peak_memory
from fieldrecon.io.netcdf import FORMATS, Result, as_formats
from fieldrecon.io.saved_fields import load_with_names, save
from fieldrecon.io.targets import Places, grid_over, points_in, vertices_of
from fieldrecon.methods.globe import OnGlobe, to_unit
from fieldrecon.pipelines.samples import Samples, read_samples, refuse_flat
from fieldrecon.pipelines.survey import Outcome
from fieldrecon.reconstruction import Field, Reconstruction
from fieldrecon.selection.cross_validation import NO_FIELD, CrossValidator, ModelScore, best
from fieldrecon.selection.extrapolation import extrapolated
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import MODELS
from fieldrecon.selection.prediction_intervals import ErrorEstimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Stage: TypeAlias = Callable[[str], Progress]

_GRID = {2: (200, 200), 3: (50, 50, 50)}
_CAPTIONS = {"reconstruction": "The field", "error": "How far it may be off"}
_STEM = {"nodes": "grid", "points": "points", "vertices": "mesh"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add = parser.add_argument
    add(
        "samples",
        type=Path,
        nargs="?",
        metavar="POINTS",
        help="a table: text (.csv, .txt, .xyz …), .npz or .parquet",
    )
    add("--load", type=Path, metavar="FIELD.npz", help="take a field that --save wrote instead")
    for name in ("x", "y", "z", "value"):
        add(
            f"--{name}",
            metavar="COLUMN",
            help=f"the column that holds {name}" + (", of points in space" if name == "z" else ""),
        )
    add("--lonlat", action="store_true", help="x and y are degrees of longitude and latitude")
    add("--strict", action="store_true", help="stop at a bad row instead of leaving it out")
    add(
        "--method",
        default="best",
        metavar="NAME",
        help=f"{', '.join(MODELS)}, or best (the "
        "default): the one that misses left-out samples least",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--grid", type=_counts, metavar="NXxNY[xNZ]", help="nodes over the samples")
    where.add_argument("--at", type=Path, metavar="FILE", help="the points of a table")
    where.add_argument("--mesh", type=Path, metavar="FILE", help="the vertices of a mesh")
    add(
        "--out",
        type=Path,
        default=Path("reconstruction"),
        metavar="PATH",
        help=f"a file, whose suffix names the format ({', '.join(FORMATS)}), or a folder",
    )
    add("--format", metavar="NAMES", help="formats in the folder, such as csv,npz (the default)")
    add("--save", type=Path, metavar="FIELD.npz", help="keep the fitted field")
    parser.set_defaults(command=reconstruct)


def _counts(text: str) -> tuple[int, ...]:
    counts = (
        tuple(map(int, text.lower().split("x")))
        if re.fullmatch(r"[\dxX]+", text) and (re.fullmatch(r"\d+x\d+(x\d+)?", text.lower()))
        else ()
    )
    if not counts or min(counts) < 2:
        raise argparse.ArgumentTypeError(f"must be such as 200x150, each 2 or more; got {text!r}")
    return counts


def reconstruct(options: argparse.Namespace) -> None:
    """Read, choose, evaluate, write and tell."""
    from fieldrecon.cli.terminal import print_files, print_missing_pictures, print_outcome, stages

    outputs = _outputs(options)
    with stages() as stage:
        outcome = _outcome(options, stage)
        stage("writing")
        written = list(_written(outcome, outputs, options))
    print_outcome(outcome)
    print_files(written)
    print_missing_pictures()


def _outputs(options: argparse.Namespace) -> tuple[Path | None, list[str]]:
    """Find the file that is wanted, None for a folder, and the formats; refuse what cannot be."""
    if (options.samples is None) == (options.load is None):
        raise ValueError("give either a table of samples or --load with a field")
    if options.method not in {"best", *MODELS}:
        raise ValueError(
            f"there is no method {options.method!r}; there are best, {', '.join(MODELS)}"
        )
    suffix = options.out.suffix
    file = options.out if re.fullmatch(r"\.[A-Za-z]\w*", suffix) else None
    named = as_formats([suffix] if file else (options.format or "csv,npz").split(","))
    if file and options.format and as_formats(options.format.split(",")) != named:
        raise ValueError(f"--out {file} names another format than --format {options.format}")
    inputs = {p.resolve() for p in (options.samples, options.load, options.at, options.mesh) if p}
    for path in filter(None, (file, options.save)):
        if path.resolve() in inputs:
            raise ValueError(f"{path} is read, and would be overwritten; choose another name")
    return file, named


def _outcome(options: argparse.Namespace, stage: Stage) -> Outcome:
    began = perf_counter()
    samples, loaded = _loaded(options) if options.load else (_samples(options, stage), None)
    sites = to_unit(samples.points) if samples.lonlat else samples.points
    places = _places(options, samples)
    if loaded is None:
        judge = CrossValidator.of(sites, samples.values)
        trials = _trials(judge, options.method, stage)
        chosen, (field, values) = best(trials, lambda t: _values(t, samples, places, stage))
        judged = judge.n_held_out
    else:
        field, trials, chosen, judged = loaded, [], None, 0
        values = field(places.points, progress=stage("evaluating"))
    band, error = _error(field, sites, samples.lonlat, places, stage)
    stage("looking for gaps")
    there = to_unit(places.points) if samples.lonlat else places.points
    flags = extrapolated(sites, there, samples.lonlat)
    result = Result(samples.names, places, values, error, flags, samples.lonlat)
    source = str((options.samples or options.load).name)
    seconds, memory = perf_counter() - began, peak_memory()
    return Outcome(source, samples, trials, judged, chosen, field, band, result, seconds, memory)


def _samples(options: argparse.Namespace, stage: Stage) -> Samples:
    columns = options.x, options.y, options.value, options.z
    progress = stage("reading")
    samples = read_samples(
        options.samples, *columns, options.lonlat, options.strict, progress=progress
    )
    refuse_flat(samples)
    return samples


def _loaded(options: argparse.Namespace) -> tuple[Samples, Field]:
    """The field of a file, and the samples it was made of."""
    field, names = load_with_names(options.load)
    points, values = field.method.points, field.values
    d = points.shape[1]
    if values.ndim != 1 or values.dtype.kind == "c" or d not in _GRID:
        raise ValueError(
            f"{options.load} must hold one real value at each place of the plane or of space; got "
            f"values of the shape {values.shape} in {d} variables"
        )
    usual = (*"xyz"[:d], "value")
    given = tuple(names) if len(names) == d + 1 else usual
    return Samples(given, points, values, isinstance(field.method, OnGlobe)), field


def _trials(judge: CrossValidator, method: str, stage: Stage) -> list[ModelScore]:
    """Judge the method that is asked for, or all."""
    asked_for = method in MODELS
    candidates = [MODELS[method]] if asked_for else [*MODELS.values()]
    progress, trials = stage("choosing a method"), []
    for done, candidate in enumerate(candidates, 1):
        trials.append(judge.evaluate(candidate, asked_for))
        progress(done, len(candidates))
    return trials


def _places(options: argparse.Namespace, samples: Samples) -> Places:
    d = samples.points.shape[1]
    if options.at:
        return points_in(options.at, samples.names[:-1], samples.lonlat, options.strict)
    if options.mesh:
        return vertices_of(options.mesh, d)
    return grid_over(samples.points, options.grid or _GRID[d], samples.lonlat)


def _values(
    trial: ModelScore, samples: Samples, places: Places, stage: Stage
) -> tuple[Field, np.ndarray]:
    """Fit the method of a trial to all samples, and evaluate it."""
    if trial.maker is None:
        raise ValueError(trial.reason)
    patches = trial.model.family == "PU"
    progress = stage("making patches" if patches else "fitting")
    maker: Callable[..., Reconstruction] = trial.maker
    if patches:
        maker = partial(maker, progress=progress)
    method = OnGlobe(samples.points, maker) if samples.lonlat else maker(samples.points)
    how: dict[str, Any] = {"progress": stage("fitting")} if patches else {}
    field = method.field(samples.values, **how)
    return field, field(places.points, progress=stage("evaluating"))


def _error(
    field: Field, sites: np.ndarray, lonlat: bool, places: Places, stage: Stage
) -> tuple[ErrorEstimate | str, np.ndarray]:
    """How far the field may be off, or why that is not known."""
    progress = stage("leaving out each sample")
    try:
        band = ErrorEstimate(sites, leave_one_out(field.method, field.values, progress=progress))
    except NO_FIELD as error:
        return str(error), np.full(len(places.points), np.nan)
    there = to_unit(places.points) if lonlat else places.points
    return band, band(there, stage("estimating the error"))


def _written(
    outcome: Outcome, outputs: tuple[Path | None, list[str]], options: argparse.Namespace
) -> Iterator[Path]:
    """Write the values, the methods, the pictures and the page; yield the files."""
    from fieldrecon.pages.reconstruction_page import methods_csv, summary
    from fieldrecon.plotting.figure_files import figure_bytes, write_figure

    file, formats = outputs
    stem = _STEM[outcome.result.places.kind]
    for name in formats:
        path = file or options.out / f"{stem}.{name}"
        with whole_file(path) as temporary:
            FORMATS[name](temporary, outcome.result)
        yield path
    if options.save:
        save(options.save, outcome.field, outcome.samples.names)
        yield options.save
    pictures = _pictures(outcome)
    drawn = {_CAPTIONS[name]: figure_bytes(picture, "png") for name, picture in pictures.items()}
    asked = {
        f"--{key}": str(value) if isinstance(value, Path) else value
        for key, value in vars(options).items()
        if key not in ("command", "traceback") and value not in (None, False)
    }
    page = file.with_suffix(".html") if file else options.out / "summary.html"
    if not file:
        yield write_atomically(options.out / "methods.csv", methods_csv(outcome))
        for name, picture in pictures.items():
            yield from write_figure(picture, options.out / name, ("png", "svg"))
    yield write_atomically(page, summary(outcome, drawn, asked).encode())


def _pictures(outcome: Outcome) -> dict[str, Figure]:
    """Draw the field and its error; nothing without the packages that draw."""
    if absent(*PICTURES):
        return {}
    from fieldrecon.plotting.field_pictures import plot, plot_error

    return {"reconstruction": plot(outcome), "error": plot_error(outcome)}
