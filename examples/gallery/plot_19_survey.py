"""
A survey along tracks: a map, its error, and where it ends
==========================================================

A tutorial for engineers. Heights were measured along tracks, dense along each track and sparse
across. Wanted are a map, a bound of its error, and where not to trust it. Here the terrain is known
between the tracks, too, so the promises can be checked.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

land = fr.datasets.terrain()
node = np.arange(land.height.size).reshape(land.height.shape)
tracks = node[10:160:10, 20:160].ravel()
points, height = land.points[tracks], land.height.ravel()[tracks].astype(float)
print(f"{len(points)} samples on {len(np.unique(points[:, 1]))} tracks")

# %%
# One call
# --------
# All methods are compared at samples that are held out together with their neighbours, so that they
# are as far from the others as the nodes of the grid are from the tracks. Samples left out one by
# one would have neighbours on their track, and would promise too much. A file or a data frame with
# the names of its columns can stand for the arrays, and ``sigma`` takes standard deviations.

survey = fr.pipelines.reconstruct(points, value=height, grid=(100, 100))
print("chosen:", survey.method)
for score in survey.ranked[:4]:
    print(f"{score.rms:5.1f} m at held-out samples: {score.model.meaning}")
for sentence in survey.warnings:
    print("-", sentence)

# %%
# The map, and is its error true?
# -------------------------------
# ``survey.plot()`` draws the map in a notebook. ``predict`` returns values, the 95 % band of their
# errors, and the mark of extrapolation at any points: here at all nodes between the first track and
# the last.

between = node[10:151, 20:160]
x, truth = land.points[between], land.height.ravel()[between]
values, error, extrapolated = survey.predict(x)
miss = np.abs(values - truth)
print(f"root mean square error: {np.sqrt(np.mean(miss**2)):.1f} m")
print(f"within the band: {np.mean(miss <= error):.1%}")
print(f"extrapolated, too far from the samples: {np.mean(extrapolated > 0):.1%}")

figure, axes = plt.subplots(1, 3, figsize=(10.5, 4.6), layout="constrained", sharey=True)
km = np.moveaxis(x, -1, 0) / 1000
height_map = axes[0].pcolormesh(*km, values, cmap="viridis", rasterized=True)
axes[0].plot(*points.T / 1000, ".", color="white", markersize=0.8)
figure.colorbar(height_map, ax=axes[0], label="height [m]", location="bottom")
for each, shown in zip(axes[1:], (miss, error), strict=True):
    errors = each.pcolormesh(*km, shown, vmin=0, vmax=150, cmap="magma", rasterized=True)
figure.colorbar(errors, ax=axes[1:], label="error [m]", location="bottom", extend="max")
for each, title in zip(axes, ("map and samples", "true error", "95 % band"), strict=True):
    each.set(xlabel="x [km]", title=title, aspect="equal")
axes[0].set_ylabel("y [km]")

# %%
# What is left to do
# ------------------
# ``survey.write("height.nc")`` writes the map for GIS, ``survey.report("height.html")`` a page with
# the comparison, the variogram and the coverage by distance, and ``survey.field.gradient(points)``
# has slopes. ``fieldrecon reconstruct heights.csv --grid 100x100 --out height.nc`` does the same
# from a table.
