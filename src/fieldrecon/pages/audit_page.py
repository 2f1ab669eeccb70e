"""The page of an audit: the errors of a mesh, with a picture of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from fieldrecon._core.extras import PICTURES, absent, require
from fieldrecon.pages.one_page import NOTHING, fill, page, pairs
from fieldrecon.plotting.figure_files import figure_bytes
from fieldrecon.triangles.audit import MeshAudit, in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fieldrecon.pipelines.mesh_audits import AuditResult


def picture(result: AuditResult) -> Figure:
    """Draw the mesh from two sides with each error marked.

    Raises
    ------
    ModuleNotFoundError
        If the packages that draw are not installed: with the extra that provides them.
    """
    require(*PICTURES)
    from fieldrecon.plotting.mesh_pictures import plot_audit

    return plot_audit(result.audit, result.points, result.triangles)


def audit_page(result: AuditResult, parameters: Mapping[str, Any]) -> str:
    """Return the HTML of the page; without a picture if the packages that draw are missing."""
    images = {}
    if not absent(*PICTURES):
        images = {"The mesh and its errors": figure_bytes(picture(result), "png")}
    audit = result.audit
    errors = _errors(audit)
    table = fill("<h2>Errors</h2>$errors", errors=pairs(errors)) if errors else NOTHING
    return page(
        f"{result.source}, audited",
        f"{audit.triangles:,} triangles and {audit.vertices:,} vertices; tolerance "
        f"{audit.tolerance:.3g}.",
        images,
        list(_sentences(result)),
        table,
        parameters,
    )


def _errors(audit: MeshAudit) -> dict[str, str]:
    """The errors that occur, by concern."""
    found = {
        concern: ", ".join(in_words(kind, n) for kind, n in kinds.items() if n)
        for concern, kinds in audit.counts.items()
    }
    return {concern: words for concern, words in found.items() if words}


def _sentences(result: AuditResult) -> Iterator[str]:
    if result.audit.clean:
        yield "Nothing is wrong: closed, oriented, without self-intersections."
    else:
        yield f"{sum(result.findings.values()):,} errors were found."
    if result.repair is not None:
        done = ", ".join(in_words(what, n) for what, n in result.repair.done.items())
        yield f"Repaired: {done or 'nothing'}."
        left = ", ".join(_errors(result.final).values())
        yield f"Left: {left or 'nothing'}."
        yield from result.remarks
