"""
Noisy data: smoothing
=====================

``smoothing`` is the variance of a datum in units of the kernel. Zero interpolates the noise; the
leave-one-out error finds a value that does not.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

points = fr.datasets.uniform(400, 2, seed=5)
noise = 0.1 * np.random.default_rng(5).standard_normal(400)
values = fr.datasets.franke(points) + noise


def method(smoothing):
    return fr.RBF(points, fr.polyharmonic(3), smoothing=smoothing)


def error(smoothing):
    return np.mean(fr.leave_one_out(method(smoothing), values) ** 2)


smoothings = np.geomspace(1e-5, 1e-1, 9)
best = min(smoothings, key=error)

x = np.linspace(0, 1, 81)
grid = np.stack(np.meshgrid(x, x), axis=-1)
exact = fr.datasets.franke(grid)
figure, axes = plt.subplots(1, 3, figsize=(8.4, 3.2), sharey=True)
fields = {
    "exact": exact,
    "interpolated": method(0.0).field(values)(grid),
    f"smoothing {best:.2g}": method(best).field(values)(grid),
}
for each, (title, field) in zip(axes, fields.items(), strict=True):
    filled = each.contourf(x, x, field, levels=np.linspace(-0.2, 1.4, 17), extend="both")
    each.set(xlabel="x", xticks=[0, 0.5, 1], aspect="equal", title=title)
    print(f"{title}: root mean square error {np.sqrt(np.mean((field - exact) ** 2)):.3f}")
axes[0].set_ylabel("y")
figure.colorbar(filled, ax=axes, label="field", shrink=0.8)
