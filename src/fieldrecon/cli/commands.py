"""The commands: those of the library, and those that other packages plug in.

A package plugs in a command by an entry point of the group ``fieldrecon.commands`` that names a
`Command`.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points

from fieldrecon._core.extras import require

GROUP = "fieldrecon.commands"


@dataclass(frozen=True)
class Command:
    """A command of ``fieldrecon``, described without importing its implementation.

    Parameters
    ----------
    module : str
        The module whose ``add_arguments(parser)`` declares the options, and sets ``command`` to the
        function of the options that runs it. It is imported only when the command is called, since
        the import of NumPy and SciPy takes longer than most commands.
    help : str
        A summary of the command.
    description : str
        A description in sentences; by default the help.
    needs : tuple of str
        Modules of optional packages that the command requires.
    """

    module: str
    help: str
    description: str | None = None
    needs: tuple[str, ...] = ()

    def add_to(self, commands: argparse._SubParsersAction, name: str, called: bool) -> None:
        """Add the command to a parser, with its options if it is called."""
        parser = commands.add_parser(
            name, help=self.help, description=self.description or self.help
        )
        if called:
            require(*self.needs)
            import_module(self.module).add_arguments(parser)


OF_THE_LIBRARY = {
    "reconstruct": Command(
        "fieldrecon.cli.reconstruct",
        "a field from a table of samples, by the method that fits them best",
        "Reconstruct a field from samples, on a grid, at points or on a mesh. Methods are compared "
        "by their errors at samples that are held out. Each value has an error estimate, and "
        "extrapolated values are marked.",
    ),
    "surface": Command(
        "fieldrecon.cli.surface",
        "a closed mesh from a scan: points on the surface of a body, in a file",
        "Reconstruct the body whose surface goes through points: normals, a field that is zero at "
        "the points, a mesh of its zeros, a picture, and a page with the distances of the points "
        "from the mesh. The status is 0 if the mesh is closed, without errors, and near all "
        "points, 1 if it is not, and 2 if there is no mesh.",
    ),
    "audit": Command(
        "fieldrecon.cli.audit",
        "the errors of a mesh of triangles in a file, and a repaired mesh",
        "Find the errors of a mesh of triangles in space: duplicate vertices and "
        "triangles, triangles without area, edges of more than two triangles, bow-ties, holes, "
        "inconsistent orientation, self-intersections, T-junctions. The status is 0 if there are "
        "no errors, 1 if there are errors (with --repair: if any remain), and 2 if the file cannot "
        "be read.",
    ),
}

ELSEWHERE = {"experiments": "report", "report": "report", "course": "grade", "grade": "grade"}
"""The commands of the distribution fieldrecon-course, each with the extra that it needs."""


def commands() -> dict[str, Command]:
    """Return the commands that are installed, by name."""
    plugged_in = {e.name: e.load() for e in entry_points(group=GROUP)}
    return OF_THE_LIBRARY | dict(sorted(plugged_in.items()))
