"""The pages of the reference: one for each namespace of the library, from its ``__all__``."""

import inspect
from collections.abc import Mapping
from operator import attrgetter

import fieldrecon as fr
from docstrings import escaped

ROOMS = {
    "methods": "Methods",
    "kernels": "Kernels and weights",
    "selection": "Choice of a method, and errors",
    "meshes": "Meshes",
    "velocity": "Velocities and gradients on meshes",
    "barycentric": "Barycentric and Voronoi coordinates",
    "coupling": "Coupling of two meshes",
    "advection": "Advection",
    "surfaces": "Surfaces from points",
    "solids": "Solids",
    "triangles": "Triangle meshes: audit and repair",
    "io": "Files",
    "datasets": "Data sets",
    "pipelines": "The commands as functions",
}
"""The namespaces in the order of the contents, with their titles."""

FIRST = ("Reconstruction", "Field")
"""What every method and every field has; it is in no namespace but the top."""


def public_names(room: str) -> list[str]:
    """Return the public names of a namespace."""
    return list(getattr(fr, room).__all__)


def documented_name(room: str, name: str) -> str:
    """Return the shortest name below ``fieldrecon``: at the top if it is there."""
    return name if name in fr.__all__ else f"{room}.{name}"


def documented() -> list[str]:
    """Return every name that has a page, without the leading ``fieldrecon.``."""
    return [*FIRST, *(documented_name(room, name) for room in ROOMS for name in public_names(room))]


def room_page(room: str) -> str:
    """Return the page of a namespace: what it is for, and its names with their summaries."""
    module = f"fieldrecon.{room}"
    names = sorted((documented_name(room, name) for name in public_names(room)), key=str.lower)
    description = "\n".join(escaped((getattr(fr, room).__doc__ or "").splitlines()))
    return page(ROOMS[room], f".. py:module:: {module}\n\n``{module}``: {description}", names)


def page(title: str, text: str, names: list[str]) -> str:
    """Return a page with a table of names, and the list of their pages for the contents."""
    rows = "\n".join(f"   * - :py:obj:`fr.{x} <{x}>`\n     - {summary(x)}" for x in names)
    pages = "\n".join(f"   names/fieldrecon.{name}" for name in names)
    return (
        f"{heading(title)}\n\n{text}\n\n.. currentmodule:: fieldrecon\n\n"
        f".. list-table::\n   :class: names\n   :widths: 35 65\n\n{rows}\n\n"
        f".. toctree::\n   :hidden:\n\n{pages}\n"
    )


def heading(title: str) -> str:
    """Return a title."""
    return f"{title}\n{'=' * len(title)}"


def summary(name: str) -> str:
    """Return the first line of the docstring, all of it: formulas have points in them."""
    described = attrgetter(name)(fr)
    if not callable(described):
        return f"Mapping of {len(described)} names, such as ``{next(iter(described))}``."
    return escaped([(inspect.getdoc(described) or "").splitlines()[0]])[0]


def name_page(name: str) -> str:
    """Return the page of one name: its docstring, and the examples of the gallery that use it."""
    described = attrgetter(name)(fr)
    room, _, last = f"fieldrecon.{name}".rpartition(".")
    directive = (
        data(last, described) if isinstance(described, Mapping) else automatic(last, described)
    )
    return (
        f"{heading(last)}\n\n.. currentmodule:: {room}\n\n{directive}\n\n"
        f".. minigallery:: fieldrecon.{name}\n   :add-heading: In the gallery\n"
    )


def automatic(name: str, described: object) -> str:
    """Return the directive that reads a docstring."""
    return f".. auto{'class' if inspect.isclass(described) else 'function'}:: {name}"


def data(name: str, described: Mapping) -> str:
    """Return the directive of a mapping of names to objects that state their meaning."""
    entries = "\n".join(f"   ``{key}``\n      {entry.meaning}" for key, entry in described.items())
    return f".. py:data:: {name}\n\n   A mapping:\n\n{entries}"


def pages() -> dict[str, str]:
    """Return all pages of the reference by file name."""
    core = page("Reconstruction and field", CORE, list(FIRST))
    rooms = {f"api/{room}.rst": room_page(room) for room in ROOMS}
    contents = "\n".join(f"   {name}" for name in ["reconstruction", *ROOMS])
    index = f"{INDEX}\n\n.. toctree::\n   :maxdepth: 1\n\n{contents}\n"
    names = {f"api/names/fieldrecon.{name}.rst": name_page(name) for name in documented()}
    return {"api/index.rst": index, "api/reconstruction.rst": core, **rooms, **names}


CORE = """\
Every method is a `Reconstruction`: it is constructed from the points, and its weights do not
depend on the values. Values make it a `Field`, which is called at points."""

INDEX = """\
Reference
=========

.. py:module:: fieldrecon

``import fieldrecon as fr`` gives the methods and what nearly every use of them needs; the other
names are in namespaces such as ``fr.selection`` and ``fr.io``. Arrays have the shapes: points
``(n, d)``, values ``(n, ...)``, queries ``(..., d)``. Lengths, such as the scale of a kernel, have
the unit of the points. The examples of these pages run as tests (``make test``)."""
