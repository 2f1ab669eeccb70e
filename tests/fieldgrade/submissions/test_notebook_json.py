"""Outputs are left out of a notebook by a scan of its bytes, and limits hold before parsing."""

import json
import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.submissions import notebook_json
from fieldgrade.submissions.notebook_json import without_outputs
from submission_files import ANSWER, code, notebook, prose

NAMES = ("outputs", "attachments", "widgets", "source", 'out"puts', '\\"outputs"')
texts = st.text(max_size=8) | st.sampled_from(['"', "\\", '\\"outputs\\": [', "]}"])
jsons = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | texts,
    lambda inner: st.lists(inner) | st.dictionaries(st.sampled_from(NAMES) | texts, inner),
)


def emptied(data):
    """The same data by a second route: parsed, then changed."""
    if isinstance(data, list):
        return [emptied(value) for value in data]
    if isinstance(data, dict):
        return {name: _value(name, value) for name, value in data.items()}
    return data


def _value(name, value):
    is_left_out = name in NAMES[:3] and isinstance(value, list | dict)
    return type(value)() if is_left_out else emptied(value)


@pytest.mark.slow
@given(jsons, st.sampled_from([None, 0, 2]), st.booleans())
def test_outputs_are_left_out_and_all_else_remains(data, indent, ascii_only):
    text = json.dumps(data, indent=indent, ensure_ascii=ascii_only)
    assert json.loads(without_outputs(text.encode())) == emptied(data)


def test_a_cut_notebook_remains_broken():
    """Wherever it was cut, also in an output."""
    cells = (ANSWER, code("x", outputs=[{"text": ["]", '"']}]), prose("y", attachments={}))
    whole = notebook(*cells, widgets={"a": [1]})
    for length in range(1, len(whole)):
        with pytest.raises(ValueError, match="line 1"):
            json.loads(without_outputs(whole[:length]))


LARGE = {
    "objects": (b'{"cells":[' + b"{}," * (5 << 20) + b"{}]}", "more than 9000 elements"),
    "numbers": (b'{"cells":[' + b"7," * (5 << 20) + b"7]}", "more than 9000 elements"),
    "depth": (b"[" * (10 << 20), "50 levels"),
    "a string": (b'{"x":"' + b"x" * (20 << 20) + b'"}', "20 MiB, outputs not counted"),
    "outputs": (b'{"outputs":[' + b"[]," * 3000 + b"[]]}", "its outputs have more than 5000"),
}


@pytest.mark.parametrize(("content", "sentence"), LARGE.values(), ids=LARGE)
def test_a_limit_is_applied_before_parsing(monkeypatch, content, sentence):
    """The scan takes no memory worth mentioning."""
    monkeypatch.setattr(notebook_json, "MOST_LEFT_OUT", 5000)
    monkeypatch.setattr(notebook_json, "MOST_ELEMENTS", 9000)
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=sentence):
            without_outputs(content)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()
