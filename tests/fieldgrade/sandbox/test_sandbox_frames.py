"""Frames: what is sent arrives, and whatever else comes is refused in time."""

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
    """What is received when these bytes come, and then no more."""
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


@quickly
@given(SENT, st.lists(VALUES, max_size=3))
def test_what_is_sent_arrives(head, values):
    """Words come as they were, numbers too, widened to eight bytes, in their shapes."""
    told, came = received(frames.pack(head, tuple(values)))
    assert told == head
    assert len(came) == len(values)
    for one, other in zip(came, values, strict=True):
        assert one.shape == other.shape
        assert one.dtype.kind == other.dtype.kind
        np.testing.assert_array_equal(one, other)


@quickly
@given(st.binary(max_size=200))
def test_bytes_are_a_frame_or_refused(data):
    """Any bytes at all are refused in one of three ways, or are a frame."""
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


@quickly
@given(ENTRY, st.binary(max_size=64))
def test_a_head_that_lies_about_its_arrays_is_refused(told, body):
    """Whatever a head says of its arrays, the numbers are those of the body, byte for byte."""
    text = json.dumps({"arrays": told}).encode()
    try:
        _, values = received(struct.pack("!II", len(text), len(body)) + text + body)
    except frames.BadFrame:
        return
    assert sum(value.nbytes for value in values) == len(body)


@quickly
@given(st.sampled_from(["f", "b"]), st.lists(st.sampled_from([0, 1, 2**25, 2**24]), max_size=16))
def test_no_shape_is_too_odd(kind, shape):
    """A shape whose sizes multiply to more than there is, or to nothing, breaks nobody."""
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
def test_what_is_no_frame_is_refused_in_words(data, words):
    """The sentence says what is wrong."""
    with pytest.raises(frames.BadFrame, match=words):
        received(data)


def test_a_torn_frame_is_waited_for_until_the_deadline():
    """Who sends half a frame and keeps the pipe open holds up nobody for longer."""
    begin = time.monotonic()
    with pipe() as (out, into):
        os.write(into, struct.pack("!II", 100, 0) + b"{")
        with pytest.raises(frames.FrameTimeout):
            frames.receive(out, begin + 0.2)
    assert time.monotonic() - begin > 0.15


def test_a_pipe_that_nobody_reads_is_written_to_until_the_deadline():
    """A frame larger than the pipe, and a reader that does not read: the writer goes on."""
    begin = time.monotonic()
    with pipe() as (_, into):
        os.set_blocking(into, False)
        with pytest.raises(frames.FrameTimeout):
            frames.send(into, {}, (np.zeros(10**5),), begin + 0.2)
    assert time.monotonic() - begin > 0.15


def test_a_pipe_that_is_closed_is_told():
    """To read or to write where nobody is at the other end is an end of its own kind."""
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
def test_what_the_other_side_would_refuse_is_not_sent(values, words):
    """Objects, texts and more than may be are refused by the sender too."""
    with pytest.raises(frames.BadFrame, match=words):
        frames.pack({}, values)


def test_nothing_is_unpickled():
    """A pickle is bytes like others, which no frame gives a meaning to."""

    class Evil:
        def __reduce__(self):
            return pytest.fail, ("it was unpickled",)

    import pickle

    data = pickle.dumps(Evil())
    for frame in (data, struct.pack("!II", len(data), 0) + data):
        with pytest.raises((frames.BadFrame, frames.PipeClosed)):
            received(frame)
