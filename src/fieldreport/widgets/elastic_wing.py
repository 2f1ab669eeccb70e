"""The elastic wing with a coarse lattice: the feedback of the flow for three sweeps."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from fieldreport.experiments.coupling.elastic_wing import NONE, Params
from fieldreport.experiments.coupling.static_aeroelasticity import ElasticWing

COARSE = replace(Params(), panels=(2, 8), pieces=(8, 24))
"""The wing of the report, with meshes whose matrices fit on a page."""


@cache
def wing(sweep: float) -> ElasticWing:
    """Return the wing with a sweep in degrees."""
    return COARSE.wing(sweep)


def data() -> dict[str, Any]:
    """Return the matrices for each sweep; circulations are divided by the speed."""
    air = wing(COARSE.sweeps[0]).lattice
    across, along = air.shape
    y = air.points.reshape(across + 1, along + 1, 2)[0, :, 1]
    return {
        "pressure": COARSE.pressure,
        "span": np.round(y, 6).tolist(),
        "sweeps": {f"{sweep:g}": matrices(sweep) for sweep in COARSE.sweeps},
    }


def matrices(sweep: float) -> dict[str, Any]:
    """Return the feedback T, the rise of the wing per circulation, and the lift coefficients.

    The rise at each station along the span is the mean over its corners, for a dynamic pressure of
    one.
    """
    model = wing(sweep)
    count = model.lattice.spans.size
    one_by_one = np.eye(count).reshape(*model.lattice.shape, count)
    z = model.heights(model.deflections(model.lattice.forces(one_by_one)))
    stations = z.reshape(model.lattice.shape[0] + 1, -1, count)
    limit = model.divergence_pressure
    return {
        "feedback": model.feedback.tolist(),
        "rigid": model.lattice.circulations(COARSE.incidences(sweep)).ravel().tolist(),
        "rise": stations.mean(axis=0).tolist(),
        "lift": [float(model.lattice.lift_coefficient(one_by_one[..., k])) for k in range(count)],
        "eigenvalue": float(model.eigenvalues[0].real),
        "divergence": float(limit) if limit < NONE * COARSE.pressure else None,
    }
