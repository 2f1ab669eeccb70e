"""Two submissions that run at once see nothing of each other."""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from fieldgrade.isolation import server as server_module
from fieldgrade.isolation.process import Process, Program
from fieldgrade.isolation.server import Server
from fieldgrade.sandbox import mounts
from hostile.case import HERE, SANDBOXED
from hostile.channels import BEFORE, CHANNELS
from hostile.conftest import LIMITS as STRICT

pytestmark = pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
TIERS = [tier for tier in HERE if tier in SANDBOXED]
A_DAY = 86400
LIMITS = replace(STRICT, cpu_seconds=100, seconds_per_cell=300.0)


def started(server, *cells):
    """A process of a server that has run the first of some cells, and the error of that cell."""
    process = Process(server, time.monotonic() + 600)
    process.await_start()
    process.load(Program([f"import numpy as np{BEFORE}{cells[0]}", *cells[1:]]), ())
    return process, process.cell(0, ())["error"]


def unread_file():
    """A file of the system whose time of access the next reader changes, if there is one."""
    for folder, _, names in os.walk("/usr/share"):
        for path in (Path(folder, name) for name in names):
            found = path.lstat()
            stale = found.st_atime <= max(found.st_mtime, time.time() - A_DAY)
            if path.is_file() and not path.is_symlink() and found.st_size and stale:
                return path
    return Path(sys.executable)


def seen(servers, channel, sends, unread):
    """What the receiver sees when the other submission sends or does nothing."""
    send, receive = (c.replace("@UNREAD@", str(unread)) for c in (channel.send, channel.receive))
    sender, error = started(servers[0], "raise ValueError(os.getpid())", send)
    number = error.rpartition(" ")[2]
    try:
        if sends:
            sender.cell(1, ())
        receive = receive.replace("@SENDER@", number)
        receiver, error = started(servers[1], f"{receive}\nraise ValueError(repr(seen))")
        receiver.end()
    finally:
        sender.end()
    return error.replace(f"/proc/{number}/", "/proc/SENDER/")


def test_the_unread_file_and_the_names_of_channels_are_distinct():
    assert len({channel.name for channel in CHANNELS}) == len(CHANNELS)
    assert unread_file().is_file()


@pytest.fixture(scope="module", params=[(tier, own) for tier in TIERS for own in (True, False)])
def pair(request, tmp_path_factory):
    """Two servers of a tier, with and without mounts of their own."""
    tier, own_mounts = request.param
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server_module, "OWN_MOUNTS", own_mounts)
        with Server(tier, LIMITS).started() as first, Server(tier, LIMITS).started() as second:
            allowed = own_mounts and mounts.are_allowed(str(tmp_path_factory.mktemp("home")))
            yield first, second, allowed or tier == "bubblewrap"


@pytest.mark.slow
def test_two_submissions_cannot_exchange_messages(pair):
    """Without mounts of its own, the tier landlock leaves a few channels open."""
    *servers, has_mounts = pair
    unread = unread_file()
    channels = [channel for channel in CHANNELS if has_mounts or not channel.needs_mounts]
    found = {c.name: [seen(servers, c, sends, unread) for sends in (False, True)] for c in channels}
    assert {name: pair for name, pair in found.items() if pair[0] != pair[1]} == {}
