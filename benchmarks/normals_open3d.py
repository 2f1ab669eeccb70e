"""Open3D in a separate environment: normals of the point cloud named on each input line."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
import open3d  # type: ignore[import-not-found] # installed in its own environment only


def main() -> None:
    folder, neighbors, joined = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    clouds = {path.stem: read(path) for path in folder.glob("*.npy")}
    search = open3d.geometry.KDTreeSearchParamKNN(neighbors)
    print("ready", flush=True)
    for line in sys.stdin:
        name = line.strip()
        cloud = clouds[name]
        cloud.normals = open3d.utility.Vector3dVector()
        start, began = time.process_time(), time.perf_counter()
        cloud.estimate_normals(search)
        alone = time.perf_counter() - began
        cloud.orient_normals_consistent_tangent_plane(joined)
        seconds = time.process_time() - start
        np.save(folder / f"normals of {name}.npy", np.asarray(cloud.normals))
        print(json.dumps({"processor": seconds, "normals": alone}), flush=True)


def read(path: Path) -> open3d.geometry.PointCloud:
    cloud = open3d.geometry.PointCloud()
    cloud.points = open3d.utility.Vector3dVector(np.load(path))
    return cloud


if __name__ == "__main__":
    main()
