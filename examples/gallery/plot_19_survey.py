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
# The map
# -------
# It is pale where the field is extrapolated: farther from the samples than any held-out sample was.

survey.plot()

# %%
# Is the error true?
# ------------------
# ``predict`` returns values, the 95 % band of their errors and the mark of extrapolation at any
# points: here at all nodes between the first and the last track.

between = node[10:151, 20:160]
x, truth = land.points[between], land.height.ravel()[between]
values, error, extrapolated = survey.predict(x)
miss = np.abs(values - truth)
print(f"root mean square error: {np.sqrt(np.mean(miss**2)):.1f} m")
print(f"covered by the band: {np.mean(miss <= error):.1%}; extrapolated: {extrapolated.any()}")

figure, axes = plt.subplots(1, 2, figsize=(8.4, 4.0), layout="constrained", sharey=True)
top = np.quantile(error, 0.99)
for each, (title, shown) in zip(axes, {"true error": miss, "band": error}.items(), strict=True):
    drawn = each.pcolormesh(*np.moveaxis(x, -1, 0) / 1000, shown, vmin=0, vmax=top, cmap="viridis")
    each.set(xlabel="x [km]", title=title, aspect="equal")
axes[0].set_ylabel("y [km]")
figure.colorbar(drawn, ax=axes, label="error of the height [m]", extend="max", shrink=0.8)

# %%
# What is left to do
# ------------------
# ``survey.write("height.nc")`` writes the map for GIS, ``survey.report("height.html")`` a page with
# the comparison, the variogram and the coverage by distance, and ``survey.field.gradient(points)``
# has slopes. ``fieldrecon reconstruct heights.csv --grid 100x100 --out height.nc`` does the same
# from a table.
