"""Ten million sites on one machine, as a whole and in tiles, and the traffic on a cluster.

Sites and queries lie in files and are read in blocks. Each of the two ways is a process of its own,
so its largest memory is what that way takes, with the interpreter. *Whole*: one field of all sites,
and queries go through it from file to file. *Tiles*: sites and queries are dealt out to files of
square tiles with a margin, and each tile is reconstructed by itself, so that memory does not depend
on the number of sites.
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

from benchmarks.cluster_traffic import Traffic, carried
from benchmarks.memory import largest_memory
from benchmarks.timing import BenchmarkResult, Table, Track
from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF

BLOCK = 1_000_000
"""Rows that are read or written at a time."""
MARGIN = 3.0
"""Width of the margin of a tile, in radii of patches of so many sites."""
PATCH = 40
RECORD = np.dtype([("number", np.int64), ("place", float, 2), ("value", float)])
STEPS = ("deal out", "set-up", "fit", "evaluate")
MODELLED = (10**8, 10**9)
WORKERS = 100


@dataclass(frozen=True)
class Size:
    sites: int = 10_000_000
    tiles: int = 6
    """Along each side of the square."""
    sent: int = 100_000
    """Sites of the fit whose traffic is counted."""


FULL = Size()
QUICK = Size(200_000, 2, 20_000)
TOY = Size(2_000, 2, 500)


def run(size: Size, track: Track) -> BenchmarkResult:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        written(folder, size.sites)
        told = {way: apart(way, size, folder) for way in track(["whole", "tiles"], "ways")}
        compared = differences(folder)
    traffic = carried(size.sent)
    rows = [
        (way, *(t[step] for step in STEPS), t["bytes"] / 1e9, compared[way])
        for way, t in told.items()
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
            model_table(size, told, traffic),
        ],
        notes=[
            "Memory is the largest of a process, with the interpreter. That of the whole was "
            + ", ".join(
                f"{told['whole'][f'bytes after {s}'] / 1e9:.2f} GB after {s}" for s in STEPS[1:]
            )
            + f": {told['whole']['bytes'] / size.sites:.0f} bytes for each site.",
            "By model: bytes for each site as measured, seconds as n log n for the whole, and for "
            "tiles as their number. The rows of the size that was measured tell what it is.",
        ],
    )


def written(folder: Path, n: int) -> None:
    """Sites with values, and queries, as files of rows."""
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
    """The rows of a file, some at a time."""
    for rows in blocks(path.stat().st_size // RECORD.itemsize):
        yield np.fromfile(path, RECORD, len(rows), offset=rows.start * RECORD.itemsize)


def apart(way: str, size: Size, folder: Path) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.streaming", way, str(size.tiles), str(folder)]
    root = Path(__file__).parents[1]
    return json.loads(subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True).stdout)


@dataclass
class Clock:
    """Seconds of each step, one after the other, and the largest memory when it ends."""

    told: dict[str, float] = field(default_factory=lambda: {"deal out": 0.0})
    since: float = field(default_factory=time.perf_counter)

    def ends(self, step: str) -> None:
        now = time.perf_counter()
        self.told[step] = self.told.get(step, 0.0) + now - self.since
        self.since = now
        self.told["bytes"] = self.told[f"bytes after {step}"] = largest_memory()


def whole(folder: Path, _: int) -> dict[str, float]:
    """One field of all sites."""
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
    return clock.told


def tiles(folder: Path, side: int) -> dict[str, float]:
    """A field for each tile and its margin."""
    clock = Clock()
    n = (folder / "sites").stat().st_size // RECORD.itemsize
    margin = MARGIN * math.sqrt(PATCH / (math.pi * n))
    deal(folder, "sites", side, margin)
    deal(folder, "queries", side, 0.0)
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
    return clock.told


def deal(folder: Path, what: str, side: int, margin: float) -> None:
    """Deal rows out to the files of all tiles within the margin of which they lie."""
    for part in read(folder / what):
        low, high = (np.floor((part["place"] + s * margin) * side).astype(int) for s in (-1, 1))
        for tile in range(side**2):
            here = np.array(divmod(tile, side))
            rows = part[((low <= here) & (here <= high)).all(axis=1)]
            with (folder / f"{what}-{tile}").open("ab") as file:
                rows.tofile(file)


def differences(folder: Path) -> dict[str, Any]:
    """RMS errors of both ways, and how far they are apart."""
    truth = np.concatenate([part["value"] for part in read(folder / "queries")])
    one, other = np.fromfile(folder / "whole"), np.load(folder / "tiles.npy")
    apart = one - other
    return {
        "whole": rms(one - truth),
        "tiles": rms(other - truth),
        "difference": (rms(apart), float(np.abs(apart).max())),
    }


def rms(error: np.ndarray) -> float:
    return math.sqrt(np.mean(error**2))


def traffic_table(traffic: dict[str, Traffic]) -> Table:
    columns = ("step", "once to each worker", "there", "back")
    rows = [(step, t.held, t.there, t.back) for step, t in traffic.items()]
    return Table("What the network carries, in bytes for each site and query", columns, rows)


def model_table(
    size: Size, told: dict[str, dict[str, float]], traffic: dict[str, Traffic]
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
        for row in (whole_row(n, size, told["whole"], traffic), tiles_row(n, size, told["tiles"]))
    ]
    return Table("Measured, and by model beyond", columns, rows)


def whole_row(
    n: int, size: Size, cost: dict[str, float], traffic: dict[str, Traffic]
) -> tuple[str | int | float, ...]:
    """One field: set-up on one machine, fit and evaluation on all of them."""
    grown = n * math.log(n) / (size.sites * math.log(size.sites)) / 3600
    alone, shared = grown * cost["set-up"], grown * (cost["fit"] + cost["evaluate"])
    memory = n / size.sites * cost["bytes"] / 1e9
    network = sum(t.gigabytes(n, WORKERS) for t in traffic.values())
    return n, "whole", memory, alone + shared, alone + shared / WORKERS, network


def tiles_row(n: int, size: Size, cost: dict[str, float]) -> tuple[str | int | float, ...]:
    """More tiles of the same size: rows of sites and queries go, and values come."""
    hours = n / size.sites * sum(cost[s] for s in STEPS) / 3600
    network = n * (2 * RECORD.itemsize + 16) / 1e9
    return n, "tiles", cost["bytes"] / 1e9, hours, hours / WORKERS, network


if __name__ == "__main__":
    way, side, folder = sys.argv[1:]
    print(json.dumps({"whole": whole, "tiles": tiles}[way](Path(folder), int(side))))
