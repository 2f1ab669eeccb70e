"""Figures in the style of the report: their sizes, layout, files, and the maps among them."""

import io
import re
import struct
from pathlib import Path

import matplotlib as mpl
import matplotlib.image
import numpy as np
import pytest
from fontTools.ttLib import TTFont
from matplotlib.colors import to_rgb
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.patches import Rectangle

from fieldrecon.plotting.fonts import (
    MATH,
    SERIF_FACES,
    _opentype_files,
    copy_font_list,
    font_bytes,
)
from fieldrecon.plotting.maps import hillshade, map_axes
from fieldrecon.plotting.style import (
    FULL_WIDTH,
    HALF_WIDTH,
    METHOD_COLORS,
    PLAIN_NUMBERS,
    figure,
    hues,
    line,
    shades,
    style,
)


def height(rows: int, columns: int) -> float:
    """Height of the axes of a page 6 inches wide."""
    with figure(6.0, rows=rows, columns=columns) as (page, _):
        return page.get_size_inches()[1] - 0.25


@pytest.mark.slow
def test_the_default_height_keeps_the_shape_of_the_axes():
    """Axes side by side are lower, and rows add up."""
    assert height(1, 1) == pytest.approx(0.62 * 6.0)
    assert height(1, 2) == pytest.approx(height(1, 1) / 2)
    assert height(2, 1) == pytest.approx(height(1, 1) * 2)


def test_a_notebook_shows_a_figure():
    """As PNG, whether or not its backend is set up."""
    with figure() as (page, _):
        assert page._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_a_saved_figure_has_no_date(kind):
    buffer = io.BytesIO()
    with figure() as (page, _):
        page.savefig(buffer, format=kind)
    assert not re.search(rb"<dc:date>|CreationDate|Creation Time", buffer.getvalue())


def test_plain_numbers_at_an_axis_have_no_formula():
    """Nor has the power of ten beside it."""
    with figure(settings=PLAIN_NUMBERS) as (page, axes):
        axes.plot([0.0, 3e9])
        page.draw_without_rendering()
        texts = [axes.yaxis.get_offset_text(), *axes.get_yticklabels()]
    assert texts[0].get_text()
    assert not any("$" in text.get_text() for text in texts)


def test_axes_and_their_labels_are_inside_the_page_and_apart():
    """However long the labels are; a figure is laid out once, whatever is saved or drawn later."""
    with figure(4.0, columns=2) as (page, both):
        for axes in both:
            axes.set(xlabel="two\nlines", ylabel="three\nlines\nhere", title="a title")
            axes.set_ylim(0, 1e5)
    assert page.get_layout_engine() is None
    left, right = (axes.get_tightbbox() for axes in both)
    for box in (left, right):
        assert (box.min >= page.bbox.min).all()
        assert (box.max <= page.bbox.max).all()
    assert left.x1 < right.x0


@pytest.mark.parametrize(
    ("limits", "length", "label"),
    [
        ((0.0, 9000.0), 2000.0, "2 km"),
        ((7000.0, 3000.0), 1000.0, "1 km"),
        ((-1000.0, 2000.0), 500.0, "500 m"),
        ((0.0, 2.0), 0.5, "0.5 m"),
    ],
)
def test_a_map_has_a_scale_bar_and_no_ticks(limits, length, label):
    """The bar has a round length, at most a quarter of the width, whichever way the axis runs."""
    with figure() as (page, axes):
        axes.set(xlim=limits, ylim=(0.0, 3000.0))
        map_axes(axes, "heights")
        page.draw_without_rendering()
        (bar,) = axes.artists
        (drawn,) = bar.size_bar.findobj(Rectangle)
        assert (drawn.get_width(), bar.txt_label.get_text()) == (length, label)
        assert (axes.get_title("left"), axes.get_aspect()) == ("heights", 1.0)
        assert len(axes.get_xticks()) == len(axes.get_yticks()) == 0
        assert all(spine.get_visible() for spine in axes.spines.values())


def test_two_figures_beside_each_other_fill_the_width_of_the_text():
    """With a gap of four millimetres."""
    gap = FULL_WIDTH - 2 * HALF_WIDTH
    assert 25.4 * gap == pytest.approx(4)


def test_a_figure_in_a_file_has_no_date_either(tmp_path):
    """The end of its name tells the format."""
    for kind in ("svg", "pdf", "png"):
        with figure(1.0) as (page, _):
            page.savefig(tmp_path / f"a.b.{kind}")
        content = (tmp_path / f"a.b.{kind}").read_bytes()
        assert not re.search(rb"<dc:date>|CreationDate|Software", content)


def test_letters_are_about_as_large_as_those_of_the_text_and_lines_are_thin():
    """Those of numbers and legends have 8 points, all others 9; frames and grids are thinner than
    contours, and these than curves.
    """
    with style():
        sizes = {k: v for k, v in mpl.rcParams.items() if k.endswith(("size", "labelsize"))}
        width = mpl.rcParams.__getitem__
        small, large = (
            {FontProperties(size=v).get_size_in_points() for k, v in sizes.items() if k in names}
            for names in (
                ("xtick.labelsize", "ytick.labelsize", "legend.fontsize"),
                ("font.size", "axes.titlesize", "axes.labelsize", "figure.titlesize"),
            )
        )
        grid, frame = width("grid.linewidth"), width("axes.linewidth")
        minor, major = width("xtick.minor.width"), width("xtick.major.width")
        contour, curve = width("contour.linewidth"), width("lines.linewidth")
        assert (minor, major) == (width("ytick.minor.width"), width("ytick.major.width"))
        assert major == frame == width("patch.linewidth")
        assert mpl.rcParams["lines.markersize"] < 5
        assert 0.5 < mpl.rcParams["legend.framealpha"] < 1  # curves behind are seen
    assert (small, large) == ({8.0}, {9.0})
    assert 0.2 < minor < grid < frame < contour < curve < 1.5


@pytest.mark.parametrize(("kind", "face"), SERIF_FACES.items())
def test_letters_are_those_of_the_text(kind, face):
    """Matplotlib finds the faces in the wheel, and takes no other in their place."""
    look = {"regular": {}, "italic": {"style": "italic"}, "bold": {"weight": "bold"}}[kind]
    with style():
        found = findfont(FontProperties(**look), fallback_to_default=False)
    assert get_font(found).postscript_name == face


def test_files_for_the_screen_are_sharper_than_it():
    """Pictures in PNG have at least 200 points per inch."""
    with figure(2.0, 1.0) as (page, _):
        buffer = io.BytesIO()
        page.savefig(buffer, format="png")
    buffer.seek(0)
    assert mpl.image.imread(buffer).shape == (200, 400, 4)


def test_variants_differ_in_colour_dash_or_marker():
    """A single one has the colour of its method, and of twenty no two look alike."""
    assert shades("RBF", 1)[0]["color"] == METHOD_COLORS["RBF"]
    for looks in (hues(20), shades("MLS", 20)):
        assert len(looks) == 20
        assert len({tuple(map(str, look.values())) for look in looks}) == 20
    reference, *_ = shades("truth", 3, linewidth=0.5)
    assert reference["linewidth"] == 0.5


@pytest.mark.parametrize("count", [2, 5])
def test_shades_run_from_dark_to_light_around_the_colour_of_the_method(count):
    """With up to 45 % of black and of white."""
    own = np.array(to_rgb(METHOD_COLORS["MLS"]))
    darker = [own * share for share in np.linspace(0.55, 1, 1 + count // 2)]
    lighter = [1 - (1 - own) * share for share in np.linspace(1, 0.55, 1 + count // 2)]
    expected = [*darker, *lighter[1:]] if count % 2 else [*darker[:-1], *lighter[1:]]
    found = [to_rgb(look["color"]) for look in shades("MLS", count)]
    np.testing.assert_allclose(found, expected, atol=0.6 / 255)


def test_the_truth_is_a_thin_line_without_markers():
    """Curves of methods lie beside it; keywords of the caller come last."""
    with style():
        assert 0 < line("truth")["linewidth"] < mpl.rcParams["lines.linewidth"]
    assert line("truth")["marker"] == ""
    assert "linewidth" not in line("MLS")
    assert line("MLS", label="mine", marker="")["label"] == "mine"


def test_the_words_of_a_scale_bar_are_legible_on_any_map():
    """On a light ground, above the bar and apart from it; the map is faint behind."""
    with figure() as (page, axes):
        axes.set(xlim=(0.0, 9000.0), ylim=(0.0, 3000.0))
        map_axes(axes)
        page.draw_without_rendering()
        (bar,) = axes.artists
        (drawn,) = bar.size_bar.findobj(Rectangle)
        words, beam = bar.txt_label.get_window_extent(), drawn.get_window_extent()
        ground, frame = bar.patch.get_window_extent(), axes.get_window_extent().frozen()
        assert axes.get_title("left") == ""
    assert bar.patch.get_facecolor()[:3] == (1, 1, 1)
    assert 0.5 < bar.patch.get_alpha() < 1
    assert words.y1 < beam.y0 or beam.y1 < words.y0
    assert abs(words.y0 - beam.y1) < words.height or abs(beam.y0 - words.y1) < words.height
    for box in (words, beam):
        assert ground.x0 < box.x0 < box.x1 < ground.x1
        assert ground.y0 < box.y0 < box.y1 < ground.y1
    assert 1 < beam.height < words.height
    assert 0 < frame.x1 - ground.x1 < words.height  # in the corner
    assert 0 < ground.y0 - frame.y0 < words.height


def test_a_slope_that_faces_the_sun_is_bright():
    """The sun is in the northwest, and rows of heights run north."""
    east, north = np.meshgrid(np.arange(9.0), np.arange(9.0))
    brightness = {}
    for name, heights in {
        "northwest": east - north,
        "southeast": north - east,
        "north": -north,
        "west": east,
        "east": -east,
    }.items():
        shaded = hillshade(np.pad(0.3 * heights, 9, mode="edge"), 1.0, 1.0)
        brightness[name] = shaded[9:18, 9:18].mean()
    assert brightness["northwest"] > brightness["north"] > brightness["southeast"]
    assert brightness["west"] == pytest.approx(brightness["north"], abs=0.1)
    assert brightness["west"] > brightness["east"]


def test_a_shaded_relief_is_that_of_lambert():
    """The cosine between the normal and the sun, 45 degrees high, stretched from 0 to 1."""
    heights = np.random.default_rng(0).random((5, 7))
    for factor, given in ((3.0, (3.0,)), (1.0, ())):
        north, east = np.gradient(factor * heights, 2.0, 4.0)
        normal = np.stack([-east, -north, np.ones_like(east)], axis=-1)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        cosine = normal @ (np.array([-1.0, 1.0, np.sqrt(2)]) / 2)
        expected = (cosine - cosine.min()) / np.ptp(cosine)
        np.testing.assert_allclose(hillshade(heights, 4.0, 2.0, *given), expected, atol=1e-12)


def test_the_list_of_fonts_is_copied(tmp_path):
    """A process that starts elsewhere need not make it."""
    copy_font_list(tmp_path / "fonts")
    (copied, *_) = (tmp_path / "fonts").iterdir()
    assert copied.read_bytes() == (Path(mpl.get_cachedir()) / copied.name).read_bytes()


def test_a_font_that_the_wheel_lacks_is_named():
    with pytest.raises(LookupError, match="the font Nowhere-Regular is not in the Typst wheel"):
        font_bytes("Nowhere-Regular")


@pytest.mark.parametrize("face", [*SERIF_FACES.values(), MATH])
def test_a_font_in_the_wheel_is_a_whole_font(face):
    """FontTools reads each table of it, and finds its name."""
    font = TTFont(io.BytesIO(font_bytes(face)))
    assert font["name"].getDebugName(6) == face
    for table in font.keys():  # noqa: SIM118 - not a mapping
        font[table]
    assert len(font_bytes(face)) % 4 == 0


def opentype(count, name="", tags=(b"CFF ", b"name")):
    """An OpenType file with `count` tables and this font name among those of its CFF table."""
    size, names = 2, [name.encode(), b"other", b"names"]
    ends = np.cumsum([1, *map(len, names)]).tolist()
    cff = bytes([1, 0, 5, 4, 0]) + struct.pack(">HB4H", len(names), size, *ends)
    tables = {tag: cff + b"".join(names) for tag in tags}
    tables |= {b"%4d" % k: b"123" for k in range(count - len(tags))}
    directory, content = struct.pack(">4sH6x", b"OTTO", count), b""
    for tag, table in tables.items():
        place = 12 + 16 * count + len(content)
        directory += struct.pack(">4sLLL", tag, 0, place, len(table))
        content += table
    whole = directory + content
    return whole + b"\0" * (-len(whole) % 4)


def test_fonts_are_found_wherever_they_begin():
    """One behind another, or behind letters like their first ones, of 5 to 40 tables."""
    parts = [
        opentype(5, "First"),
        b"OTTO",
        opentype(40, "Second-Bold"),
        *(opentype(4, "no"), opentype(41, "no")),
        *(opentype(6, "no", tags=(b"CFF ",)), opentype(6, tags=())),
        opentype(6, "Third"),
        opentype(5)[:91],  # a directory without its last byte
    ]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    names = {0: "First", 2: "Second-Bold", 7: "Third"}
    found = [*_opentype_files(b"".join(parts))]
    assert found == [(name, starts[k], starts[k + 1]) for k, name in names.items()]
