"""
Voronoi coordinates on a Delaunay mesh
======================================

Values at the circumcentres of the cells, for example pressures of a finite-volume scheme, give a
value at a vertex.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

points = fr.datasets.jittered_grid(8, 2, jitter=0.6, seed=4)
mesh = fr.SimplexMesh.delaunay(points)
middle = int(np.argmin(np.linalg.norm(points - 0.5, axis=1)))
cell = fr.VoronoiCell(mesh, middle)
weights = np.ravel(cell.weights(points[middle][None]))
print(f"the weights sum to {weights.sum():.12f}")

figure, axes = plt.subplots(figsize=(5, 4.4))
axes.triplot(*points.T, mesh.cells, color="0.8", linewidth=0.8)
about = cell.points - points[middle]
ring = cell.points[np.argsort(np.arctan2(*about.T))]
axes.fill(*ring.T, color="tab:blue", alpha=0.25)
axes.scatter(*cell.points.T, s=600 * weights, color="tab:blue")
axes.plot(*points[middle], "k*", markersize=10)
axes.set(xlim=(0.25, 0.75), ylim=(0.25, 0.75), aspect="equal", xlabel="x", ylabel="y")
