"""
Real terrain from 600 heights
=============================

Heights of the Jacksboro fault in Tennessee at 600 points, as in ``examples/heights.csv``. The
other heights of the elevation model show the error.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LightSource

import fieldrecon as fr

land = fr.datasets.terrain()
sites = np.random.default_rng(1).choice(land.height.size, 600, replace=False)
points, heights = land.points[sites], land.height.ravel()[sites]

field = fr.RBF(points, fr.thin_plate_spline()).field(heights)
found = field(land.points).reshape(land.height.shape)
print(f"root mean square error: {np.sqrt(np.mean((found - land.height) ** 2)):.0f} m")

sun = LightSource(azdeg=315, altdeg=45)
extent = [land.x[0] / 1000, land.x[-1] / 1000, land.y[0] / 1000, land.y[-1] / 1000]
figure, axes = plt.subplots(1, 2, figsize=(7.6, 4), sharey=True)
for each, picture, title in zip(
    axes, (land.height, found), ("land", "from 600 heights"), strict=True
):
    shade = sun.hillshade(picture, vert_exag=3, dx=75, dy=-92)
    each.imshow(shade, cmap="gray", extent=extent)
    each.set(title=title, xlabel="east [km]")
axes[0].set_ylabel("north [km]")
axes[1].plot(*points.T / 1000, ".", color="tab:orange", markersize=2)
