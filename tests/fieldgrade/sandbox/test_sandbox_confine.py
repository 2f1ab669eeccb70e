"""The parts of the sandbox: each forbids something that succeeds without it."""

import ctypes
import fcntl
import os
import re
import resource
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest

from fieldgrade.sandbox import confine, landlock, seccomp

pytestmark = pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
LINUX = sys.platform == "linux"
LANDLOCK = landlock.version()


def in_a_child(*steps):
    """Run steps in a child process; return "done", or the kind of error of the last step."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        outcome = "done"
        try:
            for step in steps:
                step()
        except BaseException as error:
            outcome = type(error).__name__
        finally:
            try:
                os.write(into, outcome.encode())
            finally:
                os._exit(0)
    os.close(into)
    with os.fdopen(out) as file:
        outcome = file.read()
    _, status = os.waitpid(child, 0)
    return f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else outcome


def libc(name, *arguments):
    """Call a function of the C library, and raise OSError if it fails."""
    c = ctypes.CDLL(None, use_errno=True)
    if getattr(c, name)(*arguments) == -1:
        raise OSError(ctypes.get_errno(), name)


def fork():
    if os.fork() == 0:
        os._exit(0)


def look_at_the_parent():
    found = ctypes.CDLL(None).sched_getscheduler(os.getppid())
    if found < 0:
        raise PermissionError


def program():
    try:
        os.execv("/no such program", ["program"])
    except FileNotFoundError:
        return  # the kernel has looked for the program


def system_v_memory():
    c = ctypes.CDLL(None, use_errno=True)
    number = c.shmget(0, 4096, 0o1600)
    if number == -1:
        raise OSError(ctypes.get_errno(), "shmget")
    c.shmctl(number, 0, None)


FORBIDDEN = {
    "another process": fork,
    "a program": program,
    "a program started": lambda: subprocess.run(["/bin/true"], check=True),
    "a signal to the parent": lambda: os.kill(os.getppid(), 0),
    "a signal to every process": lambda: os.kill(os.getppid(), signal.SIGCONT),
    "a socket": lambda: socket.socket().close(),
    "a socket of datagrams": lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM).close(),
    "a socket of this machine": lambda: socket.socket(socket.AF_UNIX).close(),
    "a pair of sockets": socket.socketpair,
    "to be traced": lambda: libc("ptrace", 0, 0, 0, 0),
    "files in memory": lambda: os.close(os.memfd_create("x")),
    "memory that is shared by number": system_v_memory,
    "other rights of a file": lambda: Path("file").chmod(0o600),
    "another owner of a file": lambda: os.chown("file", os.getuid(), os.getgid()),
    "other times of a file": lambda: os.utime("file"),
    "a file cut short": lambda: os.truncate("file", 0),
    "a file cut short by opening it": lambda: os.open("file", os.O_RDONLY | os.O_TRUNC),
    "a named pipe": lambda: os.mkfifo("pipe"),
    "a session of its own": os.setsid,
    "spaces of names": lambda: libc("unshare", 0),
    "to outlive the parent": lambda: libc("prctl", 1, 0, 0, 0, 0),
    "limits of others": lambda: resource.prlimit(os.getppid(), resource.RLIMIT_CPU),
    "signals for files": lambda: fcntl.fcntl(0, fcntl.F_SETOWN, os.getpid()),
    "to watch files": lambda: libc("inotify_init"),
    "a lease": lambda: fcntl.fcntl(os.open("file", os.O_RDONLY), fcntl.F_SETLEASE, fcntl.F_RDLCK),
    "a larger pipe": lambda: fcntl.fcntl(os.pipe()[0], fcntl.F_SETPIPE_SZ, 1 << 17),
    "less processor time": lambda: libc("setrlimit", 0, (ctypes.c_long * 2)(99, 99)),
    "the load of the machine": lambda: libc("sysinfo", ctypes.create_string_buffer(200)),
    "the scheduler of the parent": look_at_the_parent,
    "to watch another process": lambda: os.close(os.pidfd_open(os.getppid())),
}
ALLOWED = {
    "locks": lambda: [fcntl.flock(os.open("file", 0), fcntl.LOCK_EX) for _ in range(2)],
    "locks of parts": lambda: fcntl.lockf(os.open("file", os.O_RDWR), fcntl.LOCK_EX, 1),
    "other limits of its own": lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 40, 1 << 40)),
    "its processors": lambda: os.sched_getaffinity(0),
    "its processor time": time.process_time,
    "threads": lambda: [t.start() or t.join() for t in [threading.Thread(target=len, args=("",))]],
    "files": lambda: Path("other").write_text("x"),
    "folders": lambda: Path("folder").mkdir(),
    "time": lambda: time.sleep(0.001),
    "numbers at random": lambda: os.urandom(4),
    "to end itself": lambda: None,
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("content")
    return tmp_path


if seccomp.is_known():

    @pytest.mark.slow
    @pytest.mark.parametrize("what", FORBIDDEN)
    def test_seccomp_refuses_forbidden_calls(what, folder):
        """The call is refused with the filter and succeeds without it."""
        assert in_a_child(FORBIDDEN[what]) == "done"
        (folder / "pipe").unlink(missing_ok=True)
        (folder / "file").write_text("content")
        assert in_a_child(seccomp.refuse, FORBIDDEN[what]) == "PermissionError"
        assert (folder / "file").read_text() == "content"

    @pytest.mark.parametrize("what", ALLOWED)
    @pytest.mark.usefixtures("folder")
    def test_seccomp_allows_harmless_calls(what):
        assert in_a_child(seccomp.refuse, ALLOWED[what]) == "done"

    def test_seccomp_covers_later_threads_and_unknown_system_calls():
        """A thread started later has the same filter, and unknown system calls do not exist."""

        def in_a_thread():
            failed = []

            def tried():
                try:
                    socket.socket()
                except PermissionError:
                    failed.append(True)

            thread = threading.Thread(target=tried)
            thread.start()
            thread.join()
            if not failed:
                raise AssertionError

        assert in_a_child(seccomp.refuse, in_a_thread) == "done"
        newer = [lambda: libc("syscall", ctypes.c_long(seccomp.FIRST_UNKNOWN), 0, 0, 0)]
        assert in_a_child(seccomp.refuse, *newer) == "OSError"


@pytest.mark.parametrize("machine", seccomp.ARCHITECTURES)
def test_the_seccomp_filter_is_a_valid_program(machine):
    """Eight bytes per instruction, no jump past the end, and below the kernel's limit of length."""
    lines = list(seccomp._program(machine, 1234))
    assert all(len(line) == 8 for line in lines)
    assert len(lines) < 4096
    for index, line in enumerate(lines):
        code, then, otherwise = int.from_bytes(line[:2], sys.byteorder), line[2], line[3]
        if code != seccomp.RETURN:
            assert index + 1 + max(then, otherwise) < len(lines)
    numbers = [
        pair[list(seccomp.ARCHITECTURES).index(machine)] for pair in seccomp.REFUSED.values()
    ]
    known = [number for number in numbers if number is not None]
    assert len(known) == len(set(known))
    assert max(known) < seccomp.FIRST_UNKNOWN


HEADERS = {
    "x86_64": Path("/usr/include/x86_64-linux-gnu/asm/unistd_64.h"),
    "aarch64": Path("/usr/include/asm-generic/unistd.h"),
}
"""Files in which the kernel lists its system calls; not every machine has them."""


LISTED = [machine for machine, header in HEADERS.items() if header.is_file()]
if LISTED:

    @pytest.mark.parametrize("machine", LISTED)
    def test_the_system_call_numbers_are_those_of_the_kernel(machine):
        """Every named call is compared, on both architectures."""
        lines = re.findall(r"__NR(?:3264)?_(\w+)[ \t]+(\d+)", HEADERS[machine].read_text())
        outcome = {name: int(number) for name, number in lines}
        column = list(seccomp.ARCHITECTURES).index(machine)
        for name, numbers in (seccomp.REFUSED | seccomp.ABSENT).items():
            assert outcome.get(name, numbers[column]) == numbers[column], name
            assert numbers[column] is not None or name not in outcome, name


if LANDLOCK:

    @pytest.fixture
    def fenced(folder):
        """Make readable, listable, writable and forbidden folders; return a function that locks."""
        for name in ("read", "listed", "written", "outside"):
            (folder / name).mkdir()
            (folder / name / "file").write_text(name)

        def locked():
            lock = landlock.ruleset(["read", "no such file"], ["listed"], ["written", os.devnull])
            landlock.restrict(lock)

        return locked

    REFUSED = {
        "read outside": lambda: Path("outside/file").read_text(),
        "list outside": lambda: list(Path("outside").iterdir()),
        "write outside": lambda: Path("outside/file").write_text("x"),
        "make outside": lambda: Path("outside/new").write_text("x"),
        "make a folder outside": lambda: Path("outside/folder").mkdir(),
        "link outside": lambda: Path("outside/link").symlink_to("/"),
        "link to what is outside": lambda: os.link("outside/file", "written/link"),
        "rename to inside": lambda: Path("outside/file").rename("written/taken"),
        "remove outside": lambda: Path("outside/file").unlink(),
        "write what may be read": lambda: Path("read/file").write_text("x"),
        "read what may be listed": lambda: Path("listed/file").read_text(),
        "read through a link": lambda: Path("written/way/file").read_text(),
    }

    @pytest.mark.parametrize("what", REFUSED)
    def test_landlock_refuses_access_outside_the_allowed_folders(what, fenced, folder):
        """Nothing outside the allowed folders changes; without Landlock each access succeeds."""
        (folder / "written/way").symlink_to(folder / "outside")
        before = sorted(
            (p.relative_to(folder), p.is_file() and p.read_text()) for p in folder.rglob("*")
        )
        assert in_a_child(fenced, REFUSED[what]) in ("PermissionError", "OSError")
        after = sorted(
            (p.relative_to(folder), p.is_file() and p.read_text()) for p in folder.rglob("*")
        )
        assert after == before
        assert in_a_child(REFUSED[what]) == "done"

    def test_landlock_allows_reading_listing_and_writing_where_permitted(fenced):
        steps = [
            lambda: Path("read/file").read_text(),
            lambda: list(Path("listed").iterdir()),
            lambda: Path("written/new").write_text("x"),
            lambda: Path("written/new").rename("written/newer"),
            lambda: Path("written/newer").unlink(),
            lambda: Path("written/folder").mkdir(),
            lambda: Path(os.devnull).write_text("x"),
        ]
        assert in_a_child(fenced, *steps) == "done"

    if LANDLOCK >= 4:

        def test_landlock_refuses_tcp_connections(fenced):
            """A port of this machine is the target."""
            with closing(socket.create_server(("127.0.0.1", 0))) as server:

                def connect():
                    socket.create_connection(server.getsockname(), 5).close()

                assert in_a_child(connect) == "done"
                assert in_a_child(fenced, connect) == "PermissionError"

    if LANDLOCK >= 6:

        def test_landlock_refuses_signals_to_outside_processes(fenced):

            def send():
                os.kill(os.getppid(), 0)

            assert in_a_child(send) == "done"
            assert in_a_child(fenced, send) == "PermissionError"


@pytest.mark.slow
def test_resource_limits_are_enforced(folder):
    """Memory, file size and open files are limited; without the limits each attempt succeeds."""

    def limited():
        confine.limit(confine.address_space() + (64 << 20), 60, 1 << 16)

    def write():
        (folder / "large").write_bytes(bytes(1 << 20))

    def open_many():
        for _ in range(confine.MOST_FILES + 1):
            os.open(os.devnull, os.O_RDONLY)

    tries = {"OSError": [write, open_many]} | (
        {"MemoryError": [lambda: bytearray(1 << 28)]} if LINUX else {}
    )
    for error, its in tries.items():
        for attempt in its:
            assert in_a_child(attempt) == "done"
            assert in_a_child(limited, attempt) == error


def test_all_other_file_descriptors_are_closed():
    """This includes descriptors above the limit of open files."""
    out, into = os.pipe()
    high = fcntl.fcntl(into, fcntl.F_DUPFD, confine.MOST_FILES + 100)
    try:

        def write():
            os.write(high, b"x")

        low = range(confine.MOST_FILES)
        assert in_a_child(write) == "done"
        assert in_a_child(lambda: confine.close_all_but([*low, high]), write) == "done"
        assert in_a_child(lambda: confine.close_all_but(low), write) == "OSError"
    finally:
        for number in (out, into, high):
            os.close(number)


if LINUX:

    @pytest.mark.slow
    def test_exceeded_processor_time_kills_the_process():
        """The process is killed even if it ignores the warning signal."""

        def busy():
            signal.signal(signal.SIGXCPU, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_CPU, (1, 2))
            end = time.monotonic() + 120
            while time.monotonic() < end:
                pass

        assert in_a_child(busy) == f"signal {signal.SIGKILL}"

    def test_all_capabilities_are_dropped():
        """This is checked against the superuser, who has them."""

        def effective():
            outcome = Path("/proc/self/status").read_text()
            return next(
                int(line.split()[1], 16) for line in outcome.splitlines() if "CapEff" in line
            )

        def none_left():
            if effective():
                raise AssertionError

        assert in_a_child(confine.drop_capabilities, none_left) == "done"
        if os.getuid() == 0:
            assert in_a_child(none_left) == "AssertionError"

    def outlives(seconds, *steps):
        """Whether a process that runs for so many seconds outlives its parent."""
        out, into = os.pipe()
        child = os.fork()
        if child == 0:
            own = os.getpid()
            if os.fork() == 0:
                for step in steps:
                    step(own)
                os.write(into, b"r")
                time.sleep(seconds)
                os.write(into, b"still here")
                os._exit(0)
            os.read(out, 1)
            os._exit(0)
        os.close(into)
        os.waitpid(child, 0)
        last_words = os.read(out, 20)
        os.close(out)
        return last_words == b"still here"

    def test_die_with_parent_ends_a_process_with_its_parent():
        """Without it the process outlives its parent."""
        assert not outlives(30, confine.die_with_parent)
        assert outlives(0.2)

    def test_adopt_orphans_makes_orphans_children():
        """A process whose parent has ended becomes a child of the adopting process."""

        def adopted():
            own, (out, into) = os.getpid(), os.pipe()
            if os.fork() == 0:
                parent = os.getpid()
                if os.fork() == 0:
                    while os.getppid() == parent:
                        time.sleep(0.01)
                    os.write(into, b"y" if os.getppid() == own else b"n")
                    os._exit(0)
                os._exit(0)
            if os.read(out, 1) != b"y":
                raise AssertionError

        assert in_a_child(confine.adopt_orphans, adopted) == "done"
        assert in_a_child(adopted) == "AssertionError"

    def test_hide_memory_prevents_other_processes_from_reading_memory():
        """The reader is a process of the same user without capabilities."""

        def parents_memory():
            confine.drop_capabilities()
            Path(f"/proc/{os.getppid()}/maps").read_text()

        def look():
            outcome = in_a_child(parents_memory)
            if outcome != "done":
                raise PermissionError(outcome)

        assert in_a_child(confine.drop_capabilities, look) == "done"
        hidden = [confine.drop_capabilities, confine.hide_memory]
        assert in_a_child(*hidden, look) == "PermissionError"
