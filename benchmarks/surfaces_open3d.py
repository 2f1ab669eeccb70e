"""Open3D in a separate environment: the Poisson surface of the point cloud named on each line."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
import open3d  # type: ignore[import-not-found] # installed in its own environment only


def main() -> None:
    folder, depth, neighbors = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    print("ready", flush=True)
    for line in sys.stdin:
        name = line.strip()
        points = open3d.utility.Vector3dVector(np.load(folder / f"{name}.npy"))
        start = time.process_time()
        cloud = open3d.geometry.PointCloud(points)
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(neighbors))
        cloud.orient_normals_consistent_tangent_plane(neighbors)
        mesh, _ = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth)
        seconds = time.process_time() - start
        vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
        np.savez(folder / f"surface of {name}.npz", points=vertices, triangles=triangles)
        print(json.dumps({"processor": seconds}), flush=True)


if __name__ == "__main__":
    main()
