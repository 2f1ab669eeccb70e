"""Experiments with arbitrary parameters: a finite result, or an error that names a parameter."""

import math
import re
from dataclasses import fields, replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from checkout import ROOT
from fieldreport import experiments
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import ExperimentError
from fieldreport.framework.parameters import Domain

NAMES = experiments.names()
HEAVY = {"adaptive_front", "fluid_animation", "mesh_errors", "surface_reconstruction"}
LARGEST = {
    ("mesh_errors", "level"): 2,
    ("mesh_errors", "levels"): 3,
    ("mesh_errors", "body"): 3,
}
"""Largest values that are drawn, where the cost grows exponentially."""
SMALLEST = {
    ("adaptive_front", "spacing"): 0.02,
    ("fluid_animation", "finest"): 0.1,
    ("fluid_animation", "spacing"): 0.15,
    ("fluid_frame", "steps_3d"): 0.4,
    ("fluid_frame", "arc"): 0.05,
    ("surface_reconstruction", "frame"): 0.2,
    ("terrain", "every"): 4,
    ("terrain", "apart"): 300,
    ("terrain", "spacing"): 50,
    ("terrain", "spacings"): 50,
}
"""Smallest values that are drawn, where the cost grows as they decrease."""
MARGIN = 15
"""Pixels by which the centre of a label may lie outside its panel."""
INTERNAL = re.compile(r"nan\b|reshape|unpack|broadcast|index|argument|array|operand|\bNone\b")
"""Words of internal error messages, which do not help the user."""


def declared(params):
    """Yield name, domain and value of each parameter that is not an input file."""
    for f in fields(params):
        if not f.metadata.get("file"):
            yield f.name, f.metadata["domain"], getattr(params, f.name)


def outside(domain, kind):
    """Yield numbers outside a domain, as close to it as the type allows."""
    if kind is float:
        yield from (math.nan, math.inf, -math.inf)
    for bound, away in ((domain.least, -1), (domain.most, 1)):
        if bound is not None:
            yield kind(math.nextafter(bound, away * math.inf)) if kind is float else bound + away
    yield from (kind(bound) for bound in (domain.above, domain.below) if bound is not None)


def lists_outside(domain, value):
    """Yield lists of the wrong length, or with repeated entries."""
    if domain.entries:
        yield from (value[:-1], (*value, value[-1]))
    elif domain.order:
        yield (*value, value[0])
        if domain.fewest > 1:
            yield value[:1]


def test_each_parameter_is_refused_outside_its_domain():
    """The message names the parameter, the requirement and the value; floats have two bounds."""
    for name in NAMES:
        quick = experiments.get(name).quick
        for parameter, domain, value in declared(quick):
            listed = isinstance(value, tuple)
            kind = type(value[0] if listed else value)
            if kind is str:
                wrong = ["no such choice"]
                assert domain.choices
            else:
                wrong = list(outside(domain, kind))
                assert len(wrong) >= (4 if kind is float else 1), (name, parameter)
            wrong = [(x, *value[1:]) if listed else x for x in wrong]
            for x in (*wrong, *(lists_outside(domain, value) if listed else ())):
                with pytest.raises(ValueError, match=f"^parameter {parameter} must ") as refused:
                    replace(quick, **{parameter: x})
                assert "got" in str(refused.value), (name, parameter, x)


def test_a_list_of_sizes_may_be_given_in_any_order():
    """Parameters with reversed lists are equal, so that the finest mesh is always found."""
    for name in NAMES:
        quick = experiments.get(name).quick
        for parameter, domain, value in declared(quick):
            if domain.order:
                assert replace(quick, **{parameter: value[::-1]}) == quick, (name, parameter)


CONTRADICTIONS = [
    ("adaptive_front", {"coarsen": 0.1}, "coarsen must be less than refine; got 0.1"),
    ("cell_velocity", {"triangle": (0.0, 0, 1, 1, 2, 2)}, "triangle must be three corners"),
    ("cell_velocity", {"triangle": (0, 0, 1e6, 0, 5e5, 1e-6)}, "triangle .* line, to 1e-06 of"),
    ("elastic_wing", {"angle": -4.5, "incidence": (4.5, 4.5), "camber": 0.0}, "angle must be"),
    ("epsilon_sweep", {"largest": 1e-4}, "largest must be 0.001 or more, 10 times smallest"),
    ("epsilon_sweep", {"noises": (0.1, 0.5)}, "noises must be a list with 0"),
    ("epsilon_sweep", {"shown_noise": 0.1}, "shown_noise must be one of noises; got 0.1"),
    ("fluid_animation", {"finest": 0.3}, "finest must be spacing or less; got 0.3"),
    ("high_dimensions", {"at": 4}, "at must be one of variables; got 4"),
    ("high_dimensions", {"at": 100}, "more must be 102 or more each"),
    ("hexagon_spiral", {"steps": 5}, r"steps must be 7 or more \(the first .*\); got 5"),
    ("partition_of_unity", {"told": 16}, "told must be one of sizes; got 16"),
    ("partition_of_unity", {"queries": 200_000}, "queries must be 138032 or less"),
    ("polyhedra", {"shifts": 2}, "shifts must be so many that two"),
    ("polyhedra", {"largest_shift": 1e-10}, "largest_shift must be 2e-10 or more"),
    ("power_sampling", {"powers": (1,)}, "powers must be a list that holds an n of 2 or more"),
    ("pressure_gradients", {"largest": 0.01}, "largest must be more than smallest; got 0.01"),
    ("terrain", {"shown_degree": 3}, "shown_degree must be one of degrees; got 3"),
]


def test_contradictory_parameters_are_refused():
    """The message has the form of the messages about domains."""
    for name, changes, words in CONTRADICTIONS:
        quick = experiments.get(name).quick
        with pytest.raises(ValueError, match=f"parameter {words}"):
            replace(quick, **changes)


def near(domain, value, low, high):
    """Draw a number in a domain: at its bounds, or near a value."""
    low = max(x for x in (domain.least, domain.above, low, -math.inf) if x is not None)
    high = min(x for x in (domain.most, domain.below, high, math.inf) if x is not None)
    if isinstance(value, int):
        return st.integers(low, min(high, max(low, value) + 2))
    ends = [float(x) for x in (low, high) if math.isfinite(x)]
    factors = st.floats(0.2, 5).map(lambda f: float(f"{min(max(f * value, low), high):.4g}"))
    return (st.sampled_from(ends) | factors if ends else factors).filter(domain.holds)


def drawn(name, parameter, domain, value):
    """Draw a value of a parameter, or a list that may repeat an entry or be too short."""
    if isinstance(value, str):
        return st.sampled_from(domain.choices)
    low, high = SMALLEST.get((name, parameter)), LARGEST.get((name, parameter))
    if not isinstance(value, tuple):
        return near(domain, value, low, high)
    entry = st.one_of([near(domain, x, low, high) for x in value])
    longest = domain.entries or 4
    return st.lists(entry, min_size=domain.entries or 1, max_size=longest).map(tuple)


@st.composite
def changed(draw, name, quick):
    """Draw new values for a few parameters."""
    known = {parameter: rest for parameter, *rest in declared(quick)}
    chosen = draw(st.lists(st.sampled_from(sorted(known)), min_size=1, max_size=3, unique=True))
    return {p: draw(drawn(name, p, *known[p]), label=p) for p in chosen}


def assert_names_a_parameter(error, changes):
    """The message names a changed parameter, and is not an internal error message."""
    message = str(error)
    assert any(re.search(rf"\b{p}\b", message) for p in changes), message
    assert not INTERNAL.search(message.partition(": ")[2]), message


def assert_result_is_valid(result):
    """Every table has distinct columns and rows; an array holds no NaN, but may have a gap."""
    assert result.facts
    for name, table in result.tables.items():
        assert len(set(table.columns)) == len(table.columns), name
        assert len(set(table.rows)) == len(table.rows), name
    for name, array in result.arrays.items():
        assert array.dtype.kind not in "fc" or not np.isnan(array).any(), name


def assert_labels_are_inside(name, page):
    """The centre of every label lies in its panel or near its edge."""
    page.draw_without_rendering()
    for panel in page.axes:
        frame = panel.bbox.padded(MARGIN)
        for label in panel.texts:
            box = label.get_window_extent()
            middle = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
            assert frame.contains(*middle), (name, label.get_text())


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", NAMES)
def test_any_parameters_give_a_finite_result_or_an_error_message(name):
    """Parameters are drawn inside and at the bounds of their domains; every third run is drawn."""
    experiment = experiments.get(name)
    turns = iter(range(10**6))

    @settings(max_examples=2 if name in HEAVY else 5)
    @given(changes=changed(name, experiment.quick))
    def holds(changes):
        try:
            params = replace(experiment.quick, **changes)
        except ValueError as error:
            return assert_names_a_parameter(error, changes)
        try:
            result = experiment.run(params)
        except ExperimentError as error:
            return assert_names_a_parameter(error, changes)
        assert_result_is_valid(result)
        if next(turns) % 3 == 0:
            for figure, plot in experiment.plots.items():
                assert_labels_are_inside(figure, plot(result))
                plt.close("all")
        return None

    holds()


def test_an_order_needs_two_sizes_and_positive_errors():
    """The sizes may have any order; invalid input is refused with its values."""
    assert order([0.1, 0.4, 0.2], [0.01, 0.16, 0.04]) == 2.0
    assert str(order([1, 2], [5.0, 5.0])) == "0.0"
    for sizes in ([8], [8, 8], []):
        with pytest.raises(ValueError, match="order of convergence needs two different sizes"):
            order(sizes, [0.1] * len(sizes))
    for errors in ([0.0, 1.0], [1e-14, 1.0], [-1.0, 1.0], [math.nan, 1.0], [math.inf, 1.0]):
        with pytest.raises(ValueError, match="order of convergence needs errors above 1e-13; got"):
            order([1, 2], errors)


def test_one_function_computes_orders():
    """No experiment fits a slope of its own, unguarded."""
    sources = (ROOT / "src" / "fieldreport").rglob("*.py")
    fitting = [path.name for path in sources if "polyfit" in path.read_text(encoding="utf-8")]
    assert fitting == ["error_measures.py"]


def test_an_error_in_a_run_names_the_experiment_and_its_changed_parameters():
    """With default parameters the original exception is raised."""
    experiment = experiments.get("patch_costs")
    with pytest.raises(ExperimentError, match=r"^experiment patch_costs fails with patch = 17: "):
        experiment.run(replace(experiment.defaults, patch=17))


def test_a_domain_is_described_in_words():
    """All bounds have the same wording."""
    assert Domain(least=0, below=1).wanted == "0 or more and less than 1"
    assert Domain(above=0, most=2).wanted == "more than 0 and 2 or less"
    assert Domain(least=-1, most=1).wanted == "between -1 and 1"
    assert Domain(choices=("a", "b")).wanted == "one of a, b"
    assert str(Domain(least=3, fewest=2, order="increasing")) == "3 or more; 2 values or more"
    assert str(Domain(most=1, entries=2)) == "1 or less; 2 values"
