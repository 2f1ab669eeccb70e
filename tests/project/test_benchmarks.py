"""The benchmarks run at a very small size and report their results; their speed is not tested."""

import importlib
import json
import math
import pickle
import sys

import numpy as np
import pytest

from checkout import ROOT

if str(ROOT) not in sys.path:
    sys.path.append(str(ROOT))

from benchmarks import __main__ as command
from benchmarks import charts, graders, grading, memory, mesh_scaling, pages, peers
from benchmarks.assignments import SMALL, BenchmarkAssignment
from benchmarks.compared_methods import METHODS, OURS
from benchmarks.finished_runs import FinishedRuns
from benchmarks.mesh_velocities import Flow
from benchmarks.moving_least_squares import Problem
from benchmarks.timing import BenchmarkResult, Chart, Comparison, cores, in_turn, threads

from fieldrecon.datasets.synthetic import franke, uniform


def no_bar(items, what):  # noqa: ARG001
    return items


@pytest.mark.slow
@pytest.mark.parametrize("name", command.NAMES)
def test_each_benchmark_runs_and_writes_a_page(name):
    """The smallest size gives finite positive ratios, tables with complete rows, and valid JSON."""
    result = command.measured(name, "TOY", no_bar)
    assert json.loads(json.dumps(result))["title"] == result["title"]
    assert result["comparisons"] or result["tables"]
    for comparison in result["comparisons"]:
        assert 0 < comparison["least"] <= comparison["ratio"] <= comparison["most"] < math.inf
    for table in result["tables"]:
        assert all(len(row) == len(table["columns"]) for row in table["rows"])
    assert result["title"] in pages.section(result)


@pytest.mark.parametrize("name", command.NAMES)
def test_each_benchmark_has_three_different_sizes(name):
    """With --quick the same code measures a smaller problem."""
    benchmark = importlib.import_module(f"benchmarks.{name}")
    assert type(benchmark.FULL) is type(benchmark.QUICK) is type(benchmark.TOY)
    assert len({benchmark.FULL, benchmark.QUICK, benchmark.TOY}) == 3


def test_an_unknown_benchmark_is_refused(capsys):
    """The message lists the existing benchmarks."""
    with pytest.raises(SystemExit):
        command.main(["speed"])
    assert "no benchmark is called speed; there are moving_least" in capsys.readouterr().err


def test_candidates_run_alternately():
    """The order is A B A B, and the first round of each candidate is not counted."""
    calls = []
    candidates = {name: lambda name=name: calls.append(name) for name in "ab"}
    seconds = in_turn(candidates, 3, no_bar, "turns")
    assert "".join(calls) == "abababab"
    assert [len(times) for times in seconds.values()] == [3, 3]


def test_ratios_are_formed_within_each_round():
    """The median and range are those of the ratios, not ratios of medians."""
    summary = Comparison("this", "that", [1.0, 8.0, 9.0], [2.0, 2.0, 3.0], at_most=1.0).summary()
    assert (summary["least"], summary["ratio"], summary["most"]) == (0.5, 3.0, 4.0)


@pytest.mark.parametrize(("ours", "verdict"), [(1.9, "2.00 (met)"), (2.1, "2.00 (NOT met)")])
def test_a_missed_limit_is_reported(ours, verdict):
    """The page states whether the median is within its limit."""
    comparison = Comparison("this", "that", [ours], [1.0], at_most=2.0).summary()
    result = {
        "title": "A title",
        "parameters": {},
        "comparisons": [comparison],
        "tables": [],
        "notes": [],
        "machine": {},
    }
    assert verdict in pages.section(result)


@pytest.mark.parametrize("degree", [1, 2])
def test_fits_with_given_neighbourhoods_are_the_same(degree):
    """They give the values of the whole evaluation, bit for bit."""
    points, x = uniform(3000, 2, seed=1), uniform(5000, 2, seed=2)
    problem = Problem(points, franke(points), x, 20)
    np.testing.assert_array_equal(problem.solve(degree)(), problem.total(degree)())


@pytest.mark.slow
def test_peak_memory_excludes_the_parent_process():
    """A large array of the parent process is not counted."""
    large = np.ones(2**26)
    fitted = pickle.dumps(memory.field_of("RBF", 60))
    assert memory.BALLAST < memory.peak_of(fitted, "values", 500, "hold") < large.nbytes


def test_the_number_of_threads_is_restored():
    """After a call on one core the process has all its cores again."""
    before = cores()
    with threads(1):
        assert cores() <= before
    assert cores() == before


def test_each_method_runs_on_suitable_data_only():
    """Smoothing is for noise, planar methods are for the plane, dense methods for few sites."""
    asked = {
        (data, n): {c.name for c in METHODS.values() if c.takes(data, n)}
        for data, n in [("noisy", 1000), ("smooth", 1000), ("cube", 1000), ("smooth", 10**6)]
    }
    assert "ferreus_rbf, r³, smoothed" in asked["noisy", 1000] - asked["smooth", 1000]
    assert "wlsqm, degree 2" in asked["smooth", 1000] - asked["cube", 1000]
    assert "SciPy RBF" in asked["smooth", 1000] - asked["smooth", 10**6]
    assert all(OURS in names for names in asked.values())


def test_an_interrupted_comparison_goes_on_after_its_finished_runs(tmp_path):
    """Unless the code has changed; the file is deleted at the end."""
    path, code = tmp_path / "build" / "runs.jsonl", tmp_path / "code.py"
    code.write_text("x = 1\n")
    first = FinishedRuns(path, tmp_path)
    first.add("a r³ 1000", {"fit": [0.1, 0.25], "memory": 3})
    first.add("b", "b: stopped after 400 s")
    again = FinishedRuns(path, tmp_path)
    assert again.get("a r³ 1000") == {"fit": [0.1, 0.25], "memory": 3}
    assert again.get("b") == "b: stopped after 400 s"
    assert again.get("c") is None
    code.write_text("x = 2\n")
    assert FinishedRuns(path, tmp_path).get("b") is None
    again.forget()
    assert not path.exists()


@pytest.mark.slow
def test_a_failed_run_reports_its_error():
    """The message of the exception is shown instead of numbers."""
    reported = peers.in_own_process("smooth", 2, "fieldrecon MLS, degree 2", 1)
    assert reported.startswith("fieldrecon MLS, degree 2 on smooth, 2 sites: ValueError: neighbors")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fieldrecon RBF, 1000 means", "fieldrecon patches, 4000 means"])
def test_smoothing_chosen_by_leave_one_out_reduces_the_noise(method):
    """The noise has a standard deviation of 0.01."""
    assert peers.in_this_process("noisy", 600, method, 1).rms < 0.006


@pytest.mark.slow
def test_the_page_of_results_is_up_to_date(tmp_path):
    """benchmarks/results/README.md is made from the JSON files."""
    for path in (ROOT / "benchmarks" / "results").glob("*.json"):
        pages.write(path.stem, json.loads(path.read_text()), tmp_path)
    committed = ROOT / "benchmarks" / "results" / "README.md"
    assert (tmp_path / "README.md").read_text() == committed.read_text()


def test_benchmark_tables_in_the_documentation_are_up_to_date():
    """Tables below a mark come from the JSON files, and a different table is replaced."""
    for page in (ROOT / "docs").glob("*.md"):
        text = page.read_text()
        assert pages.with_tables(text, command.RESULTS) == text
        assert "-->\n\n" not in text, f"{page.name} has a mark without a table"
    whole = "before\n<!-- table 1 of streaming -->\n| typed |\n| 7 |\n\nafter\n"
    corrected = pages.with_tables(whole, command.RESULTS)
    assert "typed" not in corrected
    assert corrected.startswith("before\n<!-- table 1 of streaming -->\n| way | deal out, s")
    assert corrected.endswith(" |\n\nafter\n")


def test_the_charts_are_up_to_date():
    """Each committed chart contains a mark computed from the numbers in its JSON file."""
    folder = ROOT / "benchmarks" / "results"
    results = {path: json.loads(path.read_text()) for path in folder.glob("*.json")}
    charted = {path.with_suffix(".svg"): r for path, r in results.items() if r.get("charts")}
    assert {*folder.glob("*.svg")} == {*charted}
    for path, result in charted.items():
        assert charts.mark(result) in path.read_text()


@pytest.mark.slow
def test_a_chart_is_marked_with_its_numbers(tmp_path):
    """The page links the chart, whose mark changes with the numbers."""
    chart = Chart("Time", "size", "seconds", [1, 2], {"ours": [1.0, 2.0], "theirs": [3.0, 4.0]})
    result = {"title": "Growth", "machine": {}, **BenchmarkResult(charts=[chart]).as_dict()}
    pages.write("growth", result, tmp_path)
    assert "![Time](growth.svg)" in (tmp_path / "README.md").read_text()
    drawing = (tmp_path / "growth.svg").read_text()
    assert charts.mark(result) in drawing
    result["charts"][0]["x"] = [1, 3]
    assert charts.mark(result) not in drawing


def test_the_timed_computations_on_meshes_are_correct():
    """A rotation is reproduced; Voronoi weights are nonnegative, sum to 1 and reproduce points."""
    flow = Flow(uniform(400, 2, seed=1), 300)
    assert len(flow.vertex) == len(flow.x) == 300
    for what, error in flow.checks().rows:
        assert error < 1e-10, what


def test_the_exponent_is_fitted_to_the_larger_meshes():
    """Times 2 n^1.5 give 1.5, whatever the times of the smaller half are."""
    sizes = (10, 20, 40, 80, 160)
    costs = [mesh_scaling.Cost(2 * n**1.5 if n > 20 else 1e3, 0.1) for n in sizes]
    assert mesh_scaling.exponent(sizes, costs) == pytest.approx(1.5)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(10))
def test_generated_submissions_are_right_in_the_stated_questions(number):
    """The test of a question passes if and only if the question is listed as right."""
    assignment = BenchmarkAssignment(SMALL)
    content = assignment.submission(number)
    right = assignment.right(number, inherit=True)
    names, passed = {}, set()
    for cell in json.loads(content)["cells"]:
        reported = cell["metadata"].get("nbgrader", {})
        try:
            exec(cell["source"], names)
        except Exception:
            continue
        if reported.get("grade"):
            passed.add(reported["grade_id"].removeprefix("test-").replace("-", "."))
    assert passed == right
    assert (len(right) == 3) == (number < 4)


def test_the_versions_of_compared_graders_are_pinned():
    assert graders.version("nbgrader") == "0.9.6"
    assert graders.version("otter") == "7.0.0"


def test_the_speed_of_grading_is_stated_once_and_is_what_the_benchmark_requires():
    """`make bench ONLY=grading` shows it."""
    pages_ = [ROOT / "README.md", *ROOT.glob("docs/*.md")]
    lines = [line for page in pages_ for line in page.read_text("utf-8").splitlines()]
    (stated,) = [line for line in lines if "otter" in line and "times" in line and "fast" in line]
    assert stated.startswith("| `grading` |")
    for factor in (f"{1 / ratio:.0f} times" for ratio in grading.AT_MOST.values()):
        assert factor in stated
    assert f"at most {grading.MOST_CPU:g} s" in stated


def test_no_comparison_is_stated_twice():
    """One ratio for what is measured against one other method, in all results together."""
    stated = [
        (comparison["what"], comparison["peer"])
        for path in (ROOT / "benchmarks/results").glob("*.json")
        for comparison in json.loads(path.read_text("utf-8"))["comparisons"]
    ]
    assert len(stated) == len(set(stated)) > 100
