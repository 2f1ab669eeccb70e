"""Sampling points, test functions, and a real terrain."""

from fieldrecon.datasets.elevation import Terrain, terrain
from fieldrecon.datasets.synthetic import (
    AnalyticField,
    clustered,
    franke,
    halton,
    jittered_grid,
    power_of_sum,
    uniform,
)

__all__ = [
    "AnalyticField",
    "Terrain",
    "clustered",
    "franke",
    "halton",
    "jittered_grid",
    "power_of_sum",
    "terrain",
    "uniform",
]
