"""Messages between the grader and the process that runs a student's code: words and raw numbers.

A frame is two lengths, a JSON head, and the bytes of the arrays. The head says of each array its
kind and its shape, which must account for every byte; there is no other header to be forged, and
nothing to unpickle. Whatever comes from the student's side is data: too long, torn or odd, it is
refused.
"""

from __future__ import annotations

import json
import os
import select
import struct
import time
from math import ceil, prod
from typing import Any

import numpy as np

LENGTHS = struct.Struct("!II")
MOST_HEAD = 1 << 20
MOST_BODY = 1 << 25
"""Bytes of the head of a frame, and of all its arrays together."""
MOST_ARRAYS = 64
MOST_AXES = 16
PIECE = 1 << 16

KINDS = {"b": "|b1", "i": "<i8", "u": "<u8", "f": "<f8", "c": "<c16"}
"""How numbers of each kind travel; shorter ones are widened, longer ones rounded."""


class BadFrame(Exception):
    """What came is no frame."""


class PipeClosed(Exception):
    """The other side has closed the pipe."""


class FrameTimeout(Exception):
    """The other side did not do its part before the deadline."""


def pack(head: dict[str, Any], arrays: tuple[Any, ...] = ()) -> bytes:
    """Return a frame as bytes.

    Raises
    ------
    BadFrame
        It would be longer than the other side accepts, or has arrays of something else than
        numbers.
    """
    told, parts = [], []
    for array in map(np.asarray, arrays):
        kind = array.dtype.kind
        if kind not in KINDS:
            raise BadFrame("an array is of something else than numbers")
        told.append([kind, list(array.shape)])
        parts.append(array.astype(KINDS[kind], order="C", copy=False).tobytes())
    text = json.dumps(head | {"arrays": told}).encode()
    lengths = len(text), sum(map(len, parts))
    if lengths[0] > MOST_HEAD or lengths[1] > MOST_BODY or len(told) > MOST_ARRAYS:
        raise BadFrame("a frame is longer than it may be")
    return b"".join([LENGTHS.pack(*lengths), text, *parts])


def send(
    pipe: int, head: dict[str, Any], arrays: tuple[Any, ...] = (), deadline: float | None = None
) -> None:
    """Write a frame to a pipe, at the latest by a time of ``time.monotonic``.

    With a deadline the pipe must not block, or a reader that reads nothing could hold up the
    writer for good.

    Raises
    ------
    PipeClosed, FrameTimeout, BadFrame
        The pipe was closed, it was not read in time, or this cannot be a frame.
    """
    data = memoryview(pack(head, arrays))
    while data:
        _wait(pipe, select.POLLOUT, deadline)
        try:
            data = data[os.write(pipe, data[:PIECE]) :]
        except BlockingIOError:
            continue
        except BrokenPipeError:
            raise PipeClosed from None


def receive(pipe: int, deadline: float | None = None) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Read a frame from a pipe, at the latest by a time of ``time.monotonic``.

    Raises
    ------
    PipeClosed, FrameTimeout, BadFrame
        The pipe was closed, nothing came in time, or what came is no frame.
    """
    lengths = LENGTHS.unpack(_read(pipe, LENGTHS.size, deadline))
    if lengths[0] > MOST_HEAD or lengths[1] > MOST_BODY:
        raise BadFrame("a frame is longer than it may be")
    text, body = (_read(pipe, length, deadline) for length in lengths)
    try:
        head = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadFrame(f"the head of a frame cannot be read: {type(error).__name__}") from None
    told = head.pop("arrays", None) if isinstance(head, dict) else None
    if not isinstance(told, list) or len(told) > MOST_ARRAYS:
        raise BadFrame("a frame does not say which arrays it has")
    return head, _arrays(told, body)


def _arrays(told: list[Any], body: bytes) -> list[np.ndarray]:
    arrays, start = [], 0
    for entry in told:
        kind, shape = _kind_and_shape(entry)
        if prod(n or 1 for n in shape) > MOST_BODY:  # NumPy multiplies those that are not 0
            raise BadFrame("an array of a frame has a shape that there is not")
        stop = start + prod(shape) * np.dtype(KINDS[kind]).itemsize
        if stop > len(body):
            raise BadFrame("an array of a frame is larger than what came")
        part = np.frombuffer(body[start:stop], "|u1" if kind == "b" else KINDS[kind])
        arrays.append((part != 0 if kind == "b" else part).reshape(shape))
        start = stop
    if start != len(body):
        raise BadFrame("a frame has more than its arrays")
    return arrays


def _kind_and_shape(entry: Any) -> tuple[str, tuple[int, ...]]:
    if not isinstance(entry, list) or len(entry) != 2:
        raise BadFrame("an array of a frame has no kind or no shape")
    kind, shape = entry
    if not isinstance(kind, str) or kind not in KINDS:
        raise BadFrame("an array of a frame is of something else than numbers")
    if not isinstance(shape, list) or len(shape) > MOST_AXES:
        raise BadFrame("an array of a frame has no shape")
    if any(type(n) is not int or not 0 <= n <= MOST_BODY for n in shape):
        raise BadFrame("an array of a frame has a shape that there is not")
    return kind, tuple(shape)


def _read(pipe: int, length: int, deadline: float | None) -> bytes:
    parts: list[bytes] = []
    while length:
        _wait(pipe, select.POLLIN, deadline)
        part = os.read(pipe, min(length, PIECE))
        if not part:
            raise PipeClosed
        parts.append(part)
        length -= len(part)
    return b"".join(parts)


def _wait(pipe: int, event: int, deadline: float | None) -> None:
    """Wait until a pipe can be read or written; unlike select, poll knows pipes of any number."""
    if deadline is None:
        return
    poll = select.poll()
    poll.register(pipe, event)
    left = deadline - time.monotonic()
    if left <= 0 or not poll.poll(ceil(1000 * left)):
        raise FrameTimeout
