"""
A measured body: the asteroid Kleopatra
=======================================

Radar saw 216 Kleopatra as 600 points with triangles. A field of values and normals gives it a
smooth surface, of any fineness.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr
from fieldcheck.datasets import kleopatra

points, triangles = kleopatra()  # kilometres
corners = points[triangles]
across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
normals = np.zeros_like(points)
for corner in triangles.T:
    np.add.at(normals, corner, across)
normals /= np.linalg.norm(normals, axis=1, keepdims=True)

surface = fr.extract_surface(fr.implicit_surface(points, normals), spacing=6.0)
print(
    f"{len(triangles)} triangles of the radar model, {len(surface.triangles)} of the smooth surface"
)

figure, axes = plt.subplots(1, 2, figsize=(8, 3), subplot_kw={"projection": "3d"})
for each, (p, t) in zip(
    axes, ((points, triangles), (surface.points, surface.triangles)), strict=True
):
    each.plot_trisurf(*p.T, triangles=t, color="tan", edgecolor="none")
    each.set_box_aspect(np.ptp(p, axis=0), zoom=1.25)
    each.set_axis_off()
