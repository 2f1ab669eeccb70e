"""Requirements that every experiment must satisfy."""

import importlib.util
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from checkout import ROOT
from fieldreport import experiments
from fieldreport.framework import result_files as files
from fieldreport.framework.orders_of_magnitude import OrderOfMagnitude, order_of_magnitude

SHORT = {"cell_velocity", "coupling", "dual_meshes", "epsilon_sweep", "hermite_data"}
SHORT |= {"hexagon_spiral", "natural_splines", "peers", "polygon_soup", "power_sampling"}
NAMES = experiments.names()
CASES = [pytest.param(name, marks=() if name in SHORT else pytest.mark.slow) for name in NAMES]


@pytest.fixture(scope="module", params=CASES)
def experiment(request):
    return experiments.get(request.param)


@pytest.fixture(scope="module")
def result(experiment):
    return experiment.run(experiment.quick)


def numbers(result):
    """Yield every number that a reader can see, with its name."""
    yield from result.facts.items()
    for name, table in result.tables.items():
        for column in table.columns:
            yield from ((f"{name}: {column}", cell) for cell in table.column(column))


def test_it_has_a_title_and_describes_its_parameters(experiment):
    """It has a title, a description, a meaning for each parameter, and a smaller variant."""
    assert re.fullmatch(r"[A-Z].{9,99}[^.]", experiment.title)
    assert experiment.description
    assert all(experiment.meanings.values())
    assert experiment.quick != experiment.defaults
    with pytest.raises(FrozenInstanceError):
        experiment.defaults.seed = 1


def test_its_result_has_tables_and_facts_with_finite_numbers(experiment, result):
    """The result contains its parameters, and its numbers are plain Python numbers."""
    assert result.params == experiment.quick
    assert result.tables
    assert result.facts
    for name, x in numbers(result):
        assert type(x) in (int, float, OrderOfMagnitude, str), name
        assert isinstance(x, str) or np.isfinite(x), name
    for name, array in result.arrays.items():
        assert array.dtype.kind not in "fc" or np.isfinite(array).all(), name
    assert all(re.fullmatch(r"[a-z][a-z0-9_]*", name) for name in (*result.facts, *result.tables))


def test_its_facts_are_rounded_to_the_stated_digits(experiment, result):
    """DIGITS names facts only, and a float has no more digits than stated."""
    stated = getattr(experiment.module, "DIGITS", {})
    assert stated.keys() <= result.facts.keys()
    for name, x in result.facts.items():
        digits = experiment.digits(name)
        assert digits == stated.get(name, 6)
        if type(x) is float:
            kept = float(f"{x:.{digits}g}") if digits else order_of_magnitude(x)
            assert kept == x, name


@pytest.mark.slow
def test_it_is_reproducible(experiment, result):
    """The result is the same when sub-runs are executed by a pool of workers."""
    with ThreadPoolExecutor(2) as pool:
        assert experiment.run(experiment.quick, pool.map) == result


@pytest.mark.slow
def test_its_result_depends_on_its_seed(experiment, result):
    """This applies to experiments with a seed."""
    if "seed" not in {f.name for f in fields(experiment.quick)}:
        return
    other = experiment.run(replace(experiment.quick, seed=experiment.quick.seed + 1))
    assert replace(other, params=result.params) != result


def test_its_result_is_reproduced_from_its_files(experiment, result, tmp_path):
    """Writing the result again gives the same bytes."""
    folder = tmp_path / experiment.name
    written = files.write_result(result, folder)
    before = {path: path.read_bytes() for path in written}
    back = files.read_result(folder, experiment)
    assert back == result
    files.write_result(back, folder)
    assert {path: path.read_bytes() for path in written} == before
    assert set(folder.iterdir()) == set(written)


def pixels(page):
    """The figure as it is drawn, in few pixels: that takes a third of the time of a file."""
    page.set_dpi(40)
    page.canvas.draw()
    return bytes(page.canvas.buffer_rgba())


@pytest.mark.slow
def test_its_figures_depend_on_its_result_only(experiment, result, tmp_path):
    """Figures from a result read from files have the same pixels as from the original result."""
    folder = tmp_path / experiment.name
    files.write_result(result, folder)
    back = files.read_result(folder, experiment)
    assert experiment.name in experiment.plots
    for name, plot in experiment.plots.items():
        page = plot(back)
        assert isinstance(page, Figure), name
        assert page.axes, name
        assert pixels(page) == pixels(plot(result)), name


def test_the_title_read_from_the_source_agrees_with_the_import(experiment):
    """The list of experiments is made without importing them."""
    assert experiments.titles()[experiment.name] == experiment.title


def test_names_are_found_without_importing_experiments():
    """Listing the experiments does not import matplotlib either."""
    code = (
        "import sys; from fieldreport.experiments import names; print(*names()); "
        "assert 'matplotlib' not in sys.modules"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert tuple(shown.stdout.split()) == NAMES
    assert "experiment" not in NAMES
    assert "files" not in NAMES


def test_an_unknown_experiment_is_refused():
    """The message lists the existing experiments."""
    with pytest.raises(ValueError, match=r"no experiment 'power'; there are .*power_sampling"):
        experiments.get("power")
    assert importlib.util.find_spec("fieldreport.experiments.power") is None


CHAPTERS = ROOT / "report" / "chapters"
QUOTED = re.compile(r"\{\{(?P<experiment>\w+)\.(?P<params>params\.)?(?P<name>\w+)(:[^}]*)?\}\}")


def test_quoted_facts_and_parameters_exist(experiment, result):
    """Every fact and parameter that a chapter quotes is in the result."""
    text = "".join(path.read_text(encoding="utf-8") for path in sorted(CHAPTERS.glob("*.md")))
    for quote in QUOTED.finditer(text):
        if quote["experiment"] == experiment.name:
            known = experiment.meanings if quote["params"] else result.facts
            assert quote["name"] in known, quote[0]
