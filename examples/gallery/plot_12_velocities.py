"""
Velocities from fluxes through faces
====================================

A staggered scheme stores the normal velocity of each face. Least squares over the faces around a
vertex gives the velocity vector there.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

mesh = fr.SimplexMesh.delaunay(fr.datasets.jittered_grid(12, 2, jitter=0.5, seed=1))
x, y = mesh.points.T
exact = np.stack(
    [np.sin(np.pi * x) * np.cos(np.pi * y), -np.cos(np.pi * x) * np.sin(np.pi * y)], axis=-1
)

flux = fr.normal_velocities(mesh, exact)  # one number for each face
found = fr.vertex_velocities(mesh, flux).values  # (n, 2)
print(f"largest error: {np.linalg.norm(found - exact, axis=1).max():.2g}")

figure, axes = plt.subplots(figsize=(5.2, 4.4))
axes.triplot(x, y, mesh.cells, color="0.85", linewidth=0.7)
arrows = axes.quiver(
    x, y, *found.T, np.linalg.norm(found - exact, axis=1), cmap="cool_r", clim=(0, 0.5), scale=18
)
figure.colorbar(arrows, label="error")
axes.set(xlabel="x", ylabel="y", aspect="equal")
