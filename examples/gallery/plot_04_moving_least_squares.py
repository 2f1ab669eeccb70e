"""
The parameter of moving least squares
=====================================

With a small ε the field follows the samples; with a large one it approaches the straight line of
least squares. The leave-one-out error chooses ε without a second fit.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

rng = np.random.default_rng(3)
points = np.sort(rng.random((40, 1)), axis=0)
values = np.sin(7 * points[:, 0]) + 0.15 * rng.standard_normal(40)


def method(epsilon):
    return fr.MovingLeastSquares(points, fr.inverse_square(epsilon), degree=1)


def error(epsilon):
    return np.sqrt(np.mean(fr.leave_one_out(method(epsilon), values) ** 2))


epsilons = np.geomspace(0.003, 1, 30)
errors = [error(epsilon) for epsilon in epsilons]
best = epsilons[np.argmin(errors)]

x = np.linspace(0, 1, 400)[:, None]
figure, (curves, scores) = plt.subplots(1, 2, figsize=(7.6, 3.6))
curves.plot(points, values, "k.")
for epsilon in (0.003, best, 1.0):
    curves.plot(x, method(epsilon).field(values)(x), label=f"ε = {epsilon:.2g}")
curves.set(xlabel="x", ylabel="value")
curves.legend()
scores.loglog(epsilons, errors)
scores.plot(best, min(errors), "o")
scores.set(xlabel="ε", ylabel="leave-one-out error")
