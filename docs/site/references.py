"""Names in docstrings as links: `RBF` and `thin_plate_spline()` lead to their pages."""

import re
from functools import cache

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode

import api

BACK = re.compile(r'<a class="viewcode-back"[^>]*>.*?</a>')


@cache
def full_names() -> dict[str, str]:
    """Return the documented name of each public name, by the name as docstrings write it."""
    names = {name.rpartition(".")[2]: f"fieldrecon.{name}" for name in api.documented()}
    rooms = {f"{room}.{name}" for room in api.ROOMS for name in api.public_names(room)}
    return names | {name: names[name.rpartition(".")[2]] for name in rooms}


def resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.Element
) -> nodes.reference | None:
    """Link a name that Sphinx did not find by its last part, as in ``fr.RBF`` or ``RBF.field``."""
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"].removesuffix("()").removeprefix("fieldrecon.").removeprefix("fr.")
    name, _, member = target.partition(".") if target not in full_names() else (target, "", "")
    full = full_names().get(name, "") + (f".{member}" if member else "")
    found = env.domains["py"].objects.get(full)
    if not found:
        return None
    return make_refnode(app.builder, node["refdoc"], found.docname, found.node_id, content, full)


def without_links_back(_app: Sphinx, page: str, _template: str, context: dict, *_: object) -> None:
    """Remove the links from source code to the reference, which lead to names of inner modules."""
    if page.startswith("_modules/"):
        context["body"] = BACK.sub("", context["body"])


def setup(app: Sphinx) -> dict:
    """Register with Sphinx."""
    app.connect("missing-reference", resolve)
    app.connect("html-page-context", without_links_back)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
