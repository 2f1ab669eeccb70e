"""The page's elastic wing against the coupled model of the report."""

import numpy as np

from fieldreport.widgets.elastic_wing import COARSE, wing
from living_page import Rounded

NAME = "elastic_wing"


def library(state, data, numbers):  # noqa: ARG001
    """Equilibrium by a solve with the feedback; the residual by flow and structure in turns."""
    sweep, q = float(state["sweep"]), state["ratio"] * COARSE.pressure
    model, incidences = wing(sweep), COARSE.incidences(sweep)
    rigid = model.lattice.circulations(incidences)
    matrix = np.eye(rigid.size) - q * model.feedback
    gamma = np.linalg.solve(matrix, rigid.ravel()).reshape(rigid.shape)
    condition = np.linalg.cond(matrix)
    z = model.heights(q * model.deflections(model.lattice.forces(gamma)))
    g, steps = rigid, []
    for _ in range(6):
        w = q * model.deflections(model.lattice.forces(g))
        steps.append(model.circulations(w, incidences) - g)
        g = g + state["relaxation"] * steps[-1]
    residual = np.linalg.norm(steps[5]) / np.linalg.norm(steps[0])
    cancellation = np.linalg.norm(g) / np.linalg.norm(steps[5])  # a step is a small difference
    return {
        "exists": int(q < model.divergence_pressure),
        "tip": Rounded(z.reshape(model.lattice.shape[0] + 1, -1)[:, -1].mean(), 100 * condition),
        "lift": Rounded(model.lattice.lift_coefficient(gamma), 100 * condition),
        "rigidLift": model.lattice.lift_coefficient(rigid),
        "factor": q * model.eigenvalues[0].real,
        "residual": Rounded(residual, 10 * cancellation),
    }


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_the_equilibrium_is_that_of_the_iteration(living):
    """With relaxation by one half, the deflections of the library converge to those of the page."""
    living.reset()
    sweep = COARSE.sweep
    found = wing(sweep).steady_state(COARSE.pressure, COARSE.incidences(sweep), 0.5, tol=1e-12)
    tip = wing(sweep).heights(found.value).reshape(wing(sweep).lattice.shape[0] + 1, -1)[:, -1]
    assert found.converged
    assert abs(tip.mean() / living.numbers["tip"] - 1) < 1e-9


def test_a_forward_swept_wing_diverges(living):
    """It has no equilibrium beyond its pressure of divergence; a backward-swept wing has one."""
    living.press(living.controls("input[data-value='-20']")[0], "Space")
    slider = living.controls("input[type=range]")[0]
    assert not living.controls(".results .warn")
    living.press(slider, "End")
    assert len(living.controls(".results .warn")) == 1
    assert living.numbers["exists"] == 0
    assert living.numbers["observed"] > 1
    living.press(living.controls("input[data-value='30']")[0], "Space")
    assert living.numbers["exists"] == 1
