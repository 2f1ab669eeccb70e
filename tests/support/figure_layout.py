"""How a figure uses its page."""

from matplotlib.figure import Figure


def filled(page: Figure) -> float:
    """The height of all that is drawn, as a fraction of the height of the page."""
    page.draw_without_rendering()
    parts = [axes.get_tightbbox() for axes in page.axes]
    parts += [legend.get_window_extent() for legend in page.legends]
    return (max(p.y1 for p in parts) - min(p.y0 for p in parts)) / page.bbox.height
