"""Ten million sites on one machine, as a whole and in tiles, and the traffic on a cluster.

Sites and queries are read from files in blocks. Each way runs in its own process, so that its peak
memory, which includes the interpreter, can be measured. *Whole*: one field of all sites is
evaluated at the queries from file to file. *Tiles*: sites and queries are distributed to files of
square tiles with a margin, and each tile is reconstructed separately. Its memory does not depend on
the total number of sites.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.cluster_traffic import Traffic, traffic_of
from benchmarks.memory import largest_memory
from benchmarks.timing import BenchmarkResult, Table, Track
from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF

BLOCK = 1_000_000
"""Number of rows that are read or written at a time."""
MARGIN = 3.0
"""Width of the margin of a tile, in radii of a patch of PATCH sites."""
PATCH = 40
RECORD = np.dtype([("number", np.int64), ("place", float, 2), ("value", float)])
STEPS = ("deal out", "set-up", "fit", "evaluate")
MODELLED = (10**8, 10**9)
WORKERS = 100


@dataclass(frozen=True)
class Size:
    sites: int = 10_000_000
    tiles: int = 6
    """Number of tiles along each side of the square."""
    sent: int = 100_000
    """Number of sites in the fit whose traffic is counted."""


FULL = Size()
QUICK = Size(200_000, 2, 20_000)
TOY = Size(2_000, 2, 500)


def run(size: Size, track: Track) -> BenchmarkResult:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_samples(folder, size.sites)
        costs = {
            way: in_own_process(way, size, folder) for way in track(["whole", "tiles"], "ways")
        }
        compared = differences(folder)
    traffic = traffic_of(size.sent)
    rows = [
        (way, *(t[step] for step in STEPS), t["bytes"] / 1e9, compared[way])
        for way, t in costs.items()
    ]
    columns = ("way", *(f"{step}, s" for step in STEPS), "memory, GB", "rms error")
    return BenchmarkResult(
        parameters={
            "sites": size.sites,
            "queries": size.sites,
            "tiles": size.tiles**2,
            "margin in radii of a patch": int(MARGIN),
            "rows of a block": BLOCK,
        },
        tables=[
            Table("Franke's function, queries from file to file", columns, rows),
            Table("Tiles less whole", ("rms", "largest"), [compared["difference"]]),
            traffic_table(traffic),
            model_table(size, costs, traffic),
        ],
        notes=[
            "Memory is the largest of a process, with the interpreter. That of the whole was "
            + ", ".join(
                f"{costs['whole'][f'bytes after {s}'] / 1e9:.2f} GB after {s}" for s in STEPS[1:]
            )
            + f": {costs['whole']['bytes'] / size.sites:.0f} bytes for each site.",
            "By model: bytes for each site as measured, seconds as n log n for the whole, and for "
            "tiles as their number. The rows of the size that was measured tell what it is.",
        ],
    )


def write_samples(folder: Path, n: int) -> None:
    """Write sites with values, and queries, to files of records."""
    for what, seed in (("sites", 1), ("queries", 2)):
        rng = np.random.default_rng(seed)
        with (folder / what).open("wb") as file:
            for numbers in blocks(n):
                rows = np.empty(len(numbers), RECORD)
                rows["number"], rows["place"] = numbers, uniform(len(numbers), 2, rng)
                rows["value"] = franke(rows["place"])
                rows.tofile(file)


def blocks(n: int) -> Iterator[range]:
    for start in range(0, n, BLOCK):
        yield range(start, min(start + BLOCK, n))


def read(path: Path) -> Iterator[np.ndarray]:
    """The rows of a file in blocks."""
    for rows in blocks(path.stat().st_size // RECORD.itemsize):
        yield np.fromfile(path, RECORD, len(rows), offset=rows.start * RECORD.itemsize)


def in_own_process(way: str, size: Size, folder: Path) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.streaming", way, str(size.tiles), str(folder)]
    root = Path(__file__).parents[1]
    return json.loads(subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True).stdout)


@dataclass
class Clock:
    """The seconds of each step and the peak memory at its end."""

    costs: dict[str, float] = field(default_factory=lambda: {"deal out": 0.0})
    since: float = field(default_factory=time.perf_counter)

    def ends(self, step: str) -> None:
        now = time.perf_counter()
        self.costs[step] = self.costs.get(step, 0.0) + now - self.since
        self.since = now
        self.costs["bytes"] = self.costs[f"bytes after {step}"] = largest_memory()


def whole(folder: Path, _: int) -> dict[str, float]:
    """Reconstruct one field of all sites."""
    parts = [(part["place"], part["value"]) for part in read(folder / "sites")]
    places, values = map(np.concatenate, zip(*parts, strict=True))
    del parts
    clock = Clock()
    method = PartitionOfUnityRBF(places)
    clock.ends("set-up")
    s = method.field(values)
    clock.ends("fit")
    with (folder / "whole").open("wb") as file:
        for part in read(folder / "queries"):
            s(part["place"]).tofile(file)
    clock.ends("evaluate")
    return clock.costs


def tiles(folder: Path, side: int) -> dict[str, float]:
    """Reconstruct a field for each tile with its margin."""
    clock = Clock()
    n = (folder / "sites").stat().st_size // RECORD.itemsize
    margin = MARGIN * math.sqrt(PATCH / (math.pi * n))
    distribute(folder, "sites", side, margin)
    distribute(folder, "queries", side, 0.0)
    clock.ends("deal out")
    result = np.lib.format.open_memmap(folder / "tiles.npy", "w+", float, (n,))
    for tile in range(side**2):
        sites = np.fromfile(folder / f"sites-{tile}", RECORD)
        clock.ends("deal out")
        method = PartitionOfUnityRBF(sites["place"])
        clock.ends("set-up")
        s = method.field(sites["value"])
        clock.ends("fit")
        for part in read(folder / f"queries-{tile}"):
            result[part["number"]] = s(part["place"])
        clock.ends("evaluate")
    return clock.costs


def distribute(folder: Path, what: str, side: int, margin: float) -> None:
    """Append each row to the files of all tiles whose margin contains it."""
    for part in read(folder / what):
        low, high = (np.floor((part["place"] + s * margin) * side).astype(int) for s in (-1, 1))
        for tile in range(side**2):
            here = np.array(divmod(tile, side))
            rows = part[((low <= here) & (here <= high)).all(axis=1)]
            with (folder / f"{what}-{tile}").open("ab") as file:
                rows.tofile(file)


def differences(folder: Path) -> dict[str, Any]:
    """RMS errors of both ways, and the difference of their values."""
    truth = np.concatenate([part["value"] for part in read(folder / "queries")])
    one, other = np.fromfile(folder / "whole"), np.load(folder / "tiles.npy")
    difference = one - other
    return {
        "whole": rms(one - truth),
        "tiles": rms(other - truth),
        "difference": (rms(difference), float(np.abs(difference).max())),
    }


def rms(error: np.ndarray) -> float:
    return math.sqrt(np.mean(error**2))


def traffic_table(traffic: dict[str, Traffic]) -> Table:
    columns = ("step", "once to each worker", "there", "back")
    rows = [(step, t.held, t.there, t.back) for step, t in traffic.items()]
    return Table("What the network carries, in bytes for each site and query", columns, rows)


def model_table(
    size: Size, costs: dict[str, dict[str, float]], traffic: dict[str, Traffic]
) -> Table:
    columns = (
        "sites and queries",
        "way",
        "GB in one process",
        "hours, this machine",
        f"hours, {WORKERS} such machines",
        f"GB carried to and from {WORKERS}",
    )
    rows = [
        row
        for n in (size.sites, *MODELLED)
        for row in (whole_row(n, size, costs["whole"], traffic), tiles_row(n, size, costs["tiles"]))
    ]
    return Table("Measured, and by model beyond", columns, rows)


def whole_row(
    n: int, size: Size, cost: dict[str, float], traffic: dict[str, Traffic]
) -> tuple[str | int | float, ...]:
    """One field: set-up on one machine, fit and evaluation on all machines."""
    grown = n * math.log(n) / (size.sites * math.log(size.sites)) / 3600
    alone, shared = grown * cost["set-up"], grown * (cost["fit"] + cost["evaluate"])
    memory = n / size.sites * cost["bytes"] / 1e9
    network = sum(t.gigabytes(n, WORKERS) for t in traffic.values())
    return n, "whole", memory, alone + shared, alone + shared / WORKERS, network


def tiles_row(n: int, size: Size, cost: dict[str, float]) -> tuple[str | int | float, ...]:
    """More tiles of the same size: rows of sites and queries are sent, values are received."""
    hours = n / size.sites * sum(cost[s] for s in STEPS) / 3600
    network = n * (2 * RECORD.itemsize + 16) / 1e9
    return n, "tiles", cost["bytes"] / 1e9, hours, hours / WORKERS, network


if __name__ == "__main__":
    way, side, folder = sys.argv[1:]
    print(json.dumps({"whole": whole, "tiles": tiles}[way](Path(folder), int(side))))
