"""The code that OpenBLAS and NumPy have chosen in this process, by the processor.

Both carry several versions of their routines, and choose when they are loaded.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def blas_cores() -> dict[str, str]:
    """Return for which core the OpenBLAS of NumPy and that of SciPy run; empty for another BLAS."""
    import scipy.linalg  # noqa: F401  (loads SciPy's BLAS; NumPy's is loaded with it)
    from threadpoolctl import threadpool_info

    found = [lib for lib in threadpool_info() if lib["internal_api"] == "openblas"]
    cores = {}
    for package in ("NumPy", "SciPy"):
        own = [lib for lib in found if f"{package.lower()}.libs" in lib["filepath"]] or found
        cores[package] = own[0]["architecture"] if own else ""
    return cores


def dispatch() -> list[str]:
    """Name the levels, or features, of processors for which NumPy has code of their own."""
    return list(_umath().__cpu_dispatch__)


def features() -> set[str]:
    """Name all levels and features that NumPy finds here and that are not switched off."""
    return {name for name, found in _umath().__cpu_features__.items() if found}


def dispatched() -> tuple[str, ...]:
    """Name those for which NumPy has code of their own and runs it."""
    return tuple(name for name in dispatch() if name in features())


def _umath() -> Any:
    """Return where NumPy tells this, for which there is no public name."""
    return import_module("numpy._core._multiarray_umath")
