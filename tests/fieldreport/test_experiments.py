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
from fieldrecon.plotting.figure_files import figure_bytes
from fieldreport import experiments
from fieldreport.framework import result_files as files
from fieldreport.framework.error_measures import order_of_magnitude

NAMES = experiments.names()


@pytest.fixture(scope="module", params=NAMES)
def experiment(request):
    return experiments.get(request.param)


@pytest.fixture(scope="module")
def result(experiment):
    return experiment.run(experiment.quick)


def numbers(result):
    """Yield every number that a reader may see, with its name."""
    yield from result.facts.items()
    for name, table in result.tables.items():
        for column in table.columns:
            yield from ((f"{name}: {column}", cell) for cell in table.column(column))


def test_it_has_a_title_and_tells_what_its_parameters_are(experiment):
    """A title, a description, a meaning for each parameter, and a small variant that differs."""
    assert re.fullmatch(r"[A-Z].{9,99}[^.]", experiment.title)
    assert experiment.description
    assert all(experiment.meanings.values())
    assert experiment.quick != experiment.defaults
    with pytest.raises(FrozenInstanceError):
        experiment.defaults.seed = 1


def test_it_finds_something(experiment, result):
    """A run has its own parameters, a table and facts; numbers are finite and plain."""
    assert result.params == experiment.quick
    assert result.tables
    assert result.facts
    for name, x in numbers(result):
        assert type(x) in (int, float, str), name
        assert isinstance(x, str) or np.isfinite(x), name
    for name, array in result.arrays.items():
        assert array.dtype.kind not in "fc" or np.isfinite(array).all(), name
    assert all(re.fullmatch(r"[a-z][a-z0-9_]*", name) for name in (*result.facts, *result.tables))


def test_its_facts_have_the_digits_that_it_states(experiment, result):
    """What it states digits of are facts; a float has no more digits than are stated."""
    stated = getattr(experiment.module, "DIGITS", {})
    assert stated.keys() <= result.facts.keys()
    for name, x in result.facts.items():
        digits = experiment.digits(name)
        assert digits == stated.get(name, 6)
        if isinstance(x, float):
            kept = float(f"{x:.{digits}g}") if digits else order_of_magnitude(x)
            assert kept == x, name


@pytest.mark.slow
def test_it_says_the_same_each_time(experiment, result):
    """The same parameters give the same result, also when sub-runs go to a pool of workers."""
    with ThreadPoolExecutor(2) as pool:
        assert experiment.run(experiment.quick, pool.map) == result


@pytest.mark.slow
def test_its_seed_counts(experiment, result):
    """Another seed gives another result, unless nothing is drawn."""
    if "seed" not in {f.name for f in fields(experiment.quick)}:
        return
    other = experiment.run(replace(experiment.quick, seed=experiment.quick.seed + 1))
    assert replace(other, params=result.params) != result


def test_it_survives_writing_and_reading(experiment, result, tmp_path):
    """What is read back is what was written, and writing it again gives the same bytes."""
    folder = tmp_path / experiment.name
    written = files.write_result(result, folder)
    before = {path: path.read_bytes() for path in written}
    back = files.read_result(folder, experiment)
    assert back == result
    files.write_result(back, folder)
    assert {path: path.read_bytes() for path in written} == before
    assert set(folder.iterdir()) == set(written)


@pytest.mark.slow
def test_its_figures_need_nothing_but_the_result(experiment, result, tmp_path):
    """Every plot draws from a result that was read back, and twice the same bytes."""
    folder = tmp_path / experiment.name
    files.write_result(result, folder)
    back = files.read_result(folder, experiment)
    assert experiment.name in experiment.plots
    for name, plot in experiment.plots.items():
        page = plot(back)
        assert isinstance(page, Figure), name
        assert page.axes, name
        assert figure_bytes(page, "svg") == figure_bytes(plot(result), "svg"), name


def test_the_title_in_the_source_is_that_of_the_module(experiment):
    """The list reads what an import would give."""
    assert experiments.titles()[experiment.name] == experiment.title


def test_names_are_found_without_importing_anything():
    """Listing the experiments imports neither them nor matplotlib."""
    code = (
        "import sys; from fieldreport.experiments import names; print(*names()); "
        "assert 'matplotlib' not in sys.modules"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert tuple(shown.stdout.split()) == NAMES
    assert "experiment" not in NAMES
    assert "files" not in NAMES


def test_there_is_no_other_experiment():
    """An unknown name is told with the names that exist."""
    with pytest.raises(ValueError, match=r"no experiment 'power'; there are .*power_sampling"):
        experiments.get("power")
    assert importlib.util.find_spec("fieldreport.experiments.power") is None


CHAPTERS = ROOT / "report" / "chapters"
QUOTED = re.compile(r"\{\{(?P<experiment>\w+)\.(?P<params>params\.)?(?P<name>\w+)(:[^}]*)?\}\}")


def test_what_the_text_quotes_exists(experiment, result):
    """Each fact and parameter that a chapter quotes from an experiment is one that it has."""
    text = "".join(path.read_text(encoding="utf-8") for path in sorted(CHAPTERS.glob("*.md")))
    for quote in QUOTED.finditer(text):
        if quote["experiment"] == experiment.name:
            known = experiment.meanings if quote["params"] else result.facts
            assert quote["name"] in known, quote[0]
