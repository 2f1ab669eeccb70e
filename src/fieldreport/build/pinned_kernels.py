"""The pins: environment variables that fix the code paths of OpenBLAS and NumPy in the workers.

OpenBLAS and NumPy choose among several versions of each routine by the processor. The versions
differ in their rounding, and so in the last bits of all results. On x86-64 Linux with AVX2 every
processor can run the version made for Haswell, so the workers use that one. Elsewhere nothing is
pinned. The variables must be set before NumPy loads, since they are read only then.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from fieldrecon._core.simd_dispatch import blas_cores, dispatch, dispatched
from fieldreport.build.errors import BuildError

X86_64_V3 = {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"}
"""Features that the Haswell kernels and NumPy's X86_V3 need, as named in ``/proc/cpuinfo``."""

UP_TO_X86_V3 = {
    *("X86_V2", "X86_V3"),
    *("SSE", "SSE2", "SSE3", "SSSE3", "SSE41", "POPCNT", "SSE42", "AVX", "F16C", "FMA3", "AVX2"),
}
"""NumPy's dispatch that stays enabled: levels since NumPy 2.4, single features before."""

NUMERICAL = ("GLIBC_TUNABLES", "GOTO", "NPY_", "OMP_", "OPENBLAS_", "SCIPY_")
"""Prefixes of the names of the variables that may change a result."""


def pins() -> dict[str, str]:
    """Return the environment variables of the workers; empty where nothing is pinned."""
    return _haswell() if has_x86_64_v3() else {}


def _haswell() -> dict[str, str]:
    beyond = [name for name in dispatch() if name not in UP_TO_X86_V3]
    return {
        "NPY_DISABLE_CPU_FEATURES": " ".join(beyond),
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_CORETYPE": "Haswell",
        "OPENBLAS_NUM_THREADS": "1",
    }


@cache
def has_x86_64_v3(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    """Whether the processor has AVX2 and its companions, by the kernel's list.

    NumPy's own list omits the features that the caller has disabled.
    """
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return False
    lines = cpuinfo.read_text(encoding="utf-8").splitlines()
    return any(line.startswith("flags") and set(line.split()) >= X86_64_V3 for line in lines)


def with_pins(pinned: Mapping[str, str]) -> dict[str, str]:
    """Return the environment of this process with the pins in place of the caller's variables."""
    if not pinned:
        return dict(os.environ)
    kept = {name: x for name, x in os.environ.items() if not name.startswith(NUMERICAL)}
    return kept | dict(pinned)


@contextmanager
def environment(pinned: Mapping[str, str]) -> Iterator[None]:
    """Start processes inside the ``with`` with the pins in place of the caller's variables.

    The variables belong to the whole process, so only one thread may be inside.
    """
    before = dict(os.environ)
    after = with_pins(pinned)
    _set_environment(after)
    try:
        yield
    finally:
        _set_environment(before)


def _set_environment(wanted: Mapping[str, str]) -> None:
    for name in os.environ.keys() - wanted.keys():
        del os.environ[name]
    os.environ.update(wanted)


def run_pinned(pinned: Mapping[str, str], work: Callable, /, *args: Any, **kwargs: Any) -> Any:
    """Check that the pins of this process took effect, then call a function.

    Raises
    ------
    BuildError
        If they did not: OpenBLAS silently ignores a core that it was not built with.
    """
    if pinned:
        require(pinned)
    return work(*args, **kwargs)


def require(pinned: Mapping[str, str]) -> None:
    """Refuse libraries that do not run the pinned kernels."""
    core, off = pinned["OPENBLAS_CORETYPE"], pinned["NPY_DISABLE_CPU_FEATURES"].split()
    wrong = {f"{name}'s OpenBLAS": x for name, x in blas_cores().items() if x != core}
    wrong |= dict.fromkeys((name for name in dispatched() if name in off), "on")
    if wrong:
        found = ", ".join(f"{name}: {x}" for name, x in wrong.items())
        wanted = ", ".join(f"{name}={x}" for name, x in pinned.items())
        raise BuildError(f"the settings {wanted} had no effect ({found}); {REMEDY}")


REMEDY = "use the NumPy and SciPy of requirements.lock"
