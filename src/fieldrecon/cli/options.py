"""Options of a command as parameters that its page lists."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def as_parameters(options: argparse.Namespace, *, omit: str = "") -> dict[str, Any]:
    """Return the options that were given or have a default, by their names on the command line."""
    return {
        f"--{name}": str(value) if isinstance(value, Path) else value
        for name, value in vars(options).items()
        if name not in ("command", "traceback", omit) and value is not None and value is not False
    }
