"""Arrays of NumPy's archives."""

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike


def write_archive(path: Path, arrays: Mapping[str, ArrayLike]) -> None:
    """Write named arrays as NPZ.

    They are packed in memory first: on a full disk NumPy 2.1 leaves the archive half open, and
    Python complains of it at some later time. So does Python 3.13 of a view of this memory.
    """
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    path.write_bytes(buffer.getvalue())
