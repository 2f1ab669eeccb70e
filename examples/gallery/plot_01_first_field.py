"""
A field through scattered points
================================

Construct a method from the points, fit the values, evaluate. The thin-plate spline has no
parameter to choose and interpolates the data.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

points = fr.datasets.halton(200, 2)  # (n, 2)
values = fr.datasets.franke(points)  # (n,)

method = fr.RBF(points, fr.thin_plate_spline())
field = method.field(values)

x = np.linspace(0, 1, 101)
grid = np.stack(np.meshgrid(x, x), axis=-1)  # (101, 101, 2)
error = field(grid) - fr.datasets.franke(grid)
print(f"largest error in the unit square: {abs(error).max():.2g}")

figure, axes = plt.subplots(figsize=(5.2, 4))
filled = axes.contourf(x, x, field(grid), levels=20)
axes.plot(*points.T, ".", color="white", markersize=3)
axes.set(xlabel="x", ylabel="y", aspect="equal")
figure.colorbar(filled, label="field")
