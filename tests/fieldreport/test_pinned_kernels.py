"""Pinned kernels: the workers compute the same bytes in every environment of the caller."""

import os

import pytest

from fieldreport import experiments
from fieldreport.build import pinned_kernels, reproducibility, rerun
from fieldreport.build.errors import BuildError
from fieldreport.build.rerun import workers
from fieldreport.framework.result_files import npz_bytes

NAME = "normal_equations"
FIRST, SECOND = reproducibility.callers()


def in_a_worker(work, *arguments, caller):
    """Call a function in a worker that a caller with such an environment starts."""
    with pytest.MonkeyPatch.context() as environment:
        for name, value in caller.items():
            environment.setenv(name, value)
        with workers(1) as pool:
            return pool.submit(work, *arguments).result()


def results(caller):
    """All bits of a small experiment."""
    tables, facts, arrays = in_a_worker(
        rerun._run, NAME, experiments.get(NAME).quick, caller=caller
    )
    return tables, facts, npz_bytes(arrays)


@pytest.mark.slow
def test_two_callers_get_the_same_bytes():
    """The two settings of ``make check-reproducible`` give the same bits."""
    assert results(FIRST) == results(SECOND)


@pytest.mark.slow
def test_the_pins_are_what_makes_them_equal(monkeypatch):
    """With the pins taken out the two settings give other bits, where there are pinned_kernels."""
    pinned = pinned_kernels.pins()
    monkeypatch.setattr(pinned_kernels, "pins", dict)
    assert (results(FIRST) != results(SECOND)) == bool(pinned)


def test_a_pin_without_effect_stops_the_build(monkeypatch):
    """OpenBLAS ignores a core it does not know; the worker does not."""
    monkeypatch.setattr(
        pinned_kernels,
        "pins",
        lambda: {"OPENBLAS_CORETYPE": "Hasvell", "NPY_DISABLE_CPU_FEATURES": ""},
    )
    with pytest.raises(
        BuildError, match=r"OPENBLAS_CORETYPE=Hasvell.* had no effect \(NumPy's OpenBLAS: "
    ):
        in_a_worker(len, (), caller={})


def test_a_feature_that_stayed_on_stops_the_build(monkeypatch):
    """NumPy only warns of a feature that it cannot switch off."""
    monkeypatch.setattr(pinned_kernels, "blas_cores", dict)
    monkeypatch.setattr(pinned_kernels, "dispatched", lambda: ("X86_V3", "X86_V4"))
    wanted = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "AVX512_SPR X86_V4"}
    with pytest.raises(BuildError, match=r"\(X86_V4: on\)"):
        pinned_kernels.require(wanted)


def test_the_environment_is_the_callers_again(monkeypatch):
    """Inside, the pins and nothing else that changes a number; afterwards what was there before."""
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


def test_where_nothing_is_pinned_the_environment_stays(monkeypatch):
    """On other machines the caller's settings count."""
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
def test_only_linux_with_avx2_is_pinned(monkeypatch, tmp_path, system, processor, flags, pinned):
    """The kernel's list of the processor's features decides."""
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
def test_numpy_keeps_what_avx2_can_run(monkeypatch, dispatch, off):
    """Both ways in which releases of NumPy name what they dispatch."""
    monkeypatch.setattr(pinned_kernels, "dispatch", lambda: dispatch)
    monkeypatch.setattr(pinned_kernels, "has_x86_64_v3", lambda: True)
    assert pinned_kernels.pins()["NPY_DISABLE_CPU_FEATURES"] == off
