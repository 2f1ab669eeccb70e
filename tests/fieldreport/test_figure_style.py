"""Figure style: methods are distinguishable with any colour vision and in grey."""

import io
import itertools
import re

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.font_manager import FontProperties, findfont

from fieldrecon.plotting import style
from fieldrecon.plotting.fonts import MATH, SERIF_FACES, font_bytes, font_file
from fieldrecon.plotting.maps import hillshade, map_axes
from report_fixtures import REPORT

METHODS = ("LS", "MLS", "PU", "RBF")

# Machado, Oliveira and Fernandes, A physiologically-based model for simulation of color vision
# deficiency (2009), severity 1; rows of the matrices act on linear RGB.
VISIONS = {
    "all cones": np.eye(3),
    "no red cones": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no green cones": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "no blue cones": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
WHITE = np.array([0.95047, 1.0, 1.08883])


def linear(color):
    c = np.array(to_rgb(color))
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    """CIE L*a*b* of linear sRGB."""
    x = TO_XYZ @ rgb / WHITE
    f = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def closest(colors, vision):
    """Return the smallest distance in L*a*b* between two colours for a type of colour vision."""
    seen = [lab(np.clip(np.array(VISIONS[vision]) @ linear(c), 0, 1)) for c in colors]
    return min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2))


@pytest.mark.parametrize("vision", VISIONS)
def test_methods_are_distinguishable_for_every_colour_vision(vision):
    """The colours of methods differ by at least 18 in L*a*b* for each type of colour vision."""
    assert closest([style.METHOD_COLORS[m] for m in (*METHODS, "truth")], vision) > 18


def test_red_and_green_of_equal_lightness_fail_the_criterion():
    """These colours are known to be confused."""
    assert closest(["#d62728", "#2ca02c"], "all cones") > 18
    assert closest(["#b3591f", "#7a7a1f"], "no green cones") < 18


def test_methods_are_distinguishable_in_grey():
    """Lightness falls by at least 10 between methods; line styles and markers differ, too."""
    lightness = [lab(linear(style.METHOD_COLORS[m]))[0] for m in METHODS]
    assert (np.diff(lightness) < -10).all()
    for look in (style.METHOD_LINESTYLES, style.METHOD_MARKERS):
        assert len({look[m] for m in METHODS}) == len(METHODS)


def test_line_colours_have_enough_contrast_to_white():
    """The contrast is at least three (WCAG 1.4.11)."""
    for color in style.METHOD_COLORS.values():
        assert 1.05 / ((TO_XYZ @ linear(color))[1] + 0.05) > 3


def test_every_method_has_colour_line_style_and_marker():
    assert style.METHOD_COLORS.keys() == style.METHOD_LINESTYLES.keys()
    assert style.METHOD_COLORS.keys() == style.METHOD_MARKERS.keys()


def test_shades_of_a_method_increase_in_lightness():
    """The order of variants is therefore visible in grey."""
    lightness = [lab(linear(look["color"]))[0] for look in style.shades("RBF", 5)]
    assert (np.diff(lightness) > 5).all()


def test_sequential_map_rises_and_diverging_map_is_lightest_at_zero():
    """Both colour maps are legible in grey."""
    steps = np.linspace(0, 1, 33)
    rising = [lab(linear(c))[0] for c in mpl.colormaps[style.SEQUENTIAL](steps)[:, :3]]
    assert (np.diff(rising) > 0).all()
    signed = [lab(linear(c))[0] for c in mpl.colormaps[style.DIVERGING](steps)[:, :3]]
    assert np.argmax(signed) == 16


def test_full_width_is_the_text_width_of_the_pdf():
    """The width is A4 minus both margins of the template, also in the filter for pictures."""
    margin = int(re.search(r"margin: \(x: (\d+)mm", (REPORT / "template.typ").read_text()).group(1))
    assert 210 - 2 * margin == pytest.approx(style.FULL_WIDTH * 25.4)
    passes = (REPORT / "filters" / "pictures.lua").read_text()
    assert int(re.search(r"text_width = (\d+)", passes).group(1)) == 210 - 2 * margin


def draw_figure():
    with style.figure(columns=2, width=style.FULL_WIDTH) as (page, axes):
        axes[0].plot([1, 2], [1e-3, 1], **style.line("MLS"))
        axes[0].set(yscale="log", xlabel=r"$\varepsilon / h$", title="error")
        axes[1].imshow(hillshade(np.eye(8), 1, 1), cmap=style.SHADE, extent=(0, 9000, 0, 8000))
        map_axes(axes[1], "heights")
    return page


def save_figure(page, kind):
    buffer = io.BytesIO()
    page.savefig(buffer, format=kind)
    return buffer.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_a_figure_does_not_depend_on_user_settings(kind):
    """Saving twice, drawing twice and user settings give the same bytes."""
    first, again = draw_figure(), draw_figure()
    bytes_ = save_figure(first, kind)
    with mpl.rc_context({"font.family": "serif", "svg.fonttype": "none", "lines.linewidth": 9}):
        assert save_figure(first, kind) == bytes_
        assert save_figure(again, kind) == bytes_
        assert save_figure(draw_figure(), kind) == bytes_


@pytest.mark.slow
def test_letters_of_a_figure_are_paths_or_text():
    """Text for a page that has the fonts; it can be selected there."""
    page = draw_figure()
    assert b"<text" not in save_figure(page, "svg")
    page.svg_fonttype = "none"
    with_text = save_figure(page, "svg").decode()
    assert re.search(r"<text[^>]*>error</text>", with_text)
    assert "Libertinus" in with_text


@pytest.mark.slow
def test_drawing_a_figure_restores_the_settings():
    before = dict(mpl.rcParams)
    draw_figure()
    assert dict(mpl.rcParams) == before


def test_hillshade_is_brighter_on_slopes_facing_the_light():
    """The light comes from the north-west."""
    y, x = np.mgrid[0:20.0, 0:20.0]
    faces_north_west, faces_south_east = x - y, y - x
    flat = hillshade(0 * x, 1, 1).mean()
    assert (
        hillshade(faces_north_west, 1, 1).mean() > flat > hillshade(faces_south_east, 1, 1).mean()
    )


@pytest.mark.parametrize(
    ("face", "look"), [("regular", {}), ("italic", {"style": "italic"}), ("bold", {"weight": 700})]
)
def test_words_in_figures_are_set_in_the_fonts_of_the_report(face, look):
    """They are those of Typst and not of the system."""
    with style.style():
        found = findfont(FontProperties(**look), fallback_to_default=False)
    assert found == str(font_file(SERIF_FACES[face]))


@pytest.mark.parametrize("cells", [(1.0, 1.0), (2.0, 0.5)])
def test_hillshade_is_the_cosine_between_normal_and_light(cells):
    """Stretched to [0, 1]; a factor on the heights stands for heights in another unit."""
    y, x = np.mgrid[0:9.0, 0:12.0]
    heights = np.sin(x / 2) + 0.1 * y * x
    up, east = np.gradient(heights, *cells[::-1])
    normal = np.stack([-east, -up, np.ones_like(x)]) / np.sqrt(1 + east**2 + up**2)
    light = np.tensordot([-0.5, 0.5, np.sqrt(0.5)], normal, axes=1)
    expected = (light - light.min()) / np.ptp(light)
    np.testing.assert_allclose(hillshade(heights, *cells), expected, atol=1e-12)
    np.testing.assert_allclose(hillshade(heights / 3, *cells, 3.0), expected, atol=1e-12)


def test_a_font_that_typst_lacks_is_refused():
    """The message names the font and lists the available fonts."""
    with pytest.raises(LookupError, match=r"the font Comic is not in the Typst wheel .*NewCMMath"):
        font_bytes("Comic")
    assert font_bytes(MATH).startswith(b"OTTO")


def test_hues_of_variants_are_distinguishable():
    """Any two of ten differ by 10 in L*a*b*, and have contrast to white; no two look the same."""
    looks = style.hues(10)
    colors = [lab(linear(look["color"])) for look in looks]
    apart = [np.linalg.norm(a - b) for k, a in enumerate(colors) for b in colors[:k]]
    assert min(apart) > 10
    assert max(color[0] for color in colors) < 70
    assert len({(str(look["linestyle"]), look["marker"]) for look in looks}) == 10
