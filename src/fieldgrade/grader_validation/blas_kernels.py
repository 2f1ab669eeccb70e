"""Verdicts with the OpenBLAS kernels of other processors, and with NumPy without SIMD.

Both are chosen by environment variables before NumPy is loaded, so each setting runs in its own
process. OpenBLAS ignores unknown names, and has several names for the same kernels. Therefore each
process reports its kernels.
"""

from __future__ import annotations

import os
import pickle
import platform
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldcheck.answers import Answers
from fieldgrade.authoring.sources import Source
from fieldgrade.grader_validation.rounding_errors import (
    STUDENTS,
    TrialKey,
    Verdicts,
    rounding_test,
)
from fieldrecon._core.simd_dispatch import blas_cores, dispatch, dispatched, features

CORES = {
    "Prescott": {"SSE3", "X86_V2"},
    "Nehalem": {"SSE42", "X86_V2"},
    "Haswell": {"AVX2", "X86_V3"},
    "SkylakeX": {"AVX512_SKX", "X86_V4"},
}
"""Kernel names of OpenBLAS, with the CPU features that they need under both names of NumPy."""
REPORTED = {"Prescott": "Katmai"}
"""What OpenBLAS reports for a name that it knows, where that is another name."""
CHOICES = ("OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES")
NO_CHOICE = (
    "The kernels of BLAS cannot be chosen here, so no others are tried: that needs NumPy and SciPy "
    "with OpenBLAS, on an x86-64 processor."
)
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Setting:
    """Variables of the environment that change rounding errors.

    Parameters
    ----------
    name : str
        In words that can follow "with": ``"the Prescott kernels of OpenBLAS"``.
    environment : dict
        The variables.
    """

    name: str
    environment: dict[str, str]

    @property
    def chooses_core(self) -> bool:
        """Whether the kernels of OpenBLAS are chosen."""
        return "OPENBLAS_CORETYPE" in self.environment


@dataclass(frozen=True)
class JudgeRequest:
    """A request to a process: judge answers to the questions whose names begin with `only`."""

    sources: tuple[Source, ...]
    salt: str
    only: str
    known: Mapping[TrialKey, Answers]


@dataclass(frozen=True)
class KernelRun:
    """The result of a process.

    Parameters
    ----------
    cores : dict
        The kernels that the OpenBLAS of NumPy and that of SciPy report.
    simd : tuple of str
        The dispatched instruction sets that NumPy uses.
    verdicts : dict
        The verdicts on all answers.
    """

    cores: dict[str, str]
    simd: tuple[str, ...]
    verdicts: Verdicts

    def __str__(self) -> str:
        kernels = ", ".join(f"{name}'s OpenBLAS runs {core}" for name, core in self.cores.items())
        return (
            f"{kernels or 'no OpenBLAS'}; NumPy dispatches to {', '.join(self.simd) or 'nothing'}"
        )


def settings() -> list[Setting]:
    """Return the other settings of this machine: kernels of OpenBLAS, and NumPy without SIMD.

    The kernels of this process are left out, since the verdicts to compare with are made with them.
    """
    plain = [Setting("all dispatched SIMD of NumPy off", {CHOICES[1]: " ".join(dispatch())})]
    if not has_choice_of_kernels():
        return plain
    own = {*blas_cores().values()}
    others = [core for core in CORES if own != {REPORTED.get(core, core)}]
    usable = [core for core in others if CORES[core] & features()]
    return [
        Setting(f"the {core} kernels of OpenBLAS", {CHOICES[0]: core}) for core in usable
    ] + plain


def has_choice_of_kernels() -> bool:
    """Whether NumPy and SciPy use OpenBLAS on a processor whose kernels can be chosen by name."""
    return platform.machine() in ("x86_64", "AMD64") and all(blas_cores().values())


def run(setting: Setting, request: JudgeRequest) -> KernelRun:
    """Judge all answers in a process with a setting.

    Raises
    ------
    RuntimeError
        The process failed; the message has its last line.
    """
    inherited = {name: value for name, value in os.environ.items() if name not in CHOICES}
    done = subprocess.run(
        [sys.executable, "-c", f"from {__name__} import answer; answer()"],
        input=pickle.dumps(request),
        env=inherited | ONE_THREAD | setting.environment,
        capture_output=True,
        check=False,
    )
    if done.returncode:
        last = (done.stderr.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
        raise RuntimeError(
            f"the run with {setting.name} stopped with status {done.returncode}: {last}"
        )
    found: KernelRun = pickle.loads(done.stdout)
    return found


def not_as_chosen(runs: Sequence[tuple[Setting, KernelRun]]) -> Iterator[str]:
    """Yield a sentence for two settings with the same kernels, or for SIMD that is still on."""
    seen: dict[tuple[str, str], str] = {}
    for setting, found in runs:
        if setting.chooses_core:
            for package, core in found.cores.items():
                other = seen.setdefault((package, core), setting.name)
                if other != setting.name:
                    yield f"{package}'s OpenBLAS runs {core} both with {other} and {setting.name}"
        elif found.simd:
            yield f"with {setting.name}, NumPy still dispatches to {', '.join(found.simd)}"


def answer() -> None:
    """Read a request from standard input, and write what this process finds to standard output."""
    request: JudgeRequest = pickle.load(sys.stdin.buffer)
    verdicts: Verdicts = {}
    for source in request.sources:
        found = rounding_test(source, request.salt, request.only, STUDENTS[:1])
        verdicts |= found.verdicts(request.known)
    sys.stdout.buffer.write(pickle.dumps(KernelRun(blas_cores(), dispatched(), verdicts)))
