"""
Derivatives as data
===================

A curve from twelve points and their normals: the field is zero at the points, and its derivative
along each normal is minus one. Values, derivatives and Laplacians may be mixed.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
radius = 1 + 0.3 * np.cos(3 * angle)
slope = -0.9 * np.sin(3 * angle)
out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
along = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
points = radius[:, None] * out
normals = radius[:, None] * out - slope[:, None] * along
normals /= np.linalg.norm(normals, axis=1, keepdims=True)

data = [fr.methods.values_at(points), fr.methods.derivatives_at(points, normals)]
method = fr.HermiteRBF(data, fr.polyharmonic(5))
field = method.field(np.concatenate([np.zeros(12), -np.ones(12)]))

x = np.linspace(-1.6, 1.6, 161)
grid = np.stack(np.meshgrid(x, x), axis=-1)
figure, axes = plt.subplots(figsize=(5, 4.4))
axes.contour(x, x, field(grid), levels=12, linewidths=0.5)
axes.contour(x, x, field(grid), levels=[0], colors="k")
axes.quiver(*points.T, *normals.T, scale=12, color="tab:red")
axes.set(xlabel="x", ylabel="y", aspect="equal")
