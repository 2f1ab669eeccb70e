"""seccomp: a filter that refuses system calls with an error.

It refuses other processes and programs, the network, administration of the kernel, and calls that
reach processes or files beyond the control of Landlock. Threads are allowed. System calls that are
newer than this list are refused too.

Two submissions that run at once must not exchange messages. Files that both can open are therefore
not lockable: a lock is reported as granted and is not set, which is true in a home that nobody else
can open. For the same reason a futex is private to its process, and processor clocks, priorities
and processors of other processes cannot be asked for.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from collections.abc import Iterator

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
    "timer_create": (222, 107),
    "mincore": (27, 232),
    "preadv2": (327, 286),
    "sysinfo": (99, 179),
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
    # rules that keep deleted files on the disk
    "landlock_create_ruleset": (444, 444),
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
ABSENT: dict[str, Numbers] = {
    "clone3": (435, 435),
    "openat2": (437, 437),
    "futex_waitv": (449, 449),
}
FIRST_UNKNOWN = 450

# Calls reported as successful without effect.
IGNORED: dict[str, Numbers] = {"flock": (73, 32)}

# Calls that depend on an argument.
OPEN: Numbers = (2, None)
OPENAT = (257, 56)
CLONE, TGKILL, PRLIMIT, SETRLIMIT = (56, 220), (234, 131), (302, 261), (160, 164)
FCNTL, IOCTL, PRCTL, FUTEX = (72, 25), (16, 29), (157, 167), (202, 98)
CLOCKS: dict[str, Numbers] = {
    "clock_gettime": (228, 113),
    "clock_getres": (229, 114),
    "clock_nanosleep": (230, 115),
}
ABOUT_PROCESSES: dict[str, tuple[int, Numbers]] = {
    "sched_getaffinity": (0, (204, 123)),
    "sched_getscheduler": (0, (145, 120)),
    "sched_getparam": (0, (143, 121)),
    "sched_getattr": (0, (315, 275)),
    "sched_rr_get_interval": (0, (148, 127)),
    "getpgid": (0, (121, 155)),
    "getsid": (0, (124, 156)),
    "get_robust_list": (0, (274, 100)),
    "getpriority": (1, (140, 141)),
    "ioprio_get": (1, (252, 31)),
}
"""Calls that tell something about a process, with the position of the argument that names it."""
CLONE_THREAD = 0x00010000
FILE_COMMANDS = (0, 1, 2, 3, 4, 1030, 1032)
"""Of ``fcntl``: to duplicate a descriptor, to get and set its flags, and ``F_GETPIPE_SZ``."""
LOCK_COMMANDS = (6, 7, 37, 38)
"""Of ``fcntl``: ``F_SETLK``, ``F_SETLKW``, ``F_OFD_SETLK``, ``F_OFD_SETLKW``."""
DEVICE_COMMANDS = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
"""Of ``ioctl``: whether a file is a terminal and of what size, ``FIONREAD``, ``FIONBIO``,
``FIONCLEX``, ``FIOCLEX``. Others could change the attributes of a file that may only be read."""
FUTEX_WAIT, FUTEX_WAKE, FUTEX_WAIT_BITSET, FUTEX_PRIVATE, FUTEX_CLOCK = 0, 1, 9, 128, 256
CLOCK_OF_A_PROCESS = 0x80000000
PROCESSOR_TIME = 0
"""``RLIMIT_CPU``, the limit by which a process could have itself killed."""
SIGKILL = 9

END_WITH_PARENT = 1
"""``PR_SET_PDEATHSIG``, with which the process could survive its parent."""

NO_ERROR, EPERM, EAGAIN, EINVAL, ENOSYS = 0, 1, 11, 22, 38
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
    for numbers, error in ((REFUSED, EPERM), (ABSENT, ENOSYS), (IGNORED, NO_ERROR)):
        for known in (each[column] for each in numbers.values()):
            if known is not None:
                yield from (_if(EQUAL, known, 0, 1), _if(RETURN, ERRNO | error))
    for number, test in _tests(process):
        if number[column] is not None:
            yield _if(EQUAL, number[column] or 0, 0, len(test) + 1)
            yield from (*test, _if(RETURN, ALLOW))
    yield _if(RETURN, ALLOW)


def _tests(process: int) -> Iterator[tuple[Numbers, list[bytes]]]:
    """Yield the calls that depend on an argument, and the instructions that test it."""
    cut_short = [_if(MASK, os.O_ACCMODE | os.O_TRUNC), *_when(os.O_TRUNC)]
    yield OPEN, [_load(1), *cut_short]
    yield OPENAT, [_load(2), *cut_short]
    yield CLONE, [_load(0), _if(ANY_BIT, CLONE_THREAD, 1, 0), _if(RETURN, ERRNO | EPERM)]
    yield TGKILL, [_load(0), *_only(process), _load(2), *_when(SIGKILL)]
    yield PRLIMIT, [_load(0), *_only(0), _load(1), *_when(PROCESSOR_TIME)]
    yield SETRLIMIT, [_load(0), *_when(PROCESSOR_TIME)]
    yield PRCTL, [_load(0), *_when(END_WITH_PARENT)]
    yield FCNTL, [_load(1), *_when(*LOCK_COMMANDS, error=NO_ERROR), *_only(*FILE_COMMANDS)]
    yield IOCTL, [_load(1), *_only(*DEVICE_COMMANDS)]
    waits = [w | c for w in (FUTEX_WAIT, FUTEX_WAIT_BITSET) for c in (0, FUTEX_CLOCK)]
    shared = [*_when(*waits, error=EAGAIN), *_when(FUTEX_WAKE, error=NO_ERROR)]
    shared.append(_if(RETURN, ERRNO | EPERM))
    yield FUTEX, [_load(1), _if(ANY_BIT, FUTEX_PRIVATE, len(shared), 0), *shared]
    for number in CLOCKS.values():
        yield (
            number,
            [_load(0), _if(AT_LEAST, CLOCK_OF_A_PROCESS, 0, 1), _if(RETURN, ERRNO | EINVAL)],
        )
    for argument, number in ABOUT_PROCESSES.values():
        yield number, [_load(argument), *_only(0, process, error=ENOSYS)]


def _load(argument: int) -> bytes:
    """Return the instruction that loads the lower half of an argument."""
    return _if(LOAD, 16 + 8 * argument)


def _when(*values: int, error: int = EPERM) -> list[bytes]:
    """Return instructions that refuse each of these values."""
    return [line for v in values for line in (_if(EQUAL, v, 0, 1), _if(RETURN, ERRNO | error))]


def _only(*values: int, error: int = EPERM) -> list[bytes]:
    """Return instructions that refuse all values but these."""
    left = range(len(values), 0, -1)
    return [
        *(_if(EQUAL, v, n, 0) for v, n in zip(values, left, strict=True)),
        _if(RETURN, ERRNO | error),
    ]


def _if(code: int, value: int, then: int = 0, otherwise: int = 0) -> bytes:
    """Return a jump: the numbers of instructions to skip if the condition holds, and if not."""
    return struct.pack("HBBI", code, then, otherwise, value)
