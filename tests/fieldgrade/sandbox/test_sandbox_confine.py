"""The locks: with each of them something is refused that succeeds without it."""

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
    """How the last of some steps ended in a process of its own: "done", or the kind of error."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        told = "done"
        try:
            for step in steps:
                step()
        except BaseException as error:
            told = type(error).__name__
        finally:
            try:
                os.write(into, told.encode())
            finally:
                os._exit(0)
    os.close(into)
    with os.fdopen(out) as file:
        told = file.read()
    _, status = os.waitpid(child, 0)
    return f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else told


def libc(name, *arguments):
    """A call of the C library, which raises where it fails."""
    c = ctypes.CDLL(None, use_errno=True)
    if getattr(c, name)(*arguments) == -1:
        raise OSError(ctypes.get_errno(), name)


def fork():
    if os.fork() == 0:
        os._exit(0)


def program():
    try:
        os.execv("/no such program", ["program"])
    except FileNotFoundError:
        return  # the kernel has looked for it


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
    "to watch another process": lambda: os.close(os.pidfd_open(os.getppid())),
}
ALLOWED = {
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
    def test_what_seccomp_refuses(what, folder):
        """A call that is refused with the lock succeeds without it."""
        assert in_a_child(FORBIDDEN[what]) == "done"
        (folder / "pipe").unlink(missing_ok=True)
        (folder / "file").write_text("content")
        assert in_a_child(seccomp.refuse, FORBIDDEN[what]) == "PermissionError"
        assert (folder / "file").read_text() == "content"

    @pytest.mark.parametrize("what", ALLOWED)
    @pytest.mark.usefixtures("folder")
    def test_what_seccomp_allows(what):
        """What honest programs do goes on."""
        assert in_a_child(seccomp.refuse, ALLOWED[what]) == "done"

    def test_seccomp_holds_for_threads_and_newer_calls():
        """A thread made later is under the same lock; calls that are not known are not there."""

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
def test_the_filter_is_a_program(machine):
    """On each machine: eight bytes an instruction, no jump past the end, the kernel's limit."""
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
"""Where the kernel tells its numbers; not every machine has these files."""


TOLD = [machine for machine, header in HEADERS.items() if header.is_file()]
if TOLD:

    @pytest.mark.parametrize("machine", TOLD)
    def test_the_numbers_are_those_of_the_kernel(machine):
        """Of every call that is named, on both kinds of machines."""
        lines = re.findall(r"__NR(?:3264)?_(\w+)[ \t]+(\d+)", HEADERS[machine].read_text())
        told = {name: int(number) for name, number in lines}
        column = list(seccomp.ARCHITECTURES).index(machine)
        for name, numbers in (seccomp.REFUSED | seccomp.ABSENT).items():
            assert told.get(name, numbers[column]) == numbers[column], name
            assert numbers[column] is not None or name not in told, name


if LANDLOCK:

    @pytest.fixture
    def fence(folder):
        """A place with what may be read, listed and written, and what may not."""
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
    def test_what_landlock_refuses(what, fence, folder):
        """What lies outside of the fence cannot be touched; without the fence it can."""
        (folder / "written/way").symlink_to(folder / "outside")
        before = sorted(
            (p.relative_to(folder), p.is_file() and p.read_text()) for p in folder.rglob("*")
        )
        assert in_a_child(fence, REFUSED[what]) in ("PermissionError", "OSError")
        after = sorted(
            (p.relative_to(folder), p.is_file() and p.read_text()) for p in folder.rglob("*")
        )
        assert after == before
        assert in_a_child(REFUSED[what]) == "done"

    def test_what_landlock_allows(fence):
        """Reading, listing, and everything in the folder that may be written."""
        steps = [
            lambda: Path("read/file").read_text(),
            lambda: list(Path("listed").iterdir()),
            lambda: Path("written/new").write_text("x"),
            lambda: Path("written/new").rename("written/newer"),
            lambda: Path("written/newer").unlink(),
            lambda: Path("written/folder").mkdir(),
            lambda: Path(os.devnull).write_text("x"),
        ]
        assert in_a_child(fence, *steps) == "done"

    if LANDLOCK >= 4:

        def test_landlock_refuses_connections(fence):
            """A port of this machine cannot be connected to by TCP."""
            with closing(socket.create_server(("127.0.0.1", 0))) as server:

                def connect():
                    socket.create_connection(server.getsockname(), 5).close()

                assert in_a_child(connect) == "done"
                assert in_a_child(fence, connect) == "PermissionError"

    if LANDLOCK >= 6:

        def test_landlock_refuses_signals(fence):
            """Processes outside cannot be sent a signal."""

            def send():
                os.kill(os.getppid(), 0)

            assert in_a_child(send) == "done"
            assert in_a_child(fence, send) == "PermissionError"


def test_limits_hold(folder):
    """Memory, the size of files, and how many are open; without the limits all of it succeeds."""

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


def test_files_are_closed_whatever_their_number():
    """Also those with numbers above the limit of open files."""
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
    def test_processor_time_ends():
        """Whoever computes on and on is ended by the system, also who listens to no signal."""

        def busy():
            signal.signal(signal.SIGXCPU, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_CPU, (1, 2))
            end = time.monotonic() + 120
            while time.monotonic() < end:
                pass

        assert in_a_child(busy) == f"signal {signal.SIGKILL}"

    def test_capabilities_are_gone():
        """None is left, which the superuser had."""

        def effective():
            told = Path("/proc/self/status").read_text()
            return next(int(line.split()[1], 16) for line in told.splitlines() if "CapEff" in line)

        def none_left():
            if effective():
                raise AssertionError

        assert in_a_child(confine.drop_capabilities, none_left) == "done"
        if os.getuid() == 0:
            assert in_a_child(none_left) == "AssertionError"

    def outlives(seconds, *steps):
        """Whether a process that wants so many seconds more outlives the one that made it."""
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

    def test_a_process_ends_with_its_parent():
        """With the tie it ends at once, without it when it wants to."""
        assert not outlives(30, confine.die_with_parent)
        assert outlives(0.2)

    def test_orphans_are_adopted():
        """A process whose parent has ended is a child of the one that adopts."""

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

    def test_memory_is_hidden():
        """A process of the same user that has no capabilities cannot read another's memory."""

        def parents_memory():
            confine.drop_capabilities()
            Path(f"/proc/{os.getppid()}/maps").read_text()

        def look():
            told = in_a_child(parents_memory)
            if told != "done":
                raise PermissionError(told)

        assert in_a_child(confine.drop_capabilities, look) == "done"
        hidden = [confine.drop_capabilities, confine.hide_memory]
        assert in_a_child(*hidden, look) == "PermissionError"
