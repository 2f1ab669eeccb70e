"""
Gradients
=========

The gradient of a field is the exact derivative of the reconstruction, weights included: no
differences are taken.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

points = fr.datasets.halton(300, 2)
field = fr.MovingLeastSquares(points, fr.inverse_square(0.06), degree=2).field(
    fr.datasets.franke(points)
)

x = np.linspace(0, 1, 101)
grid = np.stack(np.meshgrid(x, x), axis=-1)
coarse = grid[5::9, 5::9]
slope = field.gradient(coarse)  # (..., 2)
error = np.linalg.norm(slope - fr.datasets.franke.gradient(coarse), axis=-1)
print(f"median error of the gradient: {np.median(error):.2g}")

figure, axes = plt.subplots(figsize=(5, 4))
axes.contour(x, x, field(grid), levels=14, linewidths=0.8)
axes.quiver(*np.moveaxis(coarse, -1, 0), *np.moveaxis(slope, -1, 0), color="tab:red")
axes.set(xlabel="x", ylabel="y", aspect="equal")
