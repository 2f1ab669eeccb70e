"""Pinned kernels: workers compute the same bytes in every environment of the caller."""

import os

import pytest
from threadpoolctl import threadpool_info

from fieldrecon._core.simd_dispatch import blas_cores
from fieldreport import experiments
from fieldreport.build import pinned_kernels, reproducibility, rerun
from fieldreport.build.errors import BuildError
from fieldreport.build.rerun import workers
from fieldreport.framework.result_files import npz_bytes

NAME = "normal_equations"
FIRST = reproducibility.other_surroundings({})
SECOND = reproducibility.other_surroundings(FIRST)


def run_in_worker(work, *arguments, caller):
    """Call a function in a worker that is started in the given environment."""
    with pytest.MonkeyPatch.context() as environment:
        for name, value in caller.items():
            environment.setenv(name, value)
        with workers(1) as pool:
            return pool.submit(work, *arguments).result()


def results(caller):
    """The results of a small experiment, with all bits."""
    tables, facts, arrays = run_in_worker(
        rerun._run, NAME, experiments.get(NAME).quick, caller=caller
    )
    return tables, facts, npz_bytes(arrays)


@pytest.mark.slow
def test_two_environments_give_the_same_bytes():
    """The environments are those of ``make check-reproducible`` for two callers."""
    assert results(FIRST) == results(SECOND)


@pytest.mark.slow
def test_without_pins_two_environments_give_different_bytes(monkeypatch):
    """This holds on machines for which kernels are pinned."""
    pinned = pinned_kernels.pins()
    monkeypatch.setattr(pinned_kernels, "pins", dict)
    assert (results(FIRST) != results(SECOND)) == bool(pinned)


@pytest.mark.slow
def test_a_pinned_kernel_that_has_no_effect_stops_the_build(monkeypatch):
    """OpenBLAS ignores an unknown core name, and the worker reports it."""
    monkeypatch.setattr(
        pinned_kernels,
        "pins",
        lambda: {"OPENBLAS_CORETYPE": "Hasvell", "NPY_DISABLE_CPU_FEATURES": ""},
    )
    with pytest.raises(
        BuildError, match=r"OPENBLAS_CORETYPE=Hasvell.* had no effect \(NumPy's OpenBLAS: "
    ):
        run_in_worker(len, (), caller={})


def test_a_simd_feature_that_is_still_enabled_stops_the_build(monkeypatch):
    """NumPy only warns about a feature that it cannot disable."""
    monkeypatch.setattr(pinned_kernels, "blas_cores", dict)
    monkeypatch.setattr(pinned_kernels, "dispatched", lambda: ("X86_V3", "X86_V4"))
    wanted = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "AVX512_SPR X86_V4"}
    with pytest.raises(BuildError, match=r"\(X86_V4: on\)"):
        pinned_kernels.require(wanted)


def test_the_environment_of_the_caller_is_restored(monkeypatch):
    """Inside, the pins are the only numerical settings; afterwards the environment is as before."""
    monkeypatch.setenv("OPENBLAS_BLOCK_FACTOR", "4")
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA")
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Prescott")
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    before = dict(os.environ)
    pinned = {"OPENBLAS_CORETYPE": "Haswell", "OMP_NUM_THREADS": "1"}
    there = pinned_kernels.with_pins(pinned)
    assert dict(os.environ) == before, "asking for it changes nothing, for any thread"
    with pinned_kernels.environment(pinned):
        assert dict(os.environ) == there
        numerical = {x: os.environ[x] for x in os.environ if x.startswith(pinned_kernels.NUMERICAL)}
    assert numerical == pinned
    assert dict(os.environ) == before


def test_without_pins_the_environment_is_unchanged(monkeypatch):
    """On machines without pinned kernels the settings of the caller count."""
    monkeypatch.setenv("OPENBLAS_CORETYPE", "POWER9")
    with pinned_kernels.environment({}):
        assert os.environ["OPENBLAS_CORETYPE"] == "POWER9"


@pytest.mark.parametrize(
    ("system", "processor", "flags", "pinned"),
    [
        ("linux", "x86_64", "fpu avx avx2 bmi1 bmi2 f16c fma abm movbe avx512f", True),
        ("linux", "x86_64", "fpu avx", False),
        ("linux", "aarch64", "avx avx2 bmi1 bmi2 f16c fma abm movbe", False),
        ("darwin", "x86_64", "avx avx2 bmi1 bmi2 f16c fma abm movbe", False),
    ],
)
def test_kernels_are_pinned_on_linux_with_avx2_only(
    monkeypatch, tmp_path, system, processor, flags, pinned
):
    """The processor flags listed by the Linux kernel decide."""
    (tmp_path / "cpuinfo").write_text(f"processor\t: 0\nflags\t\t: {flags}\n")
    monkeypatch.setattr(pinned_kernels.sys, "platform", system)
    monkeypatch.setattr(pinned_kernels.platform, "machine", lambda: processor)
    assert pinned_kernels.has_x86_64_v3(tmp_path / "cpuinfo") == pinned


@pytest.mark.parametrize(
    ("dispatch", "off"),
    [
        (["X86_V3", "X86_V4", "AVX512_ICL"], "X86_V4 AVX512_ICL"),
        (["SSE42", "AVX", "F16C", "FMA3", "AVX2", "AVX512F", "AVX512_SKX"], "AVX512F AVX512_SKX"),
    ],
)
def test_simd_features_beyond_avx2_are_disabled(monkeypatch, dispatch, off):
    """NumPy releases have two ways of naming these features."""
    monkeypatch.setattr(pinned_kernels, "dispatch", lambda: dispatch)
    monkeypatch.setattr(pinned_kernels, "has_x86_64_v3", lambda: True)
    assert pinned_kernels.pins()["NPY_DISABLE_CPU_FEATURES"] == off


def test_the_reported_cores_are_those_of_openblas():
    """Another BLAS has none."""
    libraries = threadpool_info()
    known = {lib["architecture"] for lib in libraries if lib["internal_api"] == "openblas"}
    assert {*blas_cores().values()} == (known or {""})
