"""
Barycentric coordinates of a polygon
====================================

Each coordinate is one at its corner and zero on the edges that do not meet it; affine data at the
corners are reproduced.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.6, 1.2], [1.2, 2.2], [-0.2, 1.4]])
method = fr.BarycentricCoordinates(corners)

# points inside: convex combinations of the corners; and the corners themselves
inside = np.random.default_rng(0).dirichlet(np.full(5, 0.7), 40_000) @ corners
x = np.concatenate([corners, inside])
weights = method.weights(x)  # (m, 5)
print(f"affine data are reproduced to {abs(weights @ corners - x).max():.0e}")

figure, axes = plt.subplots(1, 3, figsize=(8.4, 2.8), sharey=True)
for each, corner in zip(axes, (0, 2, 3), strict=True):
    levels = np.linspace(0, 1, 11)
    filled = each.tricontourf(*x.T, weights[:, corner], levels=levels)
    each.plot(*corners[[0, 1, 2, 3, 4, 0]].T, "k-", linewidth=1)
    each.plot(*corners[corner], "o", color="tab:red", clip_on=False)
    each.set(xlabel="x", aspect="equal", title=f"coordinate {corner}")
axes[0].set_ylabel("y")
figure.colorbar(filled, ax=axes, label="coordinate", shrink=0.8)
