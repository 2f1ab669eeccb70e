"""
A field on the globe
====================

Distances are chords through the globe, so that the date line and the poles are not special.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

rng = np.random.default_rng(8)
lonlat = np.stack(
    [rng.uniform(-180, 180, 300), np.degrees(np.arcsin(rng.uniform(-1, 1, 300)))], axis=-1
)
x, y, z = fr.methods.to_unit(lonlat).T
values = x * y + z**3

field = fr.OnGlobe(lonlat, lambda sites: fr.RBF(sites, fr.polyharmonic(3))).field(values)
longitude, latitude = np.linspace(-180, 180, 181), np.linspace(-90, 90, 91)
found = field(np.stack(np.meshgrid(longitude, latitude), axis=-1))
print(f"difference at the date line: {abs(found[:, 0] - found[:, -1]).max():.1g}")

figure, axes = plt.subplots(figsize=(7, 3.6))
filled = axes.contourf(longitude, latitude, found, levels=16)
axes.plot(*lonlat.T, ".", color="white", markersize=2)
axes.set(xlabel="longitude", ylabel="latitude")
figure.colorbar(filled, label="field")
