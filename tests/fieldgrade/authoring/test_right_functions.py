"""Right functions answer requests from a submission, within limits, and nothing else."""

import time
from pathlib import Path

import numpy as np
import pytest

from fieldgrade.authoring import right_functions
from fieldgrade.authoring.right_functions import REFUSED, RightFunctions, evaluate
from fieldgrade.sandbox.given_functions import given_function

pytestmark = pytest.mark.slow
"""Each process takes a second to start."""

SOURCE = """
# %% tags=["setup"]
import time

import numpy as np

# %% question="01.1"
def basis_matrix(points):
    return np.insert(points, 0, 1.0, axis=1)


# %% question="01.2"
def both(a, b=2.0):
    return a + b, [a, b]


# %% question="01.3"
def hang(seconds):
    print("hanging")
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            time.sleep(end - time.monotonic())
        except BaseException:
            pass


# %% question="01.4"
def much(n):
    return np.ones(n).sum()


# %% question="01.5"
def large(n):
    return np.broadcast_to(0.0, n)


# %% question="01.6"
def secret(x):
    raise ValueError("secret")
"""
NAMES = ["basis_matrix", "both", "hang", "much", "large", "secret"]


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("solutions") / "01_example.py"
    path.write_text(SOURCE)
    return path


@pytest.fixture
def right(source):
    """The functions of an answer, and the names by which it calls them."""
    return RightFunctions(source, NAMES)


def asked(right, name, *arguments, seconds=60.0, **named):
    """The values of a call as the code of a submission gets them."""
    late = time.monotonic() + seconds
    exchange = lambda head, arrays: right.answer(head, arrays, late)  # noqa: E731
    return given_function(name, exchange)(*arguments, **named)


def test_values_are_those_of_the_function(right):
    """Arrays, numbers, named arguments and tuples; the arrays belong to the caller."""
    points = np.arange(6.0).reshape(3, 2)
    found = asked(right, "basis_matrix", points.tolist())
    np.testing.assert_array_equal(found, np.insert(points, 0, 1.0, axis=1))
    found += 1
    number, several = asked(right, "both", np.int64(1), b=3.0)
    assert (number, [*several]) == (4.0, [1.0, 3.0])
    assert np.ndim(number) == 0
    assert asked(right, "both", a=True)[0] == 3.0
    assert right.called == {"basis_matrix", "both"}
    assert right.seconds > 0


def refused(right, request, arrays=()):
    return right.answer(request, arrays, time.monotonic() + 60) == REFUSED


def test_only_the_named_functions_are_called(source):
    """A function of the same notebook, a module, a built-in function, and no name at all."""
    right = RightFunctions(source, ["both"])
    for name in ("basis_matrix", "np", "print", "__builtins__", "", None, 1, ["both"]):
        assert refused(right, {"asks": name, "arguments": [{"number": 1}], "named": []})
    assert not right.called
    assert not refused(right, {"asks": "both", "arguments": [{"number": 1}], "named": []})


ONE = {"number": 1}


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (None, []),
        ([ONE], None),
        ([1], []),
        ([{"number": "1"}], []),
        ([{"number": [1]}], []),
        ([{"number": 10**20}], []),
        ([{"array": 0}], []),
        ([{"array": -1}], []),
        ([{"array": 0, "number": 1}], []),
        ([{}], []),
        ([ONE] * 17, []),
        ([], ["a"]),
        ([ONE], [1]),
        ([ONE, ONE], ["a", "a"]),
        ([ONE], ["c"]),
        ([ONE, ONE, ONE], []),
    ],
)
def test_invalid_requests_are_refused(right, arguments, named):
    """A frame from a submission may contain anything that JSON can express."""
    assert refused(right, {"asks": "both", "arguments": arguments, "named": named})
    assert asked(right, "both", 1.0)[0] == 3.0


def test_arrays_are_sent_once_and_are_small(right):
    """The limit is on all arrays of a call together; it is far above what the course needs."""
    just = right_functions.MOST_BYTES // 16
    request = {"asks": "both", "arguments": [{"array": 0}, {"array": 1}], "named": []}
    assert not refused(right, request, [np.ones(just), np.ones(just)])
    assert refused(right, request, [np.ones(just), np.ones(just + 1)])
    assert refused(right, request, [np.ones(1)] * 3)
    twice = {"asks": "both", "arguments": [{"array": 0}, {"array": 0}], "named": []}
    assert refused(right, twice, [np.ones(1)])


def test_an_error_is_not_told(right):
    with pytest.raises(ValueError, match=r"^this earlier function has no value for these") as error:
        asked(right, "secret", 1.0)
    assert "secret" not in str(error.value)


def test_much_memory_and_large_values_are_refused(right):
    """The process survives both."""
    assert refused(right, {"asks": "much", "arguments": [{"number": 2**28}], "named": []})
    assert refused(right, {"asks": "large", "arguments": [{"number": 2**23}], "named": []})
    assert asked(right, "much", 1000) == 1000


def test_the_number_of_calls_is_limited(right, monkeypatch):
    """For one answer; the next answer has its own limit."""
    monkeypatch.setattr(right_functions, "MOST_CALLS", 3)
    request = {"asks": "both", "arguments": [ONE], "named": []}
    assert [refused(right, request) for _ in range(5)] == [False] * 3 + [True] * 2
    assert not refused(RightFunctions(right.source, NAMES), request)


def test_the_time_of_all_calls_is_limited(right, monkeypatch):
    """Also by the deadline of the call in which the answer asks."""
    request = {"asks": "both", "arguments": [ONE], "named": []}
    assert right.answer(request, (), time.monotonic() - 1) == REFUSED
    assert not refused(right, request)
    monkeypatch.setattr(right_functions, "SECONDS_IN_ALL", right.seconds)
    assert refused(right, request)


def test_a_function_that_hangs_is_ended(right, monkeypatch):
    """Even one that cannot be interrupted; the answer then gets no further values."""
    monkeypatch.setattr(right_functions, "SECONDS_OF_A_CALL", 0.1)
    monkeypatch.setattr(right_functions, "GRACE", 0.2)
    before = right_functions._process._process
    start = time.monotonic()
    assert refused(right, {"asks": "hang", "arguments": [{"number": 600}], "named": []})
    assert time.monotonic() - start < 60
    assert not before.is_alive()
    assert refused(right, {"asks": "both", "arguments": [ONE], "named": []})
    assert asked(RightFunctions(right.source, NAMES), "both", 1.0)[0] == 3.0


def test_a_process_that_was_killed_is_a_failure_of_the_machine(right):
    """No grade may depend on it: the submission runs again."""
    right_functions._process._process.kill()
    with pytest.raises(RuntimeError, match="has ended"):
        asked(right, "both", 1.0)
    assert asked(RightFunctions(right.source, NAMES), "both", 1.0)[0] == 3.0


def test_the_call_is_evaluated_as_described():
    """Positional arguments first, then those with names."""
    request = {"asks": "f", "arguments": [{"array": 0}, ONE], "named": ["y"], "seconds": 1.0}
    reply, (value,) = evaluate({"f": lambda x, y: x - y}, request, [np.ones(2)])
    assert reply == {"given": True}
    assert not value.any()
