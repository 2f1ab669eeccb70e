"""
Loads between two meshes
========================

Displacements of a structure are interpolated to the surface of the flow mesh; the transpose
transfers the loads back. Then work, force and moment are the same on both sides.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

structure = fr.datasets.jittered_grid(5, 3, jitter=0.4, seed=2) * [4.0, 1.0, 0.2]  # nodes of a beam
surface = fr.datasets.halton(800, 3) * [4.0, 1.0, 0.2]  # points where the flow knows the pressure
loads = np.zeros((800, 3))
loads[:, 2] = np.sqrt(np.clip(4.0 - surface[:, 0], 0, None)) / 800

coupling = fr.Coupling(fr.RBF(structure, fr.thin_plate_spline()), surface)
transferred = coupling.loads(loads)  # (125, 3)

before = fr.coupling.net_force_and_moment(surface, loads, about=[0, 0, 0])
after = fr.coupling.net_force_and_moment(structure, transferred, about=[0, 0, 0])
print(f"largest change of force and moment: {abs(after - before).max():.0e}")

bent = coupling.displacements(
    np.stack([0 * structure[:, 0], 0 * structure[:, 0], 0.05 * structure[:, 0] ** 2], axis=-1)
)
figure, (left, right) = plt.subplots(2, 1, figsize=(6.4, 4.6), sharex=True)
left.stem(structure[:, 0], transferred[:, 2], basefmt=" ", markerfmt=".")
left.set_ylabel("load of a node")
right.plot(surface[:, 0], (surface + bent)[:, 2], ".", markersize=2)
right.set(xlabel="span", ylabel="displaced surface")
