"""The code that NumPy and OpenBLAS have chosen, as they tell it in other ways."""

import ctypes
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from fieldrecon._core.simd_dispatch import blas_cores, dispatch, dispatched, features


def test_the_levels_of_processors_are_those_of_the_configuration_of_numpy():
    """Some of them are found here; those that are taken for granted are found, too."""
    known = np.show_config(mode="dicts")["SIMD Extensions"]
    found, missing = (known.get(key, []) for key in ("found", "not found"))
    assert sorted(dispatch()) == sorted([*found, *missing])
    assert sorted(dispatched()) == sorted(found)
    assert {*known["baseline"], *found} <= features()
    assert features().isdisjoint(missing)


@pytest.mark.parametrize("package", ["NumPy", "SciPy"])
def test_the_core_of_openblas_is_that_of_the_library_in_the_wheel(package):
    """Empty for another BLAS."""
    libraries = [lib for lib in threadpool_info() if lib["internal_api"] == "openblas"]
    assert {*blas_cores()} == {"NumPy", "SciPy"}
    own = [
        lib for lib in libraries if Path(lib["filepath"]).parent.name == f"{package.lower()}.libs"
    ]
    if not libraries:
        assert blas_cores()[package] == ""
    elif own:
        names = ctypes.CDLL(own[0]["filepath"])
        every = [f"{a}openblas_get_corename{b}" for a in ("scipy_", "") for b in ("64_", "")]
        core = next(getattr(names, name) for name in every if hasattr(names, name))
        core.restype = ctypes.c_char_p
        assert blas_cores()[package] == core().decode()


@pytest.mark.parametrize(
    ("found", "cores"),
    [
        ([("openblas", "/usr/lib/libopenblas.so.0", "Zen")], ("Zen", "Zen")),
        ([("mkl", "/usr/lib/libmkl_rt.so.2", "Zen")], ("", "")),
        (
            [
                ("mkl", "/env/numpy.libs/libmkl_rt.so.2", "SkylakeX"),
                ("openblas", "/env/scipy.libs/libscipy_openblas.so", "Haswell"),
                ("openblas", "/env/numpy.libs/libscipy_openblas64_.so", "Zen"),
            ],
            ("Zen", "Haswell"),
        ),
    ],
    ids=["system", "another BLAS", "wheels"],
)
def test_an_openblas_of_the_system_serves_both_packages(monkeypatch, found, cores):
    """Those in the wheels serve one each."""
    keys = ("internal_api", "filepath", "architecture")
    libraries = [dict(zip(keys, one, strict=True)) for one in found]
    monkeypatch.setattr("threadpoolctl.threadpool_info", lambda: libraries)
    assert blas_cores() == dict(zip(("NumPy", "SciPy"), cores, strict=True))
