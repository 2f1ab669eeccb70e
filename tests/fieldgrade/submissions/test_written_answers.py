"""Written answers are found where students write them, and no other text is taken for one."""

import pytest
from hypothesis import given
from test_submission import noise

from fieldgrade.authoring.notebooks import YOUR_WORDS
from fieldgrade.submissions.submission import Submission
from fieldgrade.submissions.written_answers import LONGEST, written_answers
from submission_files import notebook, packed, prose

ASKED = prose("**01.7** (2 points) Why is the matrix singular?")
NEXT = prose("**01.8** (1 point) And then?")
MINE = "Since the points lie on a line."


def answers(*cells, name="01.ipynb"):
    content = cells[0] if isinstance(cells[0], bytes) else notebook(*cells)
    return written_answers(Submission("ada", name, content), ["01.7", "01.8"])


def marked(text, question="01.7", **more):
    return prose(text) | {"metadata": {"answer": question}} | more


PERCENT = f"""# %% [markdown]
# **01.7** Why?

# %% [markdown] answer="01.7"
# {MINE}

# %%
x = 1
"""
NBCONVERT = f"# **01.7** Why?\n\n# {MINE}\n\n# In[1]:\n\nx = 1\n\n# **01.8** And?\n"
PLACES = {
    "by its metadata": [ASKED, marked(MINE), NEXT],
    "wherever it was moved": [NEXT, "x = 1", marked(MINE), ASKED],
    "by its identifier": [ASKED, "x = 1", prose(MINE, id="q-01-7")],
    "by a copy of it": [ASKED, prose(YOUR_WORDS, id="q-01-7"), prose(MINE, id="q-01-7-2")],
    "behind the question": [ASKED, prose(MINE), NEXT],
    "behind the place for it": [ASKED, marked(YOUR_WORDS), prose(MINE), NEXT],
    "in lists of lines": [ASKED, marked([MINE[:5], MINE[5:], None])],
    "below the place for it": [ASKED, marked(f"{YOUR_WORDS}\n\n{MINE}")],
    "in a script": [PERCENT.encode()],
    "in a script of nbconvert": [NBCONVERT.encode()],
}


@pytest.mark.parametrize("cells", PLACES.values(), ids=PLACES)
def test_a_written_answer_is_found(cells):
    """The most reliable indication that is present decides."""
    name = "01.py" if isinstance(cells[0], bytes) else "01.ipynb"
    assert answers(*cells, name=name) == {"01.7": MINE}


NONE = {
    "the place is untouched": [ASKED, marked(YOUR_WORDS), NEXT],
    "the place is empty": [ASKED, marked(" \n"), NEXT],
    "the next question follows": [ASKED, NEXT],
    "the next section follows": [ASKED, prose("## Two dimensions")],
    "code follows": [ASKED, "x = 1", prose("Text of the notebook.")],
    "no notebook": [b"\x89PNG"],
    "nothing": [b""],
    "a zip file": [packed({"x": b""})],
}


@pytest.mark.parametrize("cells", NONE.values(), ids=NONE)
def test_text_that_is_not_an_answer_is_ignored(cells):
    """An unanswered question is not in the result."""
    assert answers(*cells) == {}


def test_two_different_cells_for_one_question_are_both_read():
    """Identical copies are read once."""
    assert answers(marked("One."), marked("Two."), marked("One.")) == {"01.7": "One.\n\nTwo."}


def test_a_written_answer_belongs_to_one_question():
    """Text after one question is not an answer to another."""
    assert answers(ASKED, prose("A"), NEXT, prose("B")) == {"01.7": "A", "01.8": "B"}
    assert answers(ASKED, marked("B", "01.8")) == {"01.8": "B"}


def test_a_long_answer_is_truncated():
    assert len(answers(marked("x" * 10**6))["01.7"]) == LONGEST


@pytest.mark.slow
@given(noise)
def test_any_bytes_are_read_without_errors(content):
    """Every file has written answers or none."""
    for name in ("01.ipynb", "01.py"):
        assert all(written_answers(Submission("ada", name, content), ["01.7"]).values())
