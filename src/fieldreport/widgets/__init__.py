"""Living figures of the page: for each of them the data that its script starts from.

A module ``NAME.py`` belongs to the script ``report/widgets/NAME.js``. Its function ``data`` returns
what the page cannot compute itself, or should not have to: points, values, curves of a sweep, as
lists and numbers. With ``USES``, the names of experiments, it receives their results.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from fieldreport.framework.experiment import Result


def names() -> list[str]:
    """List the living figures, sorted."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def uses(name: str) -> tuple[str, ...]:
    """Return the names of the experiments whose results a living figure shows."""
    return tuple(getattr(_module(name), "USES", ()))


def data(name: str, results: Sequence[Result] = ()) -> dict[str, Any]:
    """Return the data of a living figure, as JSON can express them."""
    return dict(_module(name).data(*results))


def _module(name: str) -> Any:
    return import_module(f"{__name__}.{name}")
