"""BLAS on one thread while this library computes in small pieces.

BLAS threads compete with this library's own threads for the cores; on busy cores the threads of one
small factorization may wait for each other a hundred times as long as it takes. The number of BLAS
threads belongs to the process: the first holder saves it, and the last one restores it.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from itertools import product
from typing import Any

import scipy.linalg  # noqa: F401  it has a BLAS of its own, which must be loaded to be found
from threadpoolctl import ThreadpoolController

Number = tuple[Callable[[], int], Callable[[int], object]]
"""Getter and setter of the number of threads of one BLAS."""

FEW = 4e9
"""Number of operations up to which one thread suffices; it does them in a fraction of a second."""


class Owner:
    """Reference-counted owner of the numbers of BLAS threads.

    Parameters
    ----------
    numbers : sequence of Number
        One for each BLAS.
    """

    def __init__(self, numbers: Sequence[Number]) -> None:
        self._numbers = numbers
        self._lock = threading.RLock()  # a generator may be collected, and leave, while one enters
        self._holders: set[object] = set()
        self._before: list[int] = []

    def enter(self, holder: object) -> None:
        """Set one thread; the first holder saves the previous numbers."""
        with self._lock:
            self._holders.add(holder)
            if not self._before:
                self._before = [number() for number, _ in self._numbers]
                for _, set_number in self._numbers:
                    set_number(1)

    def leave(self, holder: object) -> None:
        """Leave, also if interrupted while entering; the last holder restores the saved numbers."""
        with self._lock:
            self._holders.discard(holder)
            if not self._holders:
                for (_, set_number), before in zip(self._numbers, self._before, strict=False):
                    set_number(before)
                self._before = []


def _number(library: Any) -> Number:
    """Getter and setter for a BLAS that threadpoolctl found.

    threadpoolctl sets the number of OpenBLAS from one thread only, and silently ignores the others.
    """
    if library.internal_api == "openblas" and not _by_openmp(library):
        names = ctypes.CDLL(library.filepath)
        for prefix, suffix in product(("", "scipy_"), ("", "64_", "_64")):
            name = f"{prefix}openblas_%s_num_threads{suffix}"
            if hasattr(names, name % "get"):
                return getattr(names, name % "get"), getattr(names, name % "set")
    return library.get_num_threads, library.set_num_threads


def _by_openmp(library: Any) -> bool:
    return getattr(library, "threading_layer", None) == "openmp"


_LIBRARIES = ThreadpoolController().select(user_api="blas").lib_controllers


_of_process = Owner([_number(library) for library in _LIBRARIES if not _by_openmp(library)])


class _Owners(threading.local):
    """Owners of the process and of this thread: OpenMP has one number for each calling thread."""

    def __init__(self) -> None:
        own = [_number(library) for library in _LIBRARIES if _by_openmp(library)]
        self.all = [_of_process, Owner(own)] if own else [_of_process]


_owners = _Owners()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Hold BLAS to one thread inside the ``with``, or inside a function that this decorates."""
    owners = _owners.all
    holder = object()
    try:
        for owner in owners:
            owner.enter(holder)
        yield
    finally:
        for owner in owners:
            owner.leave(holder)


def blas_threads_for(operations: float) -> AbstractContextManager[None]:
    """Hold BLAS to one thread for few operations, where several threads would be slower."""
    return one_blas_thread() if operations <= FEW else nullcontext()
