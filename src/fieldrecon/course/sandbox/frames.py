"""Messages between the grader and the process that runs a student's code: words and raw arrays.

A frame is a length, a JSON head, and the arrays in NumPy's own format, which is read without
pickles. Whatever comes from the student's side is data: too long, torn or forged, it is refused.
"""

from __future__ import annotations

import io
import json
import os
import select
import struct
import time
from typing import Any

import numpy as np

HEAD = struct.Struct("!II")
MOST_HEAD = 1 << 20
MOST_ARRAYS = 1 << 25
"""Bytes of the head of a frame, and of all its arrays together."""
MOST_PARTS = 64


class BadFrame(Exception):
    """What came is no frame."""


class Gone(Exception):
    """The other side has closed the pipe."""


class Late(Exception):
    """Nothing came before the deadline."""


def pack(head: dict[str, Any], arrays: tuple[Any, ...] = ()) -> bytes:
    """Return a frame as bytes.

    Raises
    ------
    BadFrame
        It would be longer than the other side accepts.
    """
    body = io.BytesIO()
    for array in arrays:
        np.lib.format.write_array(body, np.asarray(array), allow_pickle=False)
        if body.tell() > MOST_ARRAYS:
            raise BadFrame("the arrays are larger than a frame may be")
    text = json.dumps(head | {"arrays": len(arrays)}).encode()
    if len(text) > MOST_HEAD:
        raise BadFrame("the head is longer than a frame's may be")
    return HEAD.pack(len(text), body.tell()) + text + body.getvalue()


def send(pipe: int, head: dict[str, Any], arrays: tuple[Any, ...] = ()) -> None:
    """Write a frame to a pipe."""
    data = memoryview(pack(head, arrays))
    while data:
        data = data[os.write(pipe, data) :]


def receive(pipe: int, deadline: float | None = None) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Read a frame from a pipe, at the latest by a time of ``time.monotonic``.

    Raises
    ------
    Gone, Late, BadFrame
        The pipe was closed, nothing came in time, or what came is no frame.
    """
    lengths = HEAD.unpack(_read(pipe, HEAD.size, deadline))
    if lengths[0] > MOST_HEAD or lengths[1] > MOST_ARRAYS:
        raise BadFrame("a frame is longer than it may be")
    text, body = (_read(pipe, length, deadline) for length in lengths)
    try:
        head = json.loads(text)
        if not isinstance(head, dict):
            raise BadFrame("the head of a frame is no object")
        count = head.get("arrays")
        if type(count) is not int or not 0 <= count <= MOST_PARTS:
            raise BadFrame("a frame does not say how many arrays it has")
        stream = io.BytesIO(body)
        arrays = [np.lib.format.read_array(stream, allow_pickle=False) for _ in range(count)]
    except (ValueError, RecursionError, TypeError, KeyError, EOFError, MemoryError) as error:
        raise BadFrame(f"a frame cannot be read: {type(error).__name__}") from error
    if any(array.dtype.kind not in "biufc" for array in arrays):
        raise BadFrame("a frame has arrays of something else than numbers")
    return head, arrays


def _read(pipe: int, length: int, deadline: float | None) -> bytes:
    parts: list[bytes] = []
    while length:
        if deadline is not None:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([pipe], [], [], left)[0]:
                raise Late
        part = os.read(pipe, min(length, 1 << 20))
        if not part:
            raise Gone
        parts.append(part)
        length -= len(part)
    return b"".join(parts)
