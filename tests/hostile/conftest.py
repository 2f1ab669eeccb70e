"""Fixtures of the hostile suite: a server per tier, targets to protect, and a watchdog."""

import os
import secrets
import socket
import subprocess
import sys
import threading
from contextlib import ExitStack, closing
from pathlib import Path
from typing import ClassVar

import pytest

from fieldgrade.authoring.build import all_sources
from fieldgrade.authoring.trials import Trial
from fieldgrade.checking.course import Course
from fieldgrade.isolation import server as server_module
from fieldgrade.isolation.server import MEBIBYTE, Limits, Server
from fieldgrade.sandbox import landlock
from hostile.case import ROOT

LIMITS = Limits(
    memory=256 * MEBIBYTE,
    cpu_seconds=8,
    seconds_per_cell=5.0,
    seconds_per_call=6.0,
    seconds_in_all=300.0,
    most_starts=8,
)
SECONDS_FOR_A_CASE = 900


class Places:
    """Targets that a submission must not reach, and whether it reached them."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.token = f"{secrets.randbelow(10**9):09}"
        self.canary, self.out = folder / "canary", folder / "out"
        self.canary.mkdir()
        self.out.mkdir()
        (self.canary / "secret").write_text(self.secret)
        (self.out / "results.json").write_text("{}")
        (self.out / "gradebook.csv").write_text("student,points\n")
        self.sockets = [
            self._open(stack, socket.AF_INET, socket.SOCK_STREAM, ("127.0.0.1", 0)),
            self._open(stack, socket.AF_INET, socket.SOCK_DGRAM, ("127.0.0.1", 0)),
        ]
        if sys.platform == "linux":
            for address in (str(folder / "socket"), f"\0{self.token}"):
                opened = self._open(stack, socket.AF_UNIX, socket.SOCK_DGRAM, address)
                self.sockets.append(opened)
        self.bystander = stack.enter_context(
            # It waits for input that never comes, as long as these tests take.
            subprocess.Popen(["cat"], stdin=subprocess.PIPE, env={"GRADER_SECRET": self.secret})
        )
        stack.callback(self.bystander.kill)
        self.values = {
            "CANARY": str(self.canary),
            "OUT": str(self.out),
            "MARK": self.token,
            "SECRET": self.secret,
            "ROOT": str(ROOT),
            "HOME": str(Path.home()),
            "GRADER": str(os.getpid()),
            "TCP": str(self.sockets[0].getsockname()[1]),
            "UNIX": str(folder / "socket"),
            "UDP": str(self.sockets[1].getsockname()[1]),
        }
        self.before = self.seen()

    @property
    def secret(self) -> str:
        """A word that no submission may reveal."""
        return f"canary{self.token}"

    @staticmethod
    def _open(stack, family, kind, address):
        opened = stack.enter_context(closing(socket.socket(family, kind)))
        opened.bind(address)
        if kind == socket.SOCK_STREAM:
            opened.listen()
        opened.setblocking(False)
        return opened

    def seen(self) -> list[object]:
        """The state of the files and folders that a submission could change."""
        files = sorted(p for place in (self.canary, self.out) for p in (place, *place.rglob("*")))
        stats = [
            (str(p), p.lstat().st_mode, p.lstat().st_mtime_ns, p.lstat().st_uid) for p in files
        ]
        texts = [p.read_text() for p in files if p.is_file()]
        around = ["/tmp", "/var/tmp", "/dev/shm", "/", str(Path.home()), str(ROOT)]
        added = [p.name for a in around if Path(a).is_dir() for p in Path(a).glob("*" + self.token)]
        start_up = [Path.home() / name for name in ("sitecustomize.py", ".pythonrc", "poison.pth")]
        return [stats, texts, added, [p.exists() for p in start_up]]

    def reached(self) -> list[str]:
        """The targets that were reached."""
        found = [] if self.seen() == self.before else ["files outside"]
        found += [] if self.bystander.poll() is None else ["a process of somebody else"]
        for opened in self.sockets:
            try:
                if opened.type == socket.SOCK_STREAM:
                    opened.accept()[0].close()
                else:
                    opened.recv(1)
            except BlockingIOError:
                continue
            found.append(f"the network: {opened}")
        return found


@pytest.fixture(scope="session")
def places(tmp_path_factory):
    with ExitStack() as stack:
        made = Places(tmp_path_factory.mktemp("outside"), stack)
        os.environ["GRADER_SECRET"] = made.secret
        yield made
        del os.environ["GRADER_SECRET"]


class RememberingCourse(Course):
    """A course that computes the right values for a student once, since all cases are of a few."""

    known: ClassVar[dict[object, dict[str, tuple[Trial, ...]]]] = {}

    def trials(self, number, student, only=()):
        key = self.salt, number, student, *only
        if key not in self.known:
            self.known[key] = super().trials(number, student, only)
        return self.known[key]


@pytest.fixture(scope="session")
def course():
    sources = [s for s in all_sources(ROOT) if s.number in ("01", "02")]
    return RememberingCourse(sources, "a salt")


@pytest.fixture(scope="session")
def servers(places):
    """A server for each available tier, started on first use."""
    assert os.environ["GRADER_SECRET"] == places.secret
    with ExitStack() as stack:
        started = {}

        def server(tier, landlocked=True, own_mounts=True):
            kind = tier, landlocked, own_mounts
            if kind not in started:
                with pytest.MonkeyPatch.context() as patch:
                    patch.setattr(server_module, "OWN_MOUNTS", own_mounts)
                    if not landlocked:
                        patch.setattr(landlock, "version", lambda: 0)
                    started[kind] = stack.enter_context(Server(tier, LIMITS).started())
            return started[kind]

        yield server


@pytest.fixture
def watchdog():
    """A timer that kills a server and everything that runs in it."""
    timers = []

    def watch(server):
        timers.append(threading.Timer(SECONDS_FOR_A_CASE, server._process.kill))
        timers[-1].start()

    yield watch
    for timer in timers:
        timer.cancel()
