"""Frames between grader and worker: valid frames arrive, and others are refused in time."""

import json
import os
import struct
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fieldgrade.sandbox import frames

quickly = settings(max_examples=150)
NUMBERS = st.sampled_from(["b1", "i1", "i8", "u2", "u8", "f4", "f8", "c8", "c16"])
VALUES = NUMBERS.flatmap(
    lambda kind: arrays(kind, st.lists(st.integers(0, 3), max_size=4).map(tuple))
)
PLAIN = st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.text(max_size=20)
SENT = st.dictionaries(st.text(max_size=9).filter(lambda key: key != "arrays"), PLAIN, max_size=4)


@contextmanager
def pipe():
    ends = os.pipe()
    try:
        yield ends
    finally:
        for end in ends:
            try:
                os.close(end)
            except OSError:
                continue


def received(data, seconds=600.0):
    """Return the frame received from these bytes, after which the pipe is closed."""
    with pipe() as (out, into):

        def write():
            try:
                os.write(into, data)
            except BrokenPipeError:
                return
            finally:
                os.close(into)

        writer = threading.Thread(target=write)
        writer.start()
        try:
            return frames.receive(out, time.monotonic() + seconds)
        finally:
            os.close(out)
            writer.join()


@pytest.mark.slow
@quickly
@given(SENT, st.lists(VALUES, max_size=3))
def test_a_frame_arrives_as_it_was_sent(head, values):
    """Texts are unchanged; arrays keep shape and values, widened to eight bytes per number."""
    head_received, came = received(frames.pack(head, tuple(values)))
    assert head_received == head
    assert len(came) == len(values)
    for one, other in zip(came, values, strict=True):
        assert one.shape == other.shape
        assert one.dtype.kind == other.dtype.kind
        np.testing.assert_array_equal(one, other)


@quickly
@given(st.binary(max_size=200))
def test_arbitrary_bytes_are_a_frame_or_refused(data):
    try:
        head, values = received(data)
    except (frames.BadFrame, frames.PipeClosed):
        return
    assert isinstance(head, dict)
    assert all(value.dtype.str in frames.KINDS.values() for value in values)


ENTRY = st.recursive(
    st.none() | st.integers(-3, 2**70) | st.sampled_from([*"biufcOmV", "", "ff"]) | st.floats(),
    lambda inner: st.lists(inner, max_size=20),
    max_leaves=30,
)


@pytest.mark.slow
@quickly
@given(ENTRY, st.binary(max_size=64))
def test_a_head_that_misdescribes_its_arrays_is_refused(head_received, body):
    """Whatever the head claims about its arrays, exactly the numbers of the body are returned."""
    text = json.dumps({"arrays": head_received}).encode()
    try:
        _, values = received(struct.pack("!II", len(text), len(body)) + text + body)
    except frames.BadFrame:
        return
    assert sum(value.nbytes for value in values) == len(body)


@pytest.mark.slow
@quickly
@given(st.sampled_from(["f", "b"]), st.lists(st.sampled_from([0, 1, 2**25, 2**24]), max_size=16))
def test_any_shape_is_read_or_refused(kind, shape):
    """This includes shapes of size zero, and sizes whose product overflows."""
    text = json.dumps({"arrays": [[kind, shape]]}).encode()
    try:
        _, (value,) = received(struct.pack("!II", len(text), 0) + text)
    except frames.BadFrame:
        return
    assert value.shape == tuple(shape)
    assert value.size == 0


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (struct.pack("!II", frames.MOST_HEAD + 1, 0), "too long"),
        (struct.pack("!II", 2, frames.MOST_BODY + 1), "too long"),
        (struct.pack("!II", 1, 0) + b"{", "cannot be read: JSONDecodeError"),
        (struct.pack("!II", 99999, 0) + b"[" * 99999, "cannot be read: RecursionError"),
        (struct.pack("!II", 2, 0) + b"{}", "does not describe its arrays"),
        (struct.pack("!II", 2, 0) + b"[]", "does not describe its arrays"),
        (struct.pack("!II", 13, 1) + b'{"arrays":[]}' + b"x", "surplus bytes"),
        (struct.pack("!II", 22, 0) + b'{"arrays":[["f",[1]]]}', "larger than its data"),
        (struct.pack("!II", 22, 8) + b'{"arrays":[["O",[1]]]}' + bytes(8), "not numeric"),
    ],
)
def test_an_invalid_frame_is_refused_with_its_reason(data, words):
    with pytest.raises(frames.BadFrame, match=words):
        received(data)


def test_receiving_an_incomplete_frame_times_out():
    """The sender sends half a frame and keeps the pipe open."""
    begin = time.monotonic()
    with pipe() as (out, into):
        os.write(into, struct.pack("!II", 100, 0) + b"{")
        with pytest.raises(frames.FrameTimeout):
            frames.receive(out, begin + 0.2)
    assert time.monotonic() - begin > 0.15


def test_sending_to_a_pipe_that_nobody_reads_times_out():
    """The frame is larger than the buffer of the pipe."""
    begin = time.monotonic()
    with pipe() as (_, into):
        os.set_blocking(into, False)
        with pytest.raises(frames.FrameTimeout):
            frames.send(into, {}, (np.zeros(10**5),), begin + 0.2)
    assert time.monotonic() - begin > 0.15


def test_a_closed_pipe_raises_an_error_of_its_own():
    """This applies to reading and to writing."""
    with pipe() as (out, into):
        os.close(into)
        with pytest.raises(frames.PipeClosed):
            frames.receive(out, time.monotonic() + 600)
    with pipe() as (out, into):
        os.close(out)
        with pytest.raises(frames.PipeClosed):
            frames.send(into, {}, ())


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((np.array(["x"]),), "not numeric"),
        ((np.array([{}], dtype=object),), "not numeric"),
        ((np.broadcast_to(0.0, frames.MOST_BODY // 8 + 1),), "too long"),
        ((np.zeros(1),) * (frames.MOST_ARRAYS + 1), "too long"),
    ],
)
def test_frames_that_the_receiver_would_refuse_are_not_sent(values, words):
    """Objects, texts, and frames that are too long."""
    with pytest.raises(frames.BadFrame, match=words):
        frames.pack({}, values)


def test_pickles_are_not_loaded():
    """A pickle is refused like any other invalid frame."""

    class Evil:
        def __reduce__(self):
            return pytest.fail, ("it was unpickled",)

    import pickle

    data = pickle.dumps(Evil())
    for frame in (data, struct.pack("!II", len(data), 0) + data):
        with pytest.raises((frames.BadFrame, frames.PipeClosed)):
            received(frame)
