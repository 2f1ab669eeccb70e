"""
Errors of a triangle mesh
=========================

An audit lists the errors of a mesh, and a repair makes the changes that are unambiguous.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import fieldrecon as fr

points, triangles = fr.io.read_triangles(Path("..") / "damaged.stl")
repair = fr.repair_mesh(points, triangles, largest_hole=1.0)
for name, audit in (("before", repair.before), ("after", repair.after)):
    print(
        f"{name}: {len(audit.boundary_loops)} boundary loops, "
        f"{len(audit.flipped_triangles)} flipped triangles, "
        f"{len(audit.duplicate_triangles)} duplicate triangles"
    )
for what, count in repair.done.items():
    print(f"{what.replace('_', ' ')}: {count}")

figure, axes = plt.subplots(1, 2, figsize=(7, 3.4), subplot_kw={"projection": "3d"})
pairs = ((points, triangles, "damaged"), (repair.points, repair.triangles, "repaired"))
for each, (p, t, title) in zip(axes, pairs, strict=True):
    each.plot_trisurf(*p.T, triangles=t, color="lightsteelblue", alpha=0.8, edgecolor="0.3")
    each.set_title(title)
    each.set_axis_off()
