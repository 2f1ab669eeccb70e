"""
A surface from a scan
=====================

Points of a scan without normals become a closed mesh: normals, their orientation, an implicit
surface, triangles.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

points = fr.io.read_cloud(Path("..") / "scan.xyz").points[::3]

normals = fr.orient_normals(points, fr.estimate_normals(points).vectors)
body = fr.implicit_surface(points, normals)
surface = fr.extract_surface(body, spacing=0.12)
audit = fr.audit_mesh(surface.points, surface.triangles)
print(f"{len(surface.triangles)} triangles, boundary loops: {len(audit.boundary_loops)}")

figure, axes = plt.subplots(1, 2, figsize=(8, 3.6), subplot_kw={"projection": "3d"})
axes[0].scatter(*points.T, s=2, color="#3c8dce", depthshade=False)
axes[1].plot_trisurf(
    *surface.points.T, triangles=surface.triangles, color="lightsteelblue", edgecolor="none"
)
for each in axes:
    each.set_box_aspect(np.ptp(points, axis=0), zoom=1.25)
    each.set_axis_off()
