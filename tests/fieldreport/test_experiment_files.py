"""Results, parameters and files: values are reproduced from files, and errors are reported."""

import json
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrecon._core import atomic_files as _whole_file
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon.io.tables import csv_bytes
from fieldreport.framework import result_files as files
from fieldreport.framework.experiment import (
    Experiment,
    Result,
    ResultTable,
    cell_from_text,
)
from fieldreport.framework.orders_of_magnitude import OrderOfMagnitude, order_of_magnitude
from fieldreport.framework.parameters import replace_parameters

FINITE = st.floats(allow_nan=False, allow_infinity=False)
CELLS = st.one_of(st.integers(), FINITE, st.text(alphabet="abc,;\" '\n%é", max_size=8))


@dataclass(frozen=True)
class Params:
    count: int = 3
    width: float = 0.5
    label: str = "a"
    fast: bool = True
    powers: tuple[int, ...] = (1, 2)


def result(**changes):
    parts = {"params": Params(), "tables": {}, "facts": {}, "arrays": {}} | changes
    return Result(**parts)


@pytest.mark.slow
@given(rows=st.lists(st.tuples(CELLS, CELLS), max_size=5))
def test_a_table_is_reproduced_from_its_file(tmp_path_factory, rows):
    """Numbers keep their types, and texts keep commas, quotes and line breaks."""
    table = ResultTable(("first, with a comma", "second"), tuple(rows))
    path = tmp_path_factory.mktemp("table") / "table.csv"
    path.write_bytes(csv_bytes(table.columns, table.rows))
    back = files._read_table(path)
    assert back == table
    assert [list(map(type, row)) for row in back.rows] == [
        list(map(type, row)) for row in table.rows
    ]


@given(x=FINITE)
def test_a_fact_is_rounded_to_nine_digits(x):
    """Rounding a rounded fact again does not change it."""
    fact = result(facts={"x": x}).facts["x"]
    assert fact == pytest.approx(x, rel=1e-8, abs=0)
    assert result(facts={"x": fact}).facts["x"] == fact


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: result(facts={"rms": np.nan}), "fact 'rms' must be finite; got nan"),
        (lambda: result(facts={"won": True}), "fact 'won' must be a number or a text"),
        (lambda: result(facts={"all": [1]}), "fact 'all' must be a number or a text; got list"),
        (lambda: result(arrays={"a": [{}]}), "array 'a' must hold numbers or texts; got objects"),
        (
            lambda: ResultTable(("n",), (("12",),)),
            "column 'n' holds the text '12'; give the number",
        ),
        (
            lambda: ResultTable(("n", "e"), ((1,),)),
            r"a row must have 2 cells, \('n', 'e'\); got \(1,\)",
        ),
        (lambda: ResultTable(("n",), ((1,),)).column("m"), "no column 'm'; the table has n"),
    ],
)
def test_invalid_facts_arrays_and_cells_are_refused(make, words):
    """Facts and cells are finite numbers or texts; arrays contain no objects."""
    with pytest.raises(ValueError, match=words):
        make()


def test_results_are_equal_only_if_all_bits_are_equal():
    base = result(facts={"a": 1}, arrays={"x": np.arange(3.0)})
    assert base == result(facts={"a": 1}, arrays={"x": np.arange(3.0)})
    assert base != result(facts={"a": 1}, arrays={"x": np.nextafter(np.arange(3.0), 9)})
    assert base != result(facts={"a": 1}, arrays={"x": np.arange(3)})
    assert base != result(facts={"a": 2}, arrays={"x": np.arange(3.0)})


def test_a_result_is_immutable():
    """Neither its mappings nor its arrays can be changed."""
    base = result(facts={"a": 1}, arrays={"x": np.arange(3.0)})
    with pytest.raises(TypeError, match="does not support item assignment"):
        base.facts["a"] = 2
    with pytest.raises(ValueError, match="read-only"):
        base.arrays["x"][0] = 7


@given(exponent=st.integers(-300, 300), factor=st.floats(0.32, 3.16), sign=st.sampled_from([-1, 1]))
def test_an_order_of_magnitude_is_the_nearest_power_of_ten(exponent, factor, sign):
    """Any number within a factor of √10 of a power of ten has that order."""
    assert order_of_magnitude(sign * factor * float(f"1e{exponent}")) == float(f"1e{exponent}")


def test_cells_are_read_with_their_types():
    """An integer, a decimal number, an order of magnitude, and a text."""
    texts = ("12", "12.0", "1e-3", "~1e-03", "12 m")
    assert [cell_from_text(t) for t in texts] == [12, 12.0, 0.001, 0.001, "12 m"]
    assert [type(cell_from_text(t)) for t in texts] == [int, float, float, OrderOfMagnitude, str]


def test_an_order_of_magnitude_stays_one(tmp_path):
    """In facts and tables, written and read again; a format with digits is refused."""
    order = order_of_magnitude(0.02)
    table = ResultTable(("x", "y"), ((order, 0.01),))
    files.write_result(
        result(facts={"order": order, "number": 0.01}, tables={"t": table}), tmp_path
    )
    found = files.read_result(tmp_path, Experiment("made_up", SimpleNamespace(Params=Params)))
    cells = [*found.facts.values(), *found.tables["t"].rows[0]]
    assert [type(x) for x in cells] == [OrderOfMagnitude, float] * 2
    assert set(cells) == {0.01}
    assert f"{order:.0e}" == "1e-02"
    with pytest.raises(ValueError, match=r"has no digits: format \.0e, not \.1e"):
        f"{order:.1e}"


@pytest.mark.parametrize(
    ("settings", "wanted"),
    [
        ({"count": "7"}, Params(count=7)),
        ({"width": "1e-3"}, Params(width=0.001)),
        ({"width": 2}, Params(width=2.0)),
        ({"fast": "false", "label": "x=y"}, Params(fast=False, label="x=y")),
        ({"powers": "4"}, Params(powers=(4,))),
        ({"powers": "1, 2,8"}, Params(powers=(1, 2, 8))),
        ({"powers": [3, 4]}, Params(powers=(3, 4))),
    ],
)
def test_settings_are_converted_to_the_types_of_their_fields(settings, wanted):
    """Command-line texts and values of a settings file give the same parameters."""
    params = replace_parameters(Params(), settings)
    assert params == wanted
    assert all(type(getattr(params, n)) is type(getattr(Params(), n)) for n in settings)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"cuont": "7"}, r"there is no parameter 'cuont'; did you mean count\?"),
        ({"count": "7.5"}, "parameter count must be a whole number; got '7.5'"),
        ({"count": True}, "parameter count must be a whole number; got True"),
        ({"width": "wide"}, "parameter width must be a finite number; got 'wide'"),
        ({"width": "nan"}, "parameter width must be a finite number; got 'nan'"),
        ({"fast": "yes"}, "parameter fast must be true or false; got 'yes'"),
        ({"label": 3}, "parameter label must be a text; got 3"),
        ({"powers": "1,,2"}, "parameter powers must be a list such as 1,2,4; got '1,,2'"),
        ({"powers": 3}, "parameter powers must be a list such as 1,2,4; got 3"),
        ({"powers": "1,b"}, "parameter powers must be a whole number; got 'b'"),
    ],
)
def test_an_invalid_setting_is_refused(settings, words):
    """The message names the parameter, the value and the requirement."""
    with pytest.raises(ValueError, match=words):
        replace_parameters(Params(), settings)


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    """No other file is left."""
    path = write_atomically(tmp_path / "deep" / "file.txt", b"old")

    def broken(_):
        raise OSError("no space left on device")

    monkeypatch.setattr(_whole_file.os, "fsync", broken)
    with pytest.raises(OSError, match="no space left"):
        write_atomically(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(path.parent.iterdir()) == [path]


def test_a_removed_table_is_deleted_from_the_folder(tmp_path):
    """The tables are those of the last run; a table of somebody else stays and is not read."""
    table = ResultTable(("n",), ((1,),))
    (tmp_path / "mine.csv").write_text("mine")
    files.write_result(result(tables={"old": table, "kept": table}), tmp_path)
    written = files.write_result(result(tables={"kept": table}), tmp_path)
    assert {path.name for path in tmp_path.glob("*.csv")} == {"kept.csv", "mine.csv"}
    assert files.result_files(tmp_path) == sorted(written)
    assert (tmp_path / "mine.csv").read_text() == "mine"


@pytest.mark.parametrize("text", ["", "[", "7"])
def test_a_damaged_list_of_tables_is_written_anew(tmp_path, text):
    table = ResultTable(("n",), ((1,),))
    (tmp_path / files.TABLES).write_text(text)
    files.write_result(result(tables={"kept": table}), tmp_path)
    assert [path.name for path in files.table_files(tmp_path)] == ["kept.csv"]


def test_facts_are_written_as_one_json_object(tmp_path):
    files.write_result(result(facts={"ratio": 1 / 3, "n": 4, "winner": "RBF"}), tmp_path)
    facts = json.loads((tmp_path / "facts.json").read_text())
    assert facts == {"ratio": 0.333333333, "n": 4, "winner": "RBF"}
