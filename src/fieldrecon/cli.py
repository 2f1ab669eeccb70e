"""The command line: experiments, a field from a file of samples, the report.

A command is imported when it is called, since NumPy and SciPy alone take longer than most answers.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from fieldrecon.experiments.experiment import Map

USER_ERRORS = (ValueError, OSError, MemoryError, OverflowError, ImportError)
"""What the user can put right; a LinAlgError is a ValueError."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 2 for what the user can put right."""
    arguments = sys.argv[1:] if arguments is None else arguments
    _replace_what_a_stream_cannot_spell(sys.stdout)
    options = _parser(arguments).parse_args(arguments)
    try:
        return options.command(options) or 0
    except KeyboardInterrupt:
        print("fieldrecon: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader has seen enough, as head does: that is no error, and nothing more is written.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except USER_ERRORS as error:
        if options.traceback:
            raise
        print(f"fieldrecon: {_sentence(error)}", file=sys.stderr)
        return 2


def _replace_what_a_stream_cannot_spell(stream: TextIO) -> None:
    """Write a question mark for a character that a Windows code page lacks, as in a redirection."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="replace")


def _parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fieldrecon", description="Reconstruct a field from scattered samples."
    )
    parser.add_argument(
        "--version", action="version", version=f"fieldrecon {version('fieldrecon')}"
    )
    parser.add_argument("--traceback", action="store_true", help="show where an error came from")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_experiments(commands.add_parser("experiments", help="list, show and run the experiments"))
    reconstruct = commands.add_parser(
        "reconstruct",
        help="a field from a table of samples, and which method fits them",
        description="Reconstruct a field from samples, on a grid, at points or on a mesh. Each "
        "method is judged by samples that are left out; each value comes with an estimate of "
        "its error, and extrapolated ones are marked.",
    )
    if "reconstruct" in arguments:
        _add_reconstruct(reconstruct)
    surface = commands.add_parser(
        "surface",
        help="a closed mesh from a scan: points on the surface of a body, in a file",
        description="Reconstruct the body whose surface goes through points: normals, a field "
        "that is zero at the points, a mesh of its zeros, a picture, and a page that says how "
        "far the points are from it. The status is 0 if the mesh is closed, sound, and "
        "misses no point, 1 if there is something to look at, and 2 if there is no mesh.",
    )
    if "surface" in arguments:
        _add_surface(surface)
    _add_audit(
        commands.add_parser(
            "audit",
            help="what is wrong with a mesh of triangles in a file, and a repair of it",
            description="Look for all that is wrong with a mesh of triangles in space: repeated "
            "vertices and triangles, triangles without area, edges of more than two triangles, "
            "bow-ties, holes, wrong orientation, self-intersections, T-junctions. The status is 0 "
            "if there is nothing, 1 if there is something, also after a repair, and 2 if the file "
            "cannot be read.",
        )
    )
    report = commands.add_parser("report", help="run the experiments and set the report")
    if "report" in arguments:
        _add_report(report)
    course = commands.add_parser("course", help="notebooks, their graders, the students' bundle")
    if "course" in arguments:
        _add_course(course)
    grade = commands.add_parser("grade", help="grade what a class handed in")
    if "grade" in arguments:
        _add_grade(grade)
    return parser


def _add_reconstruct(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the reconstruction."""
    from fieldrecon.reconstruct_command import add_arguments

    add_arguments(parser)


def _add_surface(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the surface."""
    from fieldrecon.surface_command import add_arguments

    add_arguments(parser)


def _add_report(parser: argparse.ArgumentParser) -> None:
    """Declare the options that the report itself knows."""
    from fieldrecon.reporting import command

    command.add_arguments(parser)
    parser.set_defaults(command=command.main)


def _add_course(parser: argparse.ArgumentParser) -> None:
    """Declare the options that the course itself knows."""
    try:
        from fieldrecon.course import command
    except ModuleNotFoundError as missing:
        parser.error(_sentence(missing))
    command.add_arguments(parser)


def _add_grade(parser: argparse.ArgumentParser) -> None:
    """Declare the options that grading itself knows."""
    from fieldrecon._processes import prepare
    from fieldrecon.course.grading import FOR_WORKERS

    prepare(FOR_WORKERS)  # first, since it goes on while the rest is imported here
    try:
        from fieldrecon.course.grading.command import add_arguments
    except ModuleNotFoundError as missing:
        parser.error(_sentence(missing))
    add_arguments(parser)


def _add_experiments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    commands.add_parser("list", help="the experiments").set_defaults(command=_list)
    show = commands.add_parser("show", help="what an experiment is, and its parameters")
    show.add_argument("name", metavar="NAME")
    show.set_defaults(command=_show)
    run = commands.add_parser("run", help="run an experiment and write its files")
    run.add_argument("name", metavar="NAME")
    run.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="replace a parameter"
    )
    run.add_argument("--seed", help="the same as --set seed=SEED")
    run.add_argument("--out", type=Path, default=Path("results"), metavar="DIR")
    run.add_argument("--jobs", type=_positive, default=1, metavar="N", help="processes (1)")
    run.set_defaults(command=_run)


def _add_audit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mesh", type=Path, metavar="MESH", help=".stl, .ply, .obj or .off")
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="LENGTH",
        help="by how much vertices may be off, 0 for none (four roundings of the coordinates)",
    )
    parser.add_argument(
        "--open", action="store_true", help="the surface may have a boundary: that is no error"
    )
    parser.add_argument(
        "--repair", type=Path, metavar="FILE", help="write a repaired mesh; its name tells how"
    )
    parser.add_argument(
        "--largest-hole",
        type=float,
        default=0.1,
        metavar="SHARE",
        help="holes up to this share of the area around are filled (0.1)",
    )
    parser.add_argument("--json", action="store_true", help="print the findings as JSON only")
    parser.add_argument("--out", type=Path, default=Path("audit"), metavar="DIR")
    parser.set_defaults(command=_audit)


def _positive(text: str) -> int:
    if not re.fullmatch(r"0*[1-9]\d*", text):
        raise argparse.ArgumentTypeError(f"must be a positive whole number; got {text!r}")
    return int(text)


def _list(_: argparse.Namespace) -> None:
    from fieldrecon.experiments import titles
    from fieldrecon.reporting.console import print_table

    print_table(("experiment", "what it is about"), tuple(titles().items()))


def _show(options: argparse.Namespace) -> None:
    from fieldrecon.experiments import get
    from fieldrecon.reporting.terminal import print_experiment

    print_experiment(get(options.name))


def _run(options: argparse.Namespace) -> None:
    from fieldrecon.experiments import files, get
    from fieldrecon.experiments.settings import with_settings
    from fieldrecon.reporting.console import print_table
    from fieldrecon.reporting.terminal import print_files, progress

    experiment = get(options.name)
    settings = dict(map(_setting, options.set)) | ({"seed": options.seed} if options.seed else {})
    params = with_settings(experiment.defaults, settings)
    with _pool_map(options.jobs) as pool_map, progress(pool_map, experiment.name) as each:
        result = experiment.run(params, each)
    folder = options.out / experiment.name
    written = files.write_result(result, folder) + files.write_figures(experiment, result, folder)
    for name, table in result.tables.items():
        print_table(table.columns, table.rows, title=f"{experiment.name}: {name}")
    print_table(("fact", ""), tuple(result.facts.items()))
    print_files(written)


def _setting(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"--set wants KEY=VALUE; got {text!r}")
    return key.strip(), value


def _audit(options: argparse.Namespace) -> int:
    from fieldrecon._extras import require
    from fieldrecon.mesh_audit import audit_mesh
    from fieldrecon.mesh_repair import repair_mesh
    from fieldrecon.reporting.audit_files import write_audit
    from fieldrecon.reporting.terminal import (
        print_audit,
        print_files,
        print_json,
        print_missing_pictures,
        stages,
    )
    from fieldrecon.triangle_files import packages_to_write, read_triangles, write_triangles

    if options.repair:
        require(*packages_to_write(options.repair))
    points, triangles = read_triangles(options.mesh)
    with stages() as stage:
        progress = stage("looking for self-intersections")
        if options.repair is None:
            audit = audit_mesh(points, triangles, options.tolerance, progress)
            done = None
        else:
            repaired = repair_mesh(
                points, triangles, options.tolerance, options.largest_hole, progress
            )
            write_triangles(options.repair, repaired.points, repaired.triangles)
            audit, done = repaired.before, repaired.done
    written = write_audit(options.out, audit, points, triangles)
    last = audit if done is None else repaired.after
    if options.json:
        print_json(last.as_dict() if done is None else {"done": done, "left": last.as_dict()})
    else:
        print_audit(options.mesh, audit)
        if done is not None:
            print_audit(options.repair, last, done)
        print_files(written if done is None else [*written, options.repair])
    print_missing_pictures()
    boundary = {"boundary_loops"} if options.open else set()
    return int(bool({*last.found} - boundary))


@contextmanager
def _pool_map(jobs: int) -> Iterator[Map]:
    """Give a map over so many processes, each with BLAS on one thread."""
    if jobs == 1:
        yield map
        return
    from concurrent.futures import ProcessPoolExecutor

    from threadpoolctl import threadpool_limits

    with ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,)) as pool:
        yield pool.map


def _sentence(error: Exception) -> str:
    if isinstance(error, ModuleNotFoundError) and error.name:
        from fieldrecon._extras import remedy

        return remedy(error.name)
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror.lower()}" if error.filename else error.strerror
    return " ".join(str(error).split()) or type(error).__name__


if __name__ == "__main__":
    sys.exit(main())
