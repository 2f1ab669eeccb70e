"""System calls of Linux for which Python has no function."""

from __future__ import annotations

import ctypes
import os

_C = ctypes.CDLL(None, use_errno=True)


def system_call(number: int, *arguments: object) -> int:
    """Make a system call, and return its result.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    result = int(_C.syscall(ctypes.c_long(number), *(_argument(a) for a in arguments)))
    return _checked(result, f"system call {number}")


def process_control(option: int, value: int, pointer: bytes | None = None) -> None:
    """Set a property of this process with ``prctl``.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    third = pointer if pointer is not None else ctypes.c_ulong(0)
    rest = [ctypes.c_ulong(0)] * 2
    _checked(_C.prctl(ctypes.c_int(option), ctypes.c_ulong(value), third, *rest), f"prctl {option}")


def no_new_privileges() -> None:
    """Set ``no_new_privs``, which Landlock and seccomp require."""
    process_control(38, 1)


def _argument(argument: object) -> object:
    return ctypes.c_long(argument) if isinstance(argument, int) else argument


def _checked(result: int, call: str) -> int:
    if result < 0:
        error = ctypes.get_errno()
        raise OSError(error, f"{call}: {os.strerror(error)}")
    return result
