"""seccomp: a filter that refuses system calls with an error.

It refuses other processes and programs, the network, administration of the kernel, and calls that
reach processes or files beyond the control of Landlock. Threads are allowed. System calls that are
newer than this list are refused too.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from collections.abc import Iterator, Sequence

from fieldgrade.sandbox.kernel import no_new_privileges, process_control

# Numbers on x86-64, then on 64-bit ARM; None for a call that does not exist.
ARCHITECTURES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
Numbers = tuple[int | None, int | None]
REFUSED: dict[str, Numbers] = {
    # other processes and programs
    "fork": (57, None),
    "vfork": (58, None),
    "execve": (59, 221),
    "execveat": (322, 281),
    "ptrace": (101, 117),
    "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271),
    "process_madvise": (440, 440),
    "process_mrelease": (448, 448),
    "kcmp": (312, 272),
    "kill": (62, 129),
    "tkill": (200, 130),
    "rt_sigqueueinfo": (129, 138),
    "rt_tgsigqueueinfo": (297, 240),
    "pidfd_send_signal": (424, 424),
    "pidfd_open": (434, 434),
    "pidfd_getfd": (438, 438),
    "setpgid": (109, 154),
    "setsid": (112, 157),
    "move_pages": (279, 239),
    "migrate_pages": (256, 238),
    "sched_setaffinity": (203, 122),
    "sched_setscheduler": (144, 119),
    "sched_setparam": (142, 118),
    "sched_setattr": (314, 274),
    "setpriority": (141, 140),
    "ioprio_set": (251, 30),
    # the network, and other channels
    "socket": (41, 198),
    "socketpair": (53, 199),
    "connect": (42, 203),
    "bind": (49, 200),
    "sendto": (44, 206),
    "sendmsg": (46, 211),
    "sendmmsg": (307, 269),
    "recvmsg": (47, 212),
    "io_uring_setup": (425, 425),
    "memfd_create": (319, 279),
    "memfd_secret": (447, 447),
    "shmget": (29, 194),
    "shmat": (30, 196),
    "shmctl": (31, 195),
    "msgget": (68, 186),
    "msgsnd": (69, 189),
    "msgrcv": (70, 188),
    "msgctl": (71, 187),
    "semget": (64, 190),
    "semop": (65, 193),
    "semtimedop": (220, 192),
    "semctl": (66, 191),
    "mq_open": (240, 180),
    "mq_unlink": (241, 181),
    "inotify_init": (253, None),
    "inotify_init1": (294, 26),
    "fanotify_init": (300, 262),
    # files anywhere, which Landlock does not control
    "chmod": (90, None),
    "fchmod": (91, 52),
    "fchmodat": (268, 53),
    "chown": (92, None),
    "fchown": (93, 55),
    "lchown": (94, None),
    "fchownat": (260, 54),
    "utime": (132, None),
    "utimes": (235, None),
    "futimesat": (261, None),
    "utimensat": (280, 88),
    "setxattr": (188, 5),
    "lsetxattr": (189, 6),
    "fsetxattr": (190, 7),
    "removexattr": (197, 14),
    "lremovexattr": (198, 15),
    "fremovexattr": (199, 16),
    "truncate": (76, 45),
    "mknod": (133, None),
    "mknodat": (259, 33),
    "open_by_handle_at": (304, 265),
    # administration of the kernel
    "unshare": (272, 97),
    "setns": (308, 268),
    "mount": (165, 40),
    "umount2": (166, 39),
    "open_tree": (428, 428),
    "move_mount": (429, 429),
    "fsopen": (430, 430),
    "fsconfig": (431, 431),
    "fsmount": (432, 432),
    "fspick": (433, 433),
    "mount_setattr": (442, 442),
    "pivot_root": (155, 41),
    "chroot": (161, 51),
    "bpf": (321, 280),
    "keyctl": (250, 219),
    "add_key": (248, 217),
    "request_key": (249, 218),
    "userfaultfd": (323, 282),
    "perf_event_open": (298, 241),
    "init_module": (175, 105),
    "finit_module": (313, 273),
    "delete_module": (176, 106),
    "kexec_load": (246, 104),
    "reboot": (169, 142),
    "swapon": (167, 224),
    "swapoff": (168, 225),
    "syslog": (103, 116),
    "settimeofday": (164, 170),
    "clock_settime": (227, 112),
    "adjtimex": (159, 171),
    "clock_adjtime": (305, 266),
    "acct": (163, 89),
    "quotactl": (179, 60),
    "personality": (135, 92),
}

# Calls reported as not existing: callers then use an older call, whose arguments can be checked.
ABSENT: dict[str, Numbers] = {"clone3": (435, 435), "openat2": (437, 437)}
FIRST_UNKNOWN = 450

# Calls that depend on an argument.
OPEN: Numbers = (2, None)
OPENAT = (257, 56)
CLONE, TGKILL, PRLIMIT = (56, 220), (234, 131), (302, 261)
FCNTL, IOCTL, PRCTL = (72, 25), (16, 29), (157, 167)
CLONE_THREAD = 0x00010000
SIGNALS_OF_FILES = (8, 10, 15)
"""``F_SETOWN``, ``F_SETSIG``, ``F_SETOWN_EX``: signals that are sent when a file is ready."""
SIGNALS_OF_DEVICES = (0x8901, 0x8902, 0x5412, 0x541C)
"""``FIOSETOWN``, ``SIOCSPGRP``, ``TIOCSTI``, ``TIOCLINUX``."""

END_WITH_PARENT = 1
"""``PR_SET_PDEATHSIG``, with which the process could survive its parent."""

EPERM, ENOSYS = 1, 38
ALLOW, ERRNO, KILL = 0x7FFF0000, 0x00050000, 0x80000000
LOAD, MASK, EQUAL, AT_LEAST, ANY_BIT, RETURN = 0x20, 0x54, 0x15, 0x35, 0x45, 0x06
SECCOMP, FILTER = 22, 2


def is_known() -> bool:
    """Whether the numbers of the system calls of this machine are known."""
    return sys.platform == "linux" and platform.machine() in ARCHITECTURES


def refuse() -> None:
    """Install the filter, irrevocably.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    program = list(_program(platform.machine(), os.getpid()))
    code = ctypes.create_string_buffer(b"".join(program))
    no_new_privileges()
    process_control(SECCOMP, FILTER, struct.pack("HxxxxxxP", len(program), ctypes.addressof(code)))


def _program(machine: str, process: int) -> Iterator[bytes]:
    """Yield the instructions of the filter; other calls are allowed."""
    column = list(ARCHITECTURES).index(machine)
    yield from (_if(LOAD, 4), _if(EQUAL, ARCHITECTURES[machine], 1, 0), _if(RETURN, KILL))
    yield _if(LOAD, 0)
    if machine == "x86_64":  # system calls of 32-bit programs on the same kernel
        yield from (_if(AT_LEAST, 0x40000000, 0, 1), _if(RETURN, KILL))
    yield from (_if(AT_LEAST, FIRST_UNKNOWN, 0, 1), _if(RETURN, ERRNO | ENOSYS))
    for numbers, error in ((REFUSED, EPERM), (ABSENT, ENOSYS)):
        for known in (each[column] for each in numbers.values()):
            if known is not None:
                yield from (_if(EQUAL, known, 0, 1), _if(RETURN, ERRNO | error))
    only = _unless(EQUAL, process)
    own = _unless(EQUAL, 0)
    cut_short = [_if(MASK, os.O_ACCMODE | os.O_TRUNC), *_when(EQUAL, os.O_TRUNC)]
    signals = [line for value in SIGNALS_OF_FILES for line in _when(EQUAL, value)]
    devices = [line for value in SIGNALS_OF_DEVICES for line in _when(EQUAL, value)]
    for number, argument, test in (
        (OPEN, 1, cut_short),
        (OPENAT, 2, cut_short),
        (CLONE, 0, _unless(ANY_BIT, CLONE_THREAD)),
        (TGKILL, 0, only),
        (PRLIMIT, 0, own),
        (FCNTL, 1, signals),
        (IOCTL, 1, devices),
        (PRCTL, 0, _when(EQUAL, END_WITH_PARENT)),
    ):
        if number[column] is not None:
            yield from _argument(number[column], argument, test)
    yield _if(RETURN, ALLOW)


def _argument(number: int | None, argument: int, test: Sequence[bytes]) -> Iterator[bytes]:
    """Yield a test of the lower half of an argument, skipped for other calls."""
    assert number is not None
    yield _if(EQUAL, number, 0, len(test) + 2)
    yield _if(LOAD, 16 + 8 * argument)
    yield from test
    yield _if(RETURN, ALLOW)


def _when(code: int, value: int) -> list[bytes]:
    return [_if(code, value, 0, 1), _if(RETURN, ERRNO | EPERM)]


def _unless(code: int, value: int) -> list[bytes]:
    return [_if(code, value, 1, 0), _if(RETURN, ERRNO | EPERM)]


def _if(code: int, value: int, then: int = 0, otherwise: int = 0) -> bytes:
    """Return a jump: the numbers of instructions to skip if the condition holds, and if not."""
    return struct.pack("HBBI", code, then, otherwise, value)
