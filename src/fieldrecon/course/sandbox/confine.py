"""Locking a process in from inside: limits, Landlock for files, seccomp for everything else.

All of it is asked of the kernel directly, holds for threads and whatever follows, and cannot be
taken back. The order matters: a lock that is set is no longer there to set others.
"""

from __future__ import annotations

import ctypes
import os
import platform
import resource
import struct
import sys
from collections.abc import Iterable

MEBIBYTE = 1 << 20

PR_SET_NO_NEW_PRIVS, PR_SET_SECCOMP, PR_SET_PDEATHSIG, PR_SET_DUMPABLE = 38, 22, 1, 4
SECCOMP_MODE_FILTER = 2
LANDLOCK_CREATE_RULESET, LANDLOCK_ADD_RULE, LANDLOCK_RESTRICT_SELF = 444, 445, 446
RULE_PATH_BENEATH = 1

# Rights of Landlock, bit by bit; later kernels know more of them.
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = 1, 2, 4, 8
RIGHTS_BY_ABI = {1: 13, 2: 14, 3: 15, 4: 15, 5: 16}
"""How many rights on files each version of Landlock knows."""
READ = READ_FILE | READ_DIR


def limit(memory: int, cpu_seconds: int, file_size: int) -> None:
    """Limit memory, processor time, the size of files, open files and core dumps."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds + 1))
    resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
    if sys.platform == "linux":  # macOS does not keep to it
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


def address_space() -> int:
    """Return the bytes of address space in use, from which a limit is counted."""
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
        return int(file.read().split()[0]) * resource.getpagesize()


def landlock_version() -> int:
    """Return which version of Landlock the kernel has; 0 for none."""
    if sys.platform != "linux":
        return 0
    return max(_syscall(LANDLOCK_CREATE_RULESET, None, 0, 1), 0)


def landlock(readable: Iterable[str], writable: Iterable[str]) -> None:
    """Allow reading below some folders, all else below others, and no more of any file.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    version = landlock_version()
    everything = (1 << RIGHTS_BY_ABI[min(version, max(RIGHTS_BY_ABI))]) - 1
    fields = [everything]
    if version >= 4:
        fields.append(3)  # bind and connect by TCP
    if version >= 6:
        fields.append(3)  # abstract sockets, and signals to processes outside
    attributes = struct.pack(f"{len(fields)}Q", *fields)
    ruleset = _checked(LANDLOCK_CREATE_RULESET, attributes, len(attributes), 0)
    for paths, rights in ((readable, READ | EXECUTE), (writable, everything)):
        for path in paths:
            _allow(ruleset, path, rights)
    _no_new_privileges()
    _checked(LANDLOCK_RESTRICT_SELF, ruleset, 0)
    os.close(ruleset)


def _allow(ruleset: int, path: str, rights: int) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except FileNotFoundError:
        return
    if not os.path.isdir(path):  # noqa: PTH112
        rights &= EXECUTE | WRITE_FILE | READ_FILE
    rule = struct.pack("=Qi", rights, place)
    _checked(LANDLOCK_ADD_RULE, ruleset, RULE_PATH_BENEATH, rule, 0)
    os.close(place)


# seccomp: which calls of the kernel are refused. Numbers of x86-64, then of 64-bit ARM.
ARCHITECTURES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
NUMBERS: dict[str, tuple[int | None, int | None]] = {
    # other processes and programs
    "fork": (57, None), "vfork": (58, None), "execve": (59, 221), "execveat": (322, 281),
    "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271),
    "kill": (62, 129), "tkill": (200, 130), "pidfd_send_signal": (424, 424),
    "pidfd_open": (434, 434), "pidfd_getfd": (438, 438), "setpgid": (109, 154),
    "sched_setaffinity": (203, 122), "setpriority": (141, 140),
    # the network, and other ways out
    "socket": (41, 198), "socketpair": (53, 199), "connect": (42, 203), "bind": (49, 200),
    "sendto": (44, 206), "sendmsg": (46, 211), "recvmsg": (47, 212),
    "io_uring_setup": (425, 425), "memfd_create": (319, 279),
    # the kernel's own affairs
    "unshare": (272, 97), "setns": (308, 268), "mount": (165, 40), "umount2": (166, 39),
    "pivot_root": (155, 41), "chroot": (161, 51), "bpf": (321, 280), "keyctl": (250, 219),
    "add_key": (248, 217), "request_key": (249, 218), "userfaultfd": (323, 282),
    "perf_event_open": (298, 241), "init_module": (175, 105), "finit_module": (313, 273),
    "kexec_load": (246, 104), "reboot": (169, 142), "swapon": (167, 224),
    "settimeofday": (164, 170), "clock_settime": (227, 112), "adjtimex": (159, 171),
    "acct": (163, 89), "quotactl": (179, 60), "personality": (135, 92),
    "open_by_handle_at": (304, 265), "mknod": (133, None), "mknodat": (259, 33),
    "shmget": (29, 194), "msgget": (68, 186), "semget": (64, 190),
}  # fmt: skip
CLONE, CLONE3 = (56, 220), (435, 435)
CLONE_THREAD = 0x00010000
EPERM, ENOSYS = 1, 38
ALLOW, ERRNO, KILL = 0x7FFF0000, 0x00050000, 0x80000000
LOAD, EQUAL, ANY_BIT, RETURN = 0x20, 0x15, 0x45, 0x06


def seccomp_is_known() -> bool:
    """Whether the calls of this machine's kernel are known by number here."""
    return sys.platform == "linux" and platform.machine() in ARCHITECTURES


def seccomp() -> None:
    """Refuse other processes, other programs, the network, and the kernel's own affairs.

    Threads are allowed. What is refused fails with an error, as without the permission.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    machine = platform.machine()
    column = list(ARCHITECTURES).index(machine)
    program = [_if(LOAD, 4), _if(EQUAL, ARCHITECTURES[machine], 1, 0), _if(RETURN, KILL)]
    program += [_if(LOAD, 0)]
    if machine == "x86_64":  # the 32-bit numbering of the same kernel
        program += [_if(0x35, 0x40000000, 0, 1), _if(RETURN, KILL)]
    for numbers in NUMBERS.values():
        number = numbers[column]
        if number is not None:
            program += [_if(EQUAL, number, 0, 1), _if(RETURN, ERRNO | EPERM)]
    program += [_if(EQUAL, CLONE3[column], 0, 1), _if(RETURN, ERRNO | ENOSYS)]
    # clone: its flags are the first argument; a thread has that bit, a process has not.
    program += [
        _if(EQUAL, CLONE[column], 0, 3), _if(LOAD, 16), _if(ANY_BIT, CLONE_THREAD, 1, 0),
        _if(RETURN, ERRNO | EPERM), _if(RETURN, ALLOW),
    ]  # fmt: skip
    code = ctypes.create_string_buffer(b"".join(program))
    filters = struct.pack("HxxxxxxP", len(program), ctypes.addressof(code))
    _no_new_privileges()
    _checked_prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, filters)


def _if(code: int, value: int, then: int = 0, otherwise: int = 0) -> bytes:
    """Return an instruction of the filter: how many to skip if it holds, and if not."""
    return struct.pack("HBBI", code, then, otherwise, value)


def drop_capabilities() -> None:
    """Give up what the superuser may do beyond others, for good; limits cannot be raised again.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    version_3_of_this_process = struct.pack("Ii", 0x20080522, 0)
    _checked(126 if platform.machine() == "x86_64" else 91, version_3_of_this_process, bytes(24))


def die_with_parent() -> None:
    """Have the kernel end this process when the one that made it ends."""
    if sys.platform == "linux":
        _checked_prctl(PR_SET_PDEATHSIG, 9, None)


def _no_new_privileges() -> None:
    _checked_prctl(PR_SET_NO_NEW_PRIVS, 1, None)


_C = ctypes.CDLL(None, use_errno=True)


def _syscall(number: int, *arguments: object) -> int:
    return int(_C.syscall(ctypes.c_long(number), *(_long(a) for a in arguments)))


def _long(argument: object) -> object:
    return ctypes.c_long(argument) if isinstance(argument, int) else argument


def _checked(number: int, *arguments: object) -> int:
    result = _syscall(number, *arguments)
    if result < 0:
        error = ctypes.get_errno()
        raise OSError(error, f"system call {number}: {os.strerror(error)}")
    return result


def _checked_prctl(option: int, value: int, pointer: bytes | None) -> None:
    last = [pointer if pointer is not None else ctypes.c_ulong(0)]
    rest = [ctypes.c_ulong(0)] * 2
    if _C.prctl(ctypes.c_int(option), ctypes.c_ulong(value), *last, *rest):
        error = ctypes.get_errno()
        raise OSError(error, f"prctl {option}: {os.strerror(error)}")
