"""
Many points: a partition of unity
=================================

Twenty thousand heights of a real terrain. ``PartitionOfUnityRBF`` takes the place of ``RBF``;
time and memory grow in proportion to the number of points, and millions of them fit into a
laptop.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

land = fr.datasets.terrain()
sites = np.random.default_rng(7).choice(land.height.size, 20_000, replace=False)
points, heights = land.points[sites], land.height.ravel()[sites]

method = fr.PartitionOfUnityRBF(points, fr.thin_plate_spline(), degree=1)
found = method.field(heights)(land.points).reshape(land.height.shape)
error = found - land.height
print(f"root mean square error: {np.sqrt(np.mean(error**2)):.1f} m")

extent = [land.x[0] / 1000, land.x[-1] / 1000, land.y[0] / 1000, land.y[-1] / 1000]
figure, axes = plt.subplots(figsize=(6, 4.4))
picture = axes.imshow(error, cmap="PuOr_r", vmin=-40, vmax=40, extent=extent)
axes.set(xlabel="east [km]", ylabel="north [km]")
figure.colorbar(picture, label="error [m]", extend="both")
