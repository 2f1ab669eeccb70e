"""The command ``fieldrecon reconstruct``: from a table of samples to a field at targets."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fieldrecon._core.atomic_files import check_writable, write_atomically
from fieldrecon._core.extras import PICTURES, absent
from fieldrecon.cli.console import (
    as_parameters,
    print_files,
    print_missing_pictures,
    print_table,
    say,
)
from fieldrecon.cli.progress import stages
from fieldrecon.io.saved_fields import save
from fieldrecon.io.values import FORMATS, as_formats
from fieldrecon.pages.reconstruction_page import COLORS, as_png, methods_csv, pictures, summary
from fieldrecon.pipelines.survey_results import SurveyResult
from fieldrecon.pipelines.surveys import reconstruct as reconstruct_samples
from fieldrecon.plotting.figure_files import FIGURE_FORMATS, figure_bytes
from fieldrecon.selection.models import MODELS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OPTIONS = (
    "x",
    "y",
    "value",
    "z",
    "sigma",
    "strict",
    "missing",
    "decimal",
    "units",
    "method",
    "grid",
    "at",
    "mesh",
    "load",
    "crs",
    "anisotropy",
)
"""The options that the function has as arguments."""
_STEMS = {"nodes": "grid", "points": "points", "vertices": "mesh"}


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
    add("--load", type=Path, metavar="FIELD.npz", help="evaluate a field that --save wrote")
    for name in ("x", "y", "z"):
        add(
            f"--{name}",
            metavar="COLUMN",
            help=f"the column that holds {name}" + (", of points in space" if name == "z" else ""),
        )
    add(
        "--value",
        action="append",
        metavar="COLUMN",
        help="the column that holds the value; repeated for several values, by one method",
    )
    add(
        "--sigma",
        metavar="COLUMN",
        help="the standard deviations of the values: less certain ones are smoothed more",
    )
    add("--lonlat", action="store_true", help="x and y are degrees of longitude and latitude")
    add("--crs", metavar="NAME", help="of x and y, such as EPSG:32612: recorded in NetCDF files")
    add("--strict", action="store_true", help="stop at a bad row instead of skipping it")
    add(
        "--missing",
        type=float,
        action="append",
        metavar="NUMBER",
        help="a number that marks missing values, such as -9999; may be repeated",
    )
    add(
        "--units",
        action="append",
        metavar="UNIT",
        help="the unit of the value, or of each of several in turn; also: a column named depth [m]",
    )
    add(
        "--decimal",
        choices=(".", ","),
        help="the decimal sign, where the numbers of a text do not show it",
    )
    add(
        "--method",
        default="best",
        metavar="NAME",
        help=f"{', '.join(MODELS)}, or best (the default): the method with the smallest error "
        "at samples that are held out",
    )
    add(
        "--anisotropy",
        metavar="RATIO:ANGLE",
        help="the values vary more slowly along a direction: the ratio of the ranges along and "
        "across, and the angle in degrees from x towards y, such as 3:45; or auto: the one of "
        "least error at the held-out samples, if it is clearly less",
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
    add(
        "--pictures",
        default="png",
        metavar="NAMES",
        help=f"formats of the pictures in the folder, of {', '.join(FIGURE_FORMATS)} (png)",
    )
    add("--save", type=Path, metavar="FIELD.npz", help="save the fitted field")
    add("--title", metavar="TEXT", help="of the page")
    add(
        "--colors",
        default=COLORS,
        metavar="NAME",
        help=f"a colour map of Matplotlib, such as cividis or RdBu_r ({COLORS})",
    )
    parser.set_defaults(command=reconstruct)


def _counts(text: str) -> tuple[int, ...]:
    is_grid = re.fullmatch(r"\d+x\d+(x\d+)?", text.lower())
    counts = tuple(map(int, text.lower().split("x"))) if is_grid else ()
    if not counts or min(counts) < 2:
        raise argparse.ArgumentTypeError(f"must be such as 200x150, each 2 or more; got {text!r}")
    return counts


def reconstruct(options: argparse.Namespace) -> None:
    """Reconstruct a field from samples; print and write it."""
    if (options.samples is None) == (options.load is None):
        raise ValueError("give either a table of samples or --load with a field")
    file, formats = _outputs(options)
    of_pictures = _picture_formats(options.pictures)
    given = {name: getattr(options, name) for name in _OPTIONS}
    if options.value and len(options.value) == 1:
        (given["value"],) = options.value
    with stages() as stage:
        survey = reconstruct_samples(
            options.samples, **given, lonlat=options.lonlat or None, stages=stage
        )
        stage("writing")
        written = list(_written(survey, file, formats, of_pictures, options))
    print_survey(survey)
    print_files(written)
    print_missing_pictures()


def _outputs(options: argparse.Namespace) -> tuple[Path | None, list[str]]:
    """Return the output file, or None for a folder, and the formats."""
    suffix = options.out.suffix
    file = options.out if re.fullmatch(r"\.[A-Za-z]\w*", suffix) else None
    formats = as_formats([suffix] if file else (options.format or "csv,npz").split(","))
    if not file and options.out.exists() and not options.out.is_dir():
        raise ValueError(f"--out {options.out} is a file; a name without a suffix is a folder's")
    if file and options.format and as_formats(options.format.split(",")) != formats:
        raise ValueError(f"--out {file} names another format than --format {options.format}")
    inputs = (options.samples, options.load, options.at, options.mesh)
    read = {path.resolve() for path in inputs if path}
    for path in filter(None, (file or options.out / "summary.html", options.save)):
        if path.resolve() in read:
            raise ValueError(f"{path} is read, and would be overwritten; choose another name")
        check_writable(path)
    return file, formats


def _picture_formats(names: str) -> list[str]:
    """Return the formats of the pictures."""
    formats = [name.strip().lower().removeprefix(".") for name in names.split(",")]
    for name in formats:
        if name not in FIGURE_FORMATS:
            raise ValueError(
                f"there are no pictures as {name!r}; there are {', '.join(FIGURE_FORMATS)}"
            )
    return formats


def print_survey(survey: SurveyResult) -> None:
    """Print the errors of the methods, what was evaluated, and the warnings."""
    compared = [t for t in survey.ranked if t.residuals is not None]
    rows = [(t.model.name, t.model.meaning, t.n_held_out, t.rms, t.largest) for t in compared]
    names, count = survey.samples.value_names, len(survey.samples.points)
    unit = ", in standard deviations of each value" if survey.samples.values.ndim == 2 else ""
    if rows:
        title = f"{', '.join(names)} at {count} points: error at held-out samples{unit}"
        columns = ("method", "what it is", "held out", "rms error", "largest error")
        print_table(columns, rows, title=title)
    for t in survey.scores:
        if t.residuals is None:
            say(f"{t.model.name}: {t.reason}.")
    for warning in survey.warnings:
        say(warning)
    say(f"Evaluated: {survey.method}.")
    say(f"{survey.cost}.")


def _written(
    survey: SurveyResult,
    file: Path | None,
    formats: Sequence[str],
    of_pictures: Sequence[str],
    options: argparse.Namespace,
) -> Iterator[Path]:
    """Write the data, the pictures, and the page, which links to the others; yield the files."""
    drawn = {} if absent(*PICTURES) else pictures(survey, options.colors)
    images = as_png(drawn)
    written = [*_data_written(survey, file, formats, options)]
    if not file:
        written += _pictures_written(drawn, images, options.out, of_pictures)
    page = file.with_suffix(".html") if file else options.out / "summary.html"
    links = [os.path.relpath(path, page.parent) for path in written]
    content = summary(survey, as_parameters(options), images, title=options.title, files=links)
    yield from written
    yield write_atomically(page, content.encode())


def _data_written(
    survey: SurveyResult, file: Path | None, formats: Sequence[str], options: argparse.Namespace
) -> Iterator[Path]:
    stem = _STEMS[survey.result.targets.kind]
    for name in formats:
        yield survey.write(file or options.out / f"{stem}.{name}")
    if options.save:
        save(options.save, survey.field, survey.samples.names)
        yield options.save
    if not file:
        yield write_atomically(options.out / "methods.csv", methods_csv(survey))


def _pictures_written(
    drawn: Mapping[str, Figure],
    images: Mapping[str, bytes],
    folder: Path,
    formats: Sequence[str],
) -> Iterator[Path]:
    for name, picture in drawn.items():
        for kind in formats:
            content = images[name] if kind == "png" else figure_bytes(picture, kind)
            yield write_atomically(folder / f"{name}.{kind}", content)
