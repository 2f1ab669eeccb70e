"""
Which method fits these data?
=============================

Cross-validation holds out samples as far from the others as the queries are, and compares the
methods that ``fieldrecon reconstruct`` compares. Here: 1500 heights of a real terrain.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

land = fr.datasets.terrain()
sites = np.random.default_rng(2).choice(land.height.size, 1500, replace=False)
points, heights = land.points[sites], land.height.ravel()[sites].astype(float)

validator = fr.selection.CrossValidator.of(points, heights, land.points[::97])
scores = validator.compare([*fr.selection.MODELS.values()])
scores = sorted((score for score in scores if np.isfinite(score.rms)), key=lambda score: -score.rms)
for score in scores:
    print(f"{score.rms:5.1f} m  {score.model.name:<9} {score.model.meaning}")

figure, axes = plt.subplots(layout="constrained")
names = [score.model.meaning for score in scores]
axes.barh(names, [score.rms for score in scores], color="tab:blue")
axes.set_xlabel("root mean square error at held-out samples [m]")
