"""Figures of the gallery: the same settings for each example, and a second one for dark pages.

The small pictures of the lists have a dark one, too.
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PolyCollection, QuadMesh, TriMesh
from matplotlib.colors import to_hex, to_rgba_array
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.quiver import Quiver
from matplotlib.text import Text
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from fieldrecon.plotting.figure_files import figure_bytes
from fieldreport.build.screen_figures import dark_color, webp

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

IMAGE = """
.. image:: /{place}
   :alt: {title}
   :class: sphx-glr-single-img only-{page}

"""


def reset(_settings: dict[str, Any], _file: str) -> None:
    """Undo what an example set. Pictures are twice as fine as the page, for sharp screens."""
    mpl.rcParams.update(
        {
            "figure.figsize": (6.4, 4.0),
            "figure.constrained_layout.use": True,
            "savefig.dpi": 144,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "image.origin": "lower",
        }
    )


def scraper(_block: Any, variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Save each figure of a block twice; the page shows the one that fits its colours."""
    about = ast.get_docstring(ast.parse(Path(variables["src_file"]).read_text(encoding="utf-8")))
    title = (about or "").partition("\n")[0]
    shown = []
    for number, path in zip(plt.get_fignums(), variables["image_path_iterator"], strict=False):
        figure, light = plt.figure(number), Path(path).with_suffix(".webp")
        dark = light.with_stem(f"{light.stem}_dark")
        light.write_bytes(webp(figure_bytes(figure, "png")))
        darken(figure)
        figure.patch.set_visible(False)
        dark.write_bytes(webp(figure_bytes(figure, "png")))
        for file, page in ((light, "light"), (dark, "dark")):
            place = file.relative_to(settings["src_dir"]).as_posix()
            shown.append(IMAGE.format(place=place, title=title, page=page))
    plt.close("all")
    return "".join(shown)


def darken(figure: Figure) -> None:
    """Give lines, letters and areas the colours that they have on a dark page.

    What lies on a map of colours keeps its own, as the map does, and so do the facets of a lit
    body: those in its shadow would become the brightest.
    """
    on_maps = {id(artist) for axes in figure.axes if _is_map(axes) for artist in _drawn(axes)}
    for artist in figure.findobj():
        stays = id(artist) in on_maps or _is_lit(artist)
        if isinstance(artist, Text | Line2D | Patch | Collection) and not stays:
            _darken(artist)


def _is_lit(artist: Artist) -> bool:
    """Whether the artist is a body whose facets have different shades of its colour."""
    return isinstance(artist, Poly3DCollection) and len(_given(artist, "facecolor")) > 1


def _is_map(axes: Axes) -> bool:
    """Whether the axes show an image, or areas whose colours stand for numbers."""
    return bool(axes.images) or any(map(_has_colored_areas, axes.collections))


def _has_colored_areas(drawn: Collection) -> bool:
    if isinstance(drawn, ContourSet):
        return drawn.filled
    areas = isinstance(drawn, QuadMesh | TriMesh | PolyCollection) and not isinstance(drawn, Quiver)
    return areas and drawn.get_array() is not None


def _drawn(axes: Axes) -> list[Artist]:
    """What is drawn in the axes, without their frame, ticks and labels."""
    return [*axes.lines, *axes.collections, *axes.patches, *axes.texts]


def _darken(artist: Artist) -> None:
    given = {name: _given(artist, name) for name in _colors_of(artist)}
    for name, colors in given.items():
        rgba = to_rgba_array(colors)
        if len(rgba):
            rgba[:, :3] = to_rgba_array([dark_color(to_hex(one)) for one in rgba])[:, :3]
            getattr(artist, f"set_{name}")(
                rgba if isinstance(artist, Collection) else tuple(rgba[0])
            )


def _given(artist: Artist, name: str) -> Any:
    """Return colours as they can be set again; in space, a collection sorts them by depth."""
    if isinstance(artist, Collection):
        return getattr(Collection, f"get_{name}")(artist)
    return getattr(artist, f"get_{name}")()


def _colors_of(artist: Artist) -> tuple[str, ...]:
    if isinstance(artist, Text):
        return ("color",)
    if isinstance(artist, Line2D):
        return ("color", "markerfacecolor", "markeredgecolor")
    return ("facecolor", "edgecolor")


THUMBNAIL = "_thumb.webp"


def add_dark_thumbnails(app: Sphinx, doctree: document) -> None:
    """Put a dark picture beside each small one; the page shows the one that fits its colours."""
    from docutils import nodes  # only the site needs it, the tests of figures do not

    for light in list(doctree.findall(nodes.image)):
        if light["uri"].endswith(THUMBNAIL):
            dark = light.deepcopy()
            dark["uri"] = dark_thumbnail(app, light["uri"])
            for image, page in ((light, "light"), (dark, "dark")):
                image["classes"] = [*image["classes"], f"only-{page}"]
            light.parent.insert(light.parent.index(light) + 1, dark)


def dark_thumbnail(app: Sphinx, uri: str) -> str:
    """Return the place of the dark picture of a thumbnail, made of the first figure if need be."""
    from sphinx_gallery.utils import scale_image

    light = Path(app.srcdir, uri.lstrip("/"))
    dark = light.with_stem(f"{light.stem}_dark")
    figure = light.parents[1] / light.name.replace(THUMBNAIL, "_001_dark.webp")
    if not dark.exists() or dark.stat().st_mtime < figure.stat().st_mtime:
        scale_image(figure, dark, *app.config.sphinx_gallery_conf["thumbnail_size"])
    return uri.replace(light.stem, dark.stem)


def setup(app: Sphinx) -> dict:
    """Register with Sphinx; a lower priority comes first, and the images are collected at 500."""
    app.connect("doctree-read", add_dark_thumbnails, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
