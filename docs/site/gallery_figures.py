"""Figures of the gallery: the same settings for each example, and the same bytes every time."""

from typing import Any

import matplotlib as mpl


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
