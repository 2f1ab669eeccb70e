"""Description of the machine: processor, cores and versions; never its name."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from threadpoolctl import threadpool_info

from benchmarks.timing import cores

PACKAGES = ("fieldrecon", "numpy", "scipy", "wlsqm", "ferreus_rbf", "verde", "scikit-learn")


def describe() -> dict[str, str | int]:
    return {
        "processor": _processor(),
        "cores used": cores(),
        "system": f"{platform.system()} {platform.machine()}",
        "Python": platform.python_version(),
        **{name: v for name in PACKAGES if (v := _version(name))},
        "BLAS": ", ".join(sorted(_blas())),
    }


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or "unknown"


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _blas() -> set[str]:
    libraries = [info for info in threadpool_info() if info["user_api"] == "blas"]
    return {
        f"{i['internal_api']} {i['version']} ({i.get('architecture', 'unknown')})"
        for i in libraries
    }
