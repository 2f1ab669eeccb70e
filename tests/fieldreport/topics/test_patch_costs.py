"""Costs of patches: facts agree with the measurements, and exponents refer to the plane only."""

import json

import pytest

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldreport.experiments import get
from fieldreport.experiments.methods.patch_costs import _of_growth
from fieldreport.framework.experiment import ResultTable, in_checkout

EXPERIMENT = get("patch_costs")


def growth(power):
    """A table whose seconds are n^power in the plane; values in space are arbitrary."""
    rows = [(n, 2, *3 * (float(n) ** power,), 1e-9 * n, 1e-3) for n in (10, 100, 1000)]
    columns = (
        "sites",
        "dimension",
        "set-up, s",
        "fit, s",
        "evaluate, s",
        "memory, GB",
        "rms error",
    )
    return ResultTable(columns, (*rows, (100, 3, 1e9, 1e9, 1e9, 1.0, 1.0)))


@pytest.mark.parametrize("power", [0.9, 1.0, 2.0])
def test_exponents_agree_with_the_measured_seconds(power):
    """For n^p seconds each exponent is p, also for sums; point clouds in space are ignored."""
    facts = dict(_of_growth(growth(power)))
    for name in ("set_up", "fit", "evaluate", "fitting", "all"):
        assert facts[f"exponent_{name}"] == pytest.approx(power)
    assert facts["most_sites"] == 1000


def test_the_documented_defaults_are_those_of_the_library():
    """Kernel, degree and patch size."""
    method = PartitionOfUnityRBF(uniform(1000, 2, seed=1))
    params = EXPERIMENT.defaults
    assert method.kernel == polyharmonic(int({"³": 3}[params.kernel[1:]]))
    assert (method.degree, method.patch_size) == (params.degree, params.patch)


def test_the_table_contains_every_measured_choice():
    measured = json.loads(in_checkout(EXPERIMENT.defaults.results).read_text("utf-8"))
    choices = EXPERIMENT.run().tables["choices"]
    assert len(choices.rows) == len(measured["tables"][0]["rows"])
