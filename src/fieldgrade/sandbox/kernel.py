"""System calls of Linux for which Python has no function."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache

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


def library_call(name: str, *arguments: object) -> int:
    """Call a function of the C library that makes a system call, and return its result.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    return _checked(int(getattr(_C, name)(*(_argument(a) for a in arguments))), name)


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


@cache
def processes() -> int | None:
    """Return the open folder ``/proc``, which can be read after it has been hidden."""
    return os.open("/proc", os.O_PATH | os.O_CLOEXEC) if sys.platform == "linux" else None


def read_process(path: str) -> str:
    """Return the content of a file in ``/proc``.

    Raises
    ------
    OSError
        It does not exist, or must not be read.
    """
    with open(path, errors="replace", opener=_in_proc) as file:
        return file.read()


def open_folder(path: str) -> int:
    """Open a folder in ``/proc``.

    Raises
    ------
    OSError
        It does not exist, or must not be read.
    """
    return _in_proc(path, os.O_RDONLY | os.O_DIRECTORY)


def _in_proc(path: str, flags: int) -> int:
    return os.open(path, flags, dir_fd=processes())


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
