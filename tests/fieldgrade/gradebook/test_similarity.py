"""Similarity of answers: which edits leave it unchanged, and which shared code is ignored."""

import ast
import random
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.gradebook import similarity
from fieldgrade.gradebook.similarity import (
    WINDOW,
    K,
    code,
    normalized,
    pairs,
    similarity_page,
    to_table,
    winnowed,
)

FIT = '''
def fit(points, values):
    """Return the coefficients."""
    b = np.insert(points, 0, 1.0, axis=1)
    left = b.T @ b
    right = b.T @ values
    for k in range(3):
        left[k, k] += 1e-9 * k
    return np.linalg.solve(left, right)
'''
RENAMED = '''
def fit(xs: np.ndarray, f):
    # my own idea, honestly
    """Something else."""
    matrix: np.ndarray = np.insert(xs, 0,
        1.0, axis=1)   # with ones

    "a text that does nothing"
    gram = (matrix.T @ matrix)
    rhs = matrix.T @ f
    for entry in range(3):
        gram[entry, entry] += 1e-9 * entry
    return np.linalg.solve(gram, rhs)
'''
OTHER = """
def fit(points, values):
    b = np.column_stack([np.ones(len(points)), points])
    q, r = np.linalg.qr(b)
    projected = q.T @ values
    result = np.zeros(len(projected))
    for k in reversed(range(len(projected))):
        result[k] = (projected[k] - r[k, k + 1 :] @ result[k + 1 :]) / r[k, k]
    return result
"""


def nodes_of(text):
    return [what for what, _ in normalized(ast.parse(text).body[0])]


def test_names_comments_docstrings_and_layout_do_not_affect_similarity():
    """Variable names, comments, annotations and white space are not part of the normalized tree."""
    assert nodes_of(FIT) == nodes_of(RENAMED)
    assert code("a", [FIT]).all_prints() == code("b", [RENAMED]).all_prints()


def test_names_of_helper_functions_do_not_affect_similarity():
    one = "def helper(a):\n    return a * 2 + 1\n" + FIT.replace("right)", "helper(right))")
    other = one.replace("helper", "something_else")
    assert code("a", [one]).prints["fit"].keys() == code("b", [other]).prints["fit"].keys()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("b.T @ b", "b @ b.T"),
        ("+= 1e-9", "-= 1e-9"),
        ("linalg.solve", "linalg.lstsq"),
        ("0, 1.0", "1, 1.0"),
    ],
)
def test_operators_numbers_and_library_calls_affect_similarity(old, new):
    assert nodes_of(FIT) != nodes_of(FIT.replace(old, new))


def test_different_algorithms_share_no_fingerprint():
    """Two algorithms for the same numbers are not similar."""
    assert not code("a", [FIT]).all_prints() & code("b", [OTHER]).all_prints()


words = st.lists(st.sampled_from("abcdefg"), min_size=0, max_size=60)


@given(words, words, words, words)
def test_a_long_shared_run_leaves_a_shared_fingerprint(before, after, others, rest):
    """Guarantee of winnowing: a shared run of w + k - 1 nodes leaves a common fingerprint."""
    shared = [f"s{i}" for i in range(WINDOW + K - 1)]
    one = [(w, 1) for w in [*before, *shared, *after]]
    other = [(w, 1) for w in [*others, *shared, *rest]]
    found = {v for v, _ in winnowed(one)} & {v for v, _ in winnowed(other)}
    assert found


@given(words)
def test_winnowing_keeps_a_hash_from_every_window(nodes):
    """Runs shorter than k nodes have no fingerprint."""
    kept = sorted(at for _, at in winnowed([(w, 1) for w in nodes]))
    hashes = max(len(nodes) - K + 1, 0)
    assert bool(kept) == (hashes > 0)
    edges = [-1, *kept, hashes]
    if hashes >= WINDOW:
        assert all(b - a <= WINDOW for a, b in pairwise(edges))


def test_the_density_of_fingerprints_agrees_with_the_theory():
    """On random nodes 2/(w + 1) of the hashes are kept (Schleimer et al., section 3.3)."""
    random_ = random.Random(3)
    nodes = [(str(random_.random()), 1) for _ in range(20_000)]
    assert len(winnowed(nodes)) / len(nodes) == pytest.approx(2 / (WINDOW + 1), rel=0.03)


def test_keeping_every_wth_hash_misses_a_shared_run():
    """A mutant: hashes at fixed positions instead of the smallest change with one inserted line."""

    def at_places(nodes):
        runs = range(0, len(nodes) - K + 1, WINDOW)
        return {similarity._hash(nodes[at : at + K]) for at in runs}

    shared = [(f"s{i}", 1) for i in range(3 * (WINDOW + K))]
    assert not at_places(shared) & at_places([("x", 1), *shared])
    moved = {v for v, _ in winnowed([("x", 1), *shared])}
    assert {v for v, _ in winnowed(shared)} & moved


def test_code_of_the_template_is_ignored():
    """Two students who share only the template are not similar."""
    helper = OTHER.replace("def fit", "def given")
    one, other = code("a", [helper, FIT]), code("b", [helper, "def fit(p, v):\n    return v"])
    assert pairs([one, other])
    assert not pairs([one, other], code("", [helper]))


def test_a_stub_has_no_fingerprints():
    stub = 'def fit(points, values):\n    """Return."""\n    raise NotImplementedError\n'
    assert code("a", [stub]).prints == {}


def test_code_shared_by_half_of_the_class_is_ignored():
    """An answer that half of the class found is not evidence about any pair."""
    many = [code(f"s{i}", [FIT]) for i in range(10)]
    two = [code("x", [OTHER]), code("y", [OTHER.replace("result", "c")])]
    found = pairs([*many, *two])
    assert [(p.one.student, p.other.student, p.part) for p in found] == [("x", "y", 1.0)]


def test_cells_that_cannot_be_parsed_are_skipped():
    """Invalid, hostile and deeply nested code raises no error."""
    deep = "x = " + "(" * 3000 + ")" * 3000
    long = "def fit(x):\n    return " + " + ".join(["x"] * 300)
    assert code("a", ["def (", "\0", deep]).prints == {}
    assert code("a", [long]).prints["fit"]


HOSTILE = {
    "a hexadecimal number of 5000 digits": "return x + 0x" + "f" * 5000,
    "a binary number of 50 000 digits": "return [0b" + "1" * 50_000 + ", x]",
    "a hexadecimal raise behind a statement": "y = 1\n    raise ValueError(0x" + "f" * 5000 + ")",
    "half a character": "return '\ud800' + x",
    "a form feed": "y = x\x0c + 1\n    return y",
    "signs of 5000 levels": "return " + "-" * 5000 + "x",
    "calls of 5000 levels": "y = 1\n    raise x" + "()" * 5000,
    "a zero byte": "return '\0'",
}


@pytest.mark.parametrize("body", HOSTILE.values(), ids=HOSTILE)
def test_no_code_of_a_student_stops_the_comparison(body):
    """The student's other answers are compared."""
    cells = [f"def rank(x):\n    {body}\n", FIT]
    (found,) = pairs([code("a", cells), code("b", [*cells, "x = 1"])])
    assert ("fit", "fit") in [names[:2] for names in found.functions()]
    assert "return np.linalg.solve" in similarity_page("01", [found], 2)


def test_the_compared_code_of_a_student_is_bounded(monkeypatch):
    """What is left out is counted; two students cannot keep the grader busy for hours."""
    monkeypatch.setattr(similarity, "MOST_COMPARED", 3)
    monkeypatch.setattr(similarity, "MOST_NODES", 400)
    many = [FIT.replace("def fit", f"def fit{k}") for k in range(5)]
    assert code("a", many).left_out == 2
    long = "def rank(x):\n    return [" + "x, " * 500 + "]"
    assert code("a", [long, FIT]).left_out == 1
    assert list(code("a", [long, FIT]).prints) == ["fit"]
    assert code("a", ["#" * (similarity.MOST_PARSED + 1), FIT]).left_out == 1


def test_the_similarity_page_marks_shared_lines_and_escapes_code():
    """The page states that similarity is evidence and not a verdict."""
    evil = FIT.replace("np.insert(points, 0", "np.insert('<script>alert(1)</script>', 0")
    (found,) = pairs([code("<b>ada", [evil]), code("bob", [evil])])
    page = similarity_page("01", [found], 2)
    assert "evidence to look at, not a verdict" in page
    assert "<mark>    return np.linalg.solve(left, right)</mark>" in page
    assert "<mark>    b = np.insert(&#x27;&lt;script&gt;" in page
    assert "<mark>    &quot;&quot;&quot;Return" not in page
    assert "&lt;b&gt;ada and bob" in page
    assert "<script" not in page
    assert to_table([("01", found)]).splitlines()[1].startswith("01,<b>ada,bob,1,")
