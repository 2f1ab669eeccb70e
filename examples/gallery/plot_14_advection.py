"""
A field carried by a flow
=========================

Semi-Lagrangian steps on scattered points: each step reconstructs the field at the departure
points. The step is not bounded by the distance of the points. Without inflow values the domain
must be one that the flow does not enter from outside, here a disc.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

square = 2 * fr.datasets.halton(2500, 2) - 1
points = square[np.linalg.norm(square, axis=1) < 1]  # the flow maps the disc to itself
values = np.exp(-((points - [0.0, 0.5]) ** 2).sum(axis=1) / 0.02)


def rotation(x, t):
    return np.stack([-x[..., 1], x[..., 0]], axis=-1)


method = fr.PartitionOfUnityRBF(points)
times = np.linspace(0, 2 * np.pi, 21)  # one revolution in 20 steps
states = fr.semi_lagrangian(method, values, rotation, times, steady=True)
shown = {state.time: state.values for state in states}
print(
    f"after one revolution the largest value is {shown[times[-1]].max():.3f} of {values.max():.3f}"
)

figure, axes = plt.subplots(1, 3, figsize=(8.4, 3.2), sharey=True)
for each, time in zip(axes, times[[0, 5, 20]], strict=True):
    filled = each.tricontourf(
        *points.T, shown[time], levels=np.linspace(-0.05, 1.05, 12), extend="both"
    )
    each.set(xlabel="x", aspect="equal", title=f"t = {time:.2f}")
axes[0].set_ylabel("y")
figure.colorbar(filled, ax=axes, label="field", shrink=0.8)
