"""Submissions: code is found in every form in which students submit it, without running it."""

import json
import pickle
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.submissions import definitions, submission
from fieldgrade.submissions.definitions import defined, plain
from fieldgrade.submissions.submission import Submission, Unreadable
from submission_files import ANSWER, FUNCTIONS, STUB, code, notebook, of_format_3, prose

PERCENT = f"# %%\nimport numpy\n\n# %% [markdown]\n# Text\n\n# %%\n{ANSWER}"
NBCONVERT = f"#!/usr/bin/env python\n\n# In[1]:\n\nimport numpy\n\n# In[ ]:\n{ANSWER}"
WAYS = {
    "a notebook": ("01.ipynb", notebook(ANSWER)),
    "renamed by a browser": ("ps1 (1).ipynb", notebook(ANSWER)),
    "renamed by a person": ("final FINAL", notebook(ANSWER)),
    "of format 3": ("01.ipynb", of_format_3(ANSWER)),
    "of another kernel": (
        "01.ipynb",
        notebook(ANSWER, kernelspec={"name": "conda-env-mine-py", "language": "R"}),
    ),
    "without metadata": ("01.ipynb", b'{"cells": [' + json.dumps(code(ANSWER)).encode() + b"]}"),
    "with lists of lines": ("01.ipynb", notebook(code(ANSWER.splitlines(keepends=True)))),
    "with a byte order mark": ("01.ipynb", b"\xef\xbb\xbf" + notebook(ANSWER)),
    "in UTF-16": ("01.ipynb", notebook(ANSWER).decode().encode("utf-16")),
    "with ends of lines of Windows": ("01.ipynb", notebook(ANSWER.replace("\n", "\r\n"))),
    "with ids twice": ("01.ipynb", notebook(code(STUB, id="q-01-2"), code(ANSWER, id="q-01-2"))),
    "with a damaged cell": ("01.ipynb", notebook("def broken(", 7, None, code(3), [], ANSWER)),
    "with magics": ("01.ipynb", notebook(f"%matplotlib inline\n!pip install x\nfit?\n{ANSWER}")),
    "timed": ("01.ipynb", notebook(f"%%time\n{ANSWER}")),
    "a script with marks": ("01.py", PERCENT.encode()),
    "a script of nbconvert": ("01.py", NBCONVERT.encode()),
    "a script without marks": ("01.py", f"import numpy\n1 / 0\n{ANSWER}".encode()),
    "a script of old Windows": ("01.py", f"# Größe\n{ANSWER}".encode("cp1252")),
    "a script with a mark": ("01.py", b"\xef\xbb\xbf" + PERCENT.replace("\n", "\r\n").encode()),
    "a notebook called a script": ("01.py", notebook(ANSWER)),
    "in a branch": ("01.ipynb", notebook("try:\n    import numpy\nfinally:\n    fit = max")),
}


@pytest.mark.parametrize(("name", "content"), WAYS.values(), ids=WAYS)
def test_an_answer_is_found_by_its_function_name(name, content):
    """The name and the format of the file do not matter."""
    found = Submission("ada", name, content)
    assert found.definitions["fit"][-1] is False
    assert found.notebook(FUNCTIONS) == "01"


def nested(levels):
    """Arrays in arrays."""
    inner = []
    for _ in range(levels - 1):
        inner = [inner]
    return inner


BAD = {
    "empty": (b"", "the file is empty"),
    "blank": (b" \n\n", "the file is empty"),
    "cut": (notebook(ANSWER)[:60], "its JSON is broken"),
    "deep": (b"[" * 100_000, "not a notebook: it is nested more than 50 levels deep"),
    "deep in the metadata": (notebook(ANSWER, x=nested(900)), "more than 50 levels deep"),
    "a little too deep": (notebook(code(ANSWER, x=nested(60))), "more than 50 levels deep"),
    "deep in a source": (notebook(code(nested(900))), "more than 50 levels deep"),
    "objects": (b'{"cells":[' + b"{}," * 500_000 + b"{}]}", "more than 300000 elements"),
    "numbers": (b'{"cells":[' + b"0," * 500_000 + b"0]}", "more than 300000 elements"),
    "strings": (b'{"cells":[' + b'"",' * 500_000 + b"0]}", "more than 300000 elements"),
    "a long string": (notebook(code("", x="x" * (20 << 20))), "more than 20 MiB, outputs not"),
    "huge number": (b"9" * 10_000, "its JSON is broken"),
    "a list": (b"[]", "it has no cells"),
    "cells that are none": (b'{"cells": 3}', "it has no cells"),
    "no text": (b"\x89PNG\r\n\x1a\n\x00\xff", "the file is not text"),
    "half of UTF-16": (b"\xff\xfe\x00", "the file is not text"),
    "no answer": (notebook("x = 1"), "it defines none of the functions that are asked for"),
    "too long": (b" " * 30 + b"x" * (20 << 20), "more than 20 MiB"),
    "too much code": (notebook("x = 1\n" * 200_000), "more than 1 MiB of code"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("content", "sentence"), BAD.values(), ids=BAD)
def test_an_unreadable_file_is_refused_with_its_reason(content, sentence):
    with pytest.raises(Unreadable, match=sentence):
        Submission("ada", "01.ipynb", content).notebook(FUNCTIONS)


LARGE = {
    "outputs": {"outputs": [{"output_type": "stream", "text": ["0.5\n"] * 400_000}]},
    "one picture": {"outputs": [{"data": {"image/png": "A" * (30 << 20)}}]},
    "deep outputs": {"outputs": nested(900)},
    "attachments": {"attachments": {"a.png": {"image/png": "A" * (21 << 20)}}},
    "widgets": {"metadata": {"widgets": {"state": [{}] * 400_000}}},
}


@pytest.mark.slow
@pytest.mark.parametrize("more", LARGE.values(), ids=LARGE)
def test_large_outputs_do_not_make_a_notebook_unreadable(more):
    """They are not graded, and are left out before the size is judged."""
    found = Submission("ada", "01.ipynb", notebook(code(ANSWER, **more)))
    assert found.notebook(FUNCTIONS) == "01"
    assert found.cells == (ANSWER,)


def test_only_the_code_of_a_submission_is_kept_and_sent():
    """Neither the file nor its parsed JSON travels to another process."""
    content = notebook(ANSWER, code("", outputs=[{"image/png": "A" * 1_000_000}]), x=nested(40))
    parsed = Submission("ada", "01.ipynb", content).parsed()
    assert parsed.digest == Submission("ada", "01.ipynb", content).digest
    assert parsed.content == b""
    sent = pickle.dumps(parsed)
    assert len(sent) < 1000
    assert pickle.loads(sent).cells == (ANSWER,)


jsons = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: (
        st.lists(inner)
        | st.dictionaries(
            st.sampled_from(
                ["cells", "worksheets", "source", "input", "cell_type", "metadata", "id", "course"]
            )
            | st.text(),
            inner,
        )
    ),
)
sources = st.text() | st.lists(st.text() | st.none()) | jsons
kinds = st.just("code") | jsons
cells = st.fixed_dictionaries({"cell_type": kinds, "source": sources, "id": jsons})
noise = (
    st.binary()
    | jsons.map(lambda data: json.dumps(data).encode())
    | st.lists(cells).map(lambda made: json.dumps({"cells": made, "metadata": {}}).encode())
)


@pytest.mark.slow
@given(noise, st.sampled_from(["01.ipynb", "01.py", "", "x/\ud800.ipynb"]))
def test_arbitrary_bytes_are_a_submission_or_unreadable(content, name):
    found = Submission("ada", name, content)
    with suppress(Unreadable):
        assert found.notebook(FUNCTIONS) in FUNCTIONS
        assert all(isinstance(cell, str) for cell in found.cells)


NESTED = {
    "minus": "-" * 200_000 + "1",
    "brackets": "(" * 200_000,
    "sums": "1" + "+1" * 20_000,
    "calls": "f" + "()" * 20_000,
    "lambdas": "lambda:" * 30_000 + "1",
    "branches": "if 1: pass\n" + "elif 1: pass\n" * 15_000,
    "blocks": "\n".join(" " * i + "if 1:" for i in range(90)) + "\n" + " " * 90 + "pass",
    "nul": "x = '\0'",
    "half a character": "x = '\ud800'",
    "digits": "9" * 100_000,
    "statements": "a;" * 30_000,
}


@pytest.mark.slow
@pytest.mark.parametrize("cell", NESTED.values(), ids=NESTED)
def test_a_cell_that_cannot_be_parsed_defines_nothing(cell):
    """The other cells still define their functions."""
    assert defined(cell) == ()
    found = Submission("ada", "01.ipynb", notebook(cell, ANSWER))
    assert list(found.definitions) == ["fit"]


def test_a_cell_that_is_too_long_is_not_parsed():
    """A syntax tree takes about a thousand times the memory of its code."""
    long = "x = 1\n" * (definitions.MOST_PARSED // 6 + 1)
    assert defined(long + ANSWER) == ()
    assert defined(long[:6000] + ANSWER)[-1] == ("fit", False)


def test_invalid_escape_sequences_are_accepted():
    """Python only warns about them, and warnings are errors in these tests."""
    assert defined('def fit(x):\n    return "\\d"\n') == (("fit", False),)


def test_only_invalid_python_is_treated_as_a_magic_command():
    """A line that begins with % and continues an expression is kept."""
    cell = "x = (7\n  % 2)\n"
    assert plain(cell) == cell
    assert plain("%%bash\nls") == ""
    assert plain("%%capture\nfit = 1").strip() == "fit = 1"
    assert plain("found = !ls\n  %timeit f()\nx = 1") == "found = None\n  pass\nx = 1"


def test_definitions_inside_functions_and_classes_are_not_answers():
    """Only names at the top level can be called."""
    assert defined("class A:\n    def fit(self): ...\ndef outer():\n    def rank(p): ...") == (
        ("outer", False),
    )
    assert defined("for k in 1, 2:\n    def fit(): return k\nfrom x import rank as gradient") == (
        ("k", False),
        ("fit", False),
        ("gradient", False),
    )


@pytest.mark.parametrize(
    ("body", "stub"),
    [
        ("...", True),
        ("pass", True),
        ('"""What it does."""', True),
        ('"""What it does."""\n    raise NotImplementedError("01.2")', True),
        ("n = len(points)\n    raise NotImplementedError", True),
        ("raise ValueError", True),
        ("if not len(points):\n        raise NotImplementedError\n    return points", False),
        ("return None", False),
    ],
)
def test_a_stub_is_distinguished_from_an_answer(body, stub):
    """A stub may contain some given lines."""
    assert defined(f"def fit(points):\n    {body}\n") == (("fit", stub),)


def test_a_stub_after_an_answer_is_recorded():
    """Definitions keep their order, so that a replaced answer can be reported."""
    found = Submission("ada", "01.ipynb", notebook(ANSWER, STUB))
    assert found.definitions["fit"] == (False, True)


def test_an_ambiguous_notebook_is_identified_by_its_metadata():
    """Metadata has precedence over cell ids, and both have precedence over the file name."""
    shared = "def gradient(c, x):\n    return c\n"
    course = {"course": {"source": "02_moving_least_squares"}}
    by_id = code(shared, id="q-02-7")
    assert number("x.ipynb", notebook(code(shared, id="q-01-5"), **course)) == "02"
    assert number("01.ipynb", notebook(by_id)) == "02"
    assert number("hw02 (3).ipynb", notebook(shared)) == "02"
    assert number("2024-2031.ipynb", notebook(shared)) == "01"


def test_functions_have_precedence_over_metadata_ids_and_names():
    lies = {"course": {"source": "02_moving_least_squares"}}
    assert number("02.ipynb", notebook(code(ANSWER, id="q-02-7"), **lies)) == "01"


def test_a_notebook_without_functions_is_identified_by_metadata_or_ids():
    """It is graded as empty; a file name alone is not enough."""
    course = {"course": {"source": "02_moving_least_squares"}}
    assert number("x.ipynb", notebook("weights = (", **course)) == "02"
    assert number("x.ipynb", notebook(prose("text", id="q-02-3"))) == "02"
    assert number("x.ipynb", notebook("def weights(:")) == "02"
    assert number("x.ipynb", notebook("exec('x = 1\\ndef weights(): pass')")) == "02"
    for none in ("weights(", "class Model:\n    def weights(self): pass\n)"):
        with pytest.raises(Unreadable, match="none of the functions"):
            number("02.ipynb", notebook(none))


def number(name, content):
    return Submission("ada", name, content).notebook(FUNCTIONS)


def test_a_pickled_submission_keeps_its_definitions():
    """Another process need not parse the cells again."""
    found = Submission("ada", "01.ipynb", notebook(ANSWER))
    assert found.definitions == {"fit": (False,)}
    assert "definitions" in vars(pickle.loads(pickle.dumps(found)))


def test_the_limit_of_code_is_far_above_real_notebooks():
    """The notebooks of this course have a tenth of it."""
    assert submission.MOST_CODE >= 10 * 50_000
