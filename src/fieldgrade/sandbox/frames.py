"""Frames: messages between the grader and the sandboxed process, of JSON and raw numbers.

A frame has two lengths, a JSON head, and the bytes of the arrays. The head states the kind and the
shape of each array, which must account for every byte; nothing is unpickled. Frames from the
sandbox that are too long, incomplete or invalid are refused.
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
"""Largest size of the head of a frame, and of all its arrays, in bytes."""
MOST_ARRAYS = 64
MOST_AXES = 16
PIECE = 1 << 16

KINDS = {"b": "|b1", "i": "<i8", "u": "<u8", "f": "<f8", "c": "<c16"}
"""The types in which numbers are sent; shorter ones are widened, longer ones rounded."""


class BadFrame(Exception):
    """The received bytes are not a valid frame."""


class PipeClosed(Exception):
    """The other side has closed the pipe."""


class FrameTimeout(Exception):
    """The other side did not read or write before the deadline."""


def pack(head: dict[str, Any], arrays: tuple[Any, ...] = ()) -> bytes:
    """Return a frame as bytes.

    Raises
    ------
    BadFrame
        It would be longer than the other side accepts, or an array is not numeric.
    """
    described, parts = [], []
    for array in map(np.asarray, arrays):
        kind = array.dtype.kind
        if kind not in KINDS:
            raise BadFrame("an array is not numeric")
        described.append([kind, list(array.shape)])
        parts.append(array.astype(KINDS[kind], order="C", copy=False).tobytes())
    text = json.dumps(head | {"arrays": described}).encode()
    lengths = len(text), sum(map(len, parts))
    if lengths[0] > MOST_HEAD or lengths[1] > MOST_BODY or len(described) > MOST_ARRAYS:
        raise BadFrame("a frame is too long")
    return b"".join([LENGTHS.pack(*lengths), text, *parts])


def send(
    pipe: int, head: dict[str, Any], arrays: tuple[Any, ...] = (), deadline: float | None = None
) -> None:
    """Write a frame to a pipe, at the latest by a time of ``time.monotonic``.

    With a deadline the pipe must be non-blocking; otherwise a reader that never reads would block
    the writer forever.

    Raises
    ------
    PipeClosed, FrameTimeout, BadFrame
        The pipe was closed, it was not read in time, or the frame is invalid.
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
        The pipe was closed, no frame arrived in time, or the frame is invalid.
    """
    lengths = LENGTHS.unpack(_read(pipe, LENGTHS.size, deadline))
    if lengths[0] > MOST_HEAD or lengths[1] > MOST_BODY:
        raise BadFrame("a frame is too long")
    text, body = (_read(pipe, length, deadline) for length in lengths)
    try:
        head = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadFrame(f"the head of a frame cannot be read: {type(error).__name__}") from None
    described = head.pop("arrays", None) if isinstance(head, dict) else None
    if not isinstance(described, list) or len(described) > MOST_ARRAYS:
        raise BadFrame("a frame does not describe its arrays")
    return head, _arrays(described, body)


def _arrays(described: list[Any], body: bytes) -> list[np.ndarray]:
    arrays, start = [], 0
    for entry in described:
        kind, shape = _kind_and_shape(entry)
        if prod(n or 1 for n in shape) > MOST_BODY:  # NumPy multiplies those that are not 0
            raise BadFrame("an array of a frame has an impossible shape")
        stop = start + prod(shape) * np.dtype(KINDS[kind]).itemsize
        if stop > len(body):
            raise BadFrame("an array of a frame is larger than its data")
        part = np.frombuffer(body[start:stop], "|u1" if kind == "b" else KINDS[kind])
        arrays.append((part != 0 if kind == "b" else part).reshape(shape))
        start = stop
    if start != len(body):
        raise BadFrame("a frame has surplus bytes")
    return arrays


def _kind_and_shape(entry: Any) -> tuple[str, tuple[int, ...]]:
    if not isinstance(entry, list) or len(entry) != 2:
        raise BadFrame("an array of a frame has no kind or no shape")
    kind, shape = entry
    if not isinstance(kind, str) or kind not in KINDS:
        raise BadFrame("an array of a frame is not numeric")
    if not isinstance(shape, list) or len(shape) > MOST_AXES:
        raise BadFrame("an array of a frame has no shape")
    if any(type(n) is not int or not 0 <= n <= MOST_BODY for n in shape):
        raise BadFrame("an array of a frame has an impossible shape")
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
    """Wait until a pipe can be read or written; unlike select, poll takes any descriptor."""
    if deadline is None:
        return
    poll = select.poll()
    poll.register(pipe, event)
    left = deadline - time.monotonic()
    if left <= 0 or not poll.poll(ceil(1000 * left)):
        raise FrameTimeout
