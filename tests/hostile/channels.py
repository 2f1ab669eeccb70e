"""Ways in which two submissions that run at once could exchange messages.

One submission runs `send` or nothing; the other one runs `receive`, which puts what it sees into
`seen`. It must see the same in both cases.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Channel:
    """Code that leaves a trace, and code that looks for it.

    ``@SENDER@`` is the number of the process that sends, and ``@UNREAD@`` a file of the system that
    nobody has read for a day.

    Parameters
    ----------
    name : str
        What carries the message.
    send, receive : str
        Cells of the two submissions.
    needs_mounts : bool
        Whether the channel is closed by mounts of the sandbox, which some systems forbid.
    """

    name: str
    send: str
    receive: str
    needs_mounts: bool = False


BEFORE = """
import ctypes, fcntl, mmap, os, struct, sys, threading, time
C = ctypes.CDLL(None, use_errno=True)
shared = open(ctypes.__file__, "rb")
seen = None
def descriptions(command, kind):
    return struct.unpack("hhlli", fcntl.fcntl(shared, command, struct.pack("hhlli", *kind)))[0:4]
def word():
    mapped = mmap.mmap(shared.fileno(), 4096, access=mmap.ACCESS_READ)
    array = np.frombuffer(mapped, "i4")
    return ctypes.c_void_p(array.ctypes.data), int(array[0])
futex = {"x86_64": 202, "aarch64": 98}[os.uname().machine]
timer = {"x86_64": 222, "aarch64": 107}[os.uname().machine]
"""
WAITING = """
address, value = word()
def wait():
    C.syscall(futex, address, 0, value, None, None, 0)
threading.Thread(target=wait, daemon=True).start()
time.sleep(0.2)
"""
THREADS = """
for _ in range(40):
    threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
"""
TIMERS = """
seen, made = 0, ctypes.c_int()
while C.syscall(timer, 1, None, ctypes.byref(made)) == 0 and seen < 10 ** 6:
    seen += 1
"""

CHANNELS = [
    Channel(
        "a record lock of 16 bytes",
        "fcntl.lockf(shared, fcntl.LOCK_SH, 9, 77)",
        "seen = descriptions(fcntl.F_GETLK, (fcntl.F_WRLCK, 0, 0, 0, 0))",
    ),
    Channel(
        "a lock of an open file",
        "fcntl.fcntl(shared, 37, struct.pack('hhlli', fcntl.F_RDLCK, 0, 77, 9, 0))",
        "seen = descriptions(36, (fcntl.F_WRLCK, 0, 0, 0, 0))",
    ),
    Channel(
        "a lock of a whole file",
        "fcntl.flock(shared, fcntl.LOCK_SH)",
        "fcntl.flock(shared, fcntl.LOCK_EX | fcntl.LOCK_NB); seen = 'free'",
    ),
    Channel(
        "a lock of the null device",
        "null = open(os.devnull); fcntl.flock(null, fcntl.LOCK_EX)",
        "fcntl.flock(open(os.devnull), fcntl.LOCK_EX | fcntl.LOCK_NB); seen = 'free'",
    ),
    Channel(
        "a lease",
        "fcntl.fcntl(shared, fcntl.F_SETLEASE, fcntl.F_RDLCK)",
        "seen = fcntl.fcntl(shared, fcntl.F_SETLEASE, fcntl.F_WRLCK)",
    ),
    Channel(
        "the expected lifetime of a file",
        "fcntl.fcntl(shared, 1036, struct.pack('Q', time.time_ns() % 4 + 2))",
        "seen = fcntl.fcntl(shared, 1035, bytes(8))",
    ),
    Channel(
        "a futex in a common file",
        WAITING,
        "seen = C.syscall(futex, word()[0], 1, 9, None, None, 0)",
    ),
    Channel(
        "a futex that is moved",
        WAITING,
        "address, value = word(); "
        "seen = C.syscall(futex, address, 4, 9, 9, ctypes.c_void_p(address.value + 64), value)",
    ),
    Channel(
        "threads, counted by the system",
        THREADS,
        "seen = os.stat('/proc/@SENDER@/task').st_nlink >= 42",
        needs_mounts=True,
    ),
    Channel(
        "open files, counted by the system",
        "kept = [os.dup(0) for _ in range(49)]",
        "seen = os.stat('/proc/@SENDER@/fd').st_size > 48",
        needs_mounts=True,
    ),
    Channel(
        "threads, asked for one by one",
        THREADS,
        "seen = sum(C.sched_getscheduler(@SENDER@ + n) >= 0 for n in range(400)) >= 40",
    ),
    Channel(
        "threads, by their priority",
        THREADS,
        "seen = sum(C.getpriority(0, @SENDER@ + n) >= 0 for n in range(400)) >= 40",
    ),
    Channel(
        "processor time",
        "end = time.process_time() + 1\nwhile time.process_time() < end: pass",
        "used = (ctypes.c_long * 2)()\n"
        "seen = C.clock_gettime((~@SENDER@ << 3) | 2, used) == 0 and used[0] >= 1",
    ),
    Channel("timers of the user", TIMERS, TIMERS),
    Channel(
        "the time at which a file was read",
        "open('@UNREAD@', 'rb').read(1)",
        "seen = os.stat('@UNREAD@').st_atime_ns",
        needs_mounts=True,
    ),
]
