"""
One variable: the natural cubic spline
======================================

Of all interpolants, the natural cubic spline bends least. It continues as a straight line beyond
the data.
"""

import matplotlib.pyplot as plt
import numpy as np

import fieldrecon as fr

sites = np.array([0.0, 1.0, 1.5, 3.0, 4.2, 5.0])
values = np.array([0.0, 1.2, 0.9, -0.6, 0.3, 0.2])
spline = fr.NaturalCubicSpline(sites).field(values)

x = np.linspace(-1, 6, 300)
figure, axes = plt.subplots()
axes.plot(x, spline(x), label="spline")
axes.plot(x, spline.gradient(x), "--", label="slope")
axes.plot(sites, values, "ko", label="data")
axes.set_xlabel("x")
axes.legend()
