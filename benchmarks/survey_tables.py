"""Tables x, y, value of public surveys, for the benchmark `surveys`.

    python -m benchmarks.survey_tables DOWNLOADS TABLES

writes the tables of all files below that are in the folder DOWNLOADS into the folder TABLES, which
the variable FIELDRECON_SURVEYS then names. The files are not part of this project:

- california-gps.csv.xz, rio-magnetic.csv.xz, baja-bathymetry.csv.xz and texas-wind.csv, or a
  compressed texas-wind.csv.xz: https://github.com/fatiando/verde/tree/main/data, whose README
  names where they come from: velocities of the Plate Boundary Observatory, the aeromagnetic survey
  of Rio de Janeiro of 1978, depths along ship tracks (the tutorial data of GMT), and weather
  stations of Texas.
- meuse.txt: https://github.com/mmaelicke/scikit-gstat/tree/main/skgstat/data/samples; heavy metals
  in the flood plain of the Meuse, from the R package sp.
- Jura.csv, walker.csv: https://github.com/robertorolo/pyLPM/tree/master/data; heavy metals in the
  soil of the Swiss Jura (Goovaerts 1997), and the Walker Lake data (Isaaks and Srivastava 1989).

Degrees become kilometres, in the equirectangular projection about the mean latitude. The first
coordinate is the one along the lines: of the flights over Rio, the latitude.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas

KM_PER_DEGREE = 111.195


@dataclass(frozen=True)
class Survey:
    """Columns of a file: two coordinates, and the value."""

    file: str
    x: str
    y: str
    value: str

    def table(self, rows: pandas.DataFrame) -> np.ndarray:
        """Samples (n, 3); those at one point are replaced by their mean, as the command does."""
        samples = rows[[self.x, self.y, self.value]]
        means = samples.groupby([self.x, self.y], as_index=False, sort=False).mean()
        return means.to_numpy() * self._units(rows)

    def _units(self, rows: pandas.DataFrame) -> tuple[float, float, float]:
        if "latitude" not in rows:
            return 1.0, 1.0, 1.0
        east = KM_PER_DEGREE * float(np.cos(np.radians(rows["latitude"].mean())))
        units = {"longitude": east, "latitude": KM_PER_DEGREE}
        return units[self.x], units[self.y], 1.0


SURVEYS: Mapping[str, Survey] = {
    "Baja depth": Survey("baja-bathymetry.csv", "longitude", "latitude", "bathymetry_m"),
    "California velocity": Survey("california-gps.csv", "longitude", "latitude", "velocity_east"),
    "California uplift": Survey("california-gps.csv", "longitude", "latitude", "velocity_up"),
    "Jura nickel": Survey("Jura.csv", "Xloc", "Yloc", "Ni"),
    "Meuse zinc": Survey("meuse.txt", "x", "y", "zinc"),
    "Rio magnetic": Survey("rio-magnetic.csv", "latitude", "longitude", "total_field_anomaly_nt"),
    "Texas temperature": Survey("texas-wind.csv", "longitude", "latitude", "air_temperature_c"),
    "Texas wind to east": Survey(
        "texas-wind.csv", "longitude", "latitude", "wind_speed_east_knots"
    ),
    "Texas wind to north": Survey(
        "texas-wind.csv", "longitude", "latitude", "wind_speed_north_knots"
    ),
    "Walker Lake": Survey("walker.csv", "X", "Y", "V"),
}


def main() -> None:
    """Write the tables of all files that are there."""
    import pandas

    parser = argparse.ArgumentParser(prog="python -m benchmarks.survey_tables")
    parser.add_argument("downloads", type=Path)
    parser.add_argument("tables", type=Path)
    asked = parser.parse_args()
    asked.tables.mkdir(parents=True, exist_ok=True)
    for name, survey in SURVEYS.items():
        for path in (asked.downloads / survey.file, asked.downloads / f"{survey.file}.xz"):
            if path.exists():
                table = survey.table(pandas.read_csv(path, skipinitialspace=True))
                header = f"{survey.x},{survey.y},{survey.value}"
                file = asked.tables / f"{name}.csv"
                np.savetxt(file, table, "%.12g", ",", header=header, comments="")


if __name__ == "__main__":
    main()
