"""The date of the sources, for the first page: the same in every checkout of a commit."""

from __future__ import annotations

import os
import subprocess
from datetime import UTC, datetime
from pathlib import Path


def source_date(folder: Path) -> str:
    """Return the date of the last commit, or of SOURCE_DATE_EPOCH if set; else an empty string.

    Parameters
    ----------
    folder : Path
        A folder of the checkout.
    """
    if seconds := os.environ.get("SOURCE_DATE_EPOCH"):
        return datetime.fromtimestamp(int(seconds), UTC).date().isoformat()
    command = ["git", "-C", str(folder), "log", "-1", "--format=%cs"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""
