"""A submission at work: what breaks is left out, the rest is run again, and all of it ends."""

import os
import re
import signal
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from fieldcheck.calls import Call
from fieldgrade.isolation import file_access, session
from fieldgrade.isolation.server import MEBIBYTE, Limits, Server, tiers
from fieldgrade.isolation.session import CallGroup, run
from fieldgrade.sandbox import frames

# Patient, so that no busy machine comes too late; tests of what takes too long are `hasty`.
LIMITS = Limits(
    memory=256 * MEBIBYTE,
    cpu_seconds=2,
    seconds_per_cell=120,
    seconds_per_call=120,
    seconds_in_all=600,
    most_starts=4,
)
DOUBLE = "def double(x):\n    return 2 * x"
DEAF = """
import json, os, struct, sys, time
frame = sys._getframe()
while "outgoing" not in frame.f_locals:
    frame = frame.f_back
text = json.dumps({"frame": frame.f_locals["head"]["frame"], "error": "", "arrays": []}).encode()
os.write(frame.f_locals["outgoing"], struct.pack("!II", len(text), 0) + text)
time.sleep(9999)
"""
FILLING = """
import time
for k in range(6):
    open(str(k), "wb").write(bytes(15 << 20))
time.sleep(9999)
"""
BUSY = """
import signal, threading, time
signal.signal(signal.SIGXCPU, signal.SIG_IGN)
def busy():
    while True: pass
for _ in range(4):
    threading.Thread(target=busy, daemon=True).start()
"""
CLOSING = """
import os, time
for number in range(3, 64):
    try:
        os.close(number)
    except OSError:
        pass
time.sleep(9999)
"""


def task(name="double", function="double", count=1, question=""):
    return CallGroup(name, (Call(function, (np.ones(3),), "ones"),) * count, 9.0, question)


def statuses(outcomes):
    return {name: [outcome.status for outcome in its] for name, its in outcomes.items()}


@pytest.fixture(scope="module")
def server():
    with Server(tiers()[0], LIMITS).started() as started:
        yield started


@pytest.fixture
def hasty(server, monkeypatch):
    """The server, with some of its limits of time lowered."""

    def lowered(**seconds):
        monkeypatch.setattr(server, "limits", replace(LIMITS, **seconds))
        return server

    return lowered


def test_cells_run_and_calls_are_made(server):
    """Arrays go in, arrays come out, and the process ends."""
    outcomes, log = run(server, ["import numpy as np", DOUBLE], [task(count=2)])
    assert statuses(outcomes) == {"double": ["returned", "returned"]}
    np.testing.assert_array_equal(outcomes["double"][0].values, [[2, 2, 2]])
    assert log.killed == []
    assert log.cell_errors == {}
    assert len(log.processes) == 1


@pytest.mark.parametrize(
    ("code", "reason", "sentence"),
    [
        ("import os; os._exit(3)", "exit", "ended the program .exit status 3"),
        ("import ctypes; ctypes.string_at(0)", "crash", "segmentation fault"),
        ("import os; os.abort()", "crash", "aborted itself"),
        (CLOSING, "output", "closed the pipe"),
        (
            FILLING,
            "disk",
            "wrote too much",
        ),
    ],
)
def test_a_cell_that_breaks_is_left_out(server, code, reason, sentence):
    """The cells before and behind it count, and why it broke is told."""
    outcomes, log = run(server, [DOUBLE, code, "double = double"], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert list(log.cell_errors) == [1]
    assert len(log.processes) == 2
    assert log.killed == [reason]
    assert re.search(sentence, log.cell_errors[1])


@pytest.mark.slow
def test_a_cell_that_does_not_end_is_left_out(hasty):
    """After the seconds that a cell may take; it waits and uses up no processor time."""
    sleep = "import time\ntime.sleep(9999)"
    outcomes, log = run(hasty(seconds_per_cell=3.0), [DOUBLE, sleep], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert log.killed == ["time"]
    assert "stopped after 3 seconds" in log.cell_errors[1]


def test_a_call_that_breaks_costs_its_question_alone(server):
    """Tasks of its question are not tried again; those of others are, in a new process."""
    cells = [DOUBLE, "import os\ndef broken(x):\n    os._exit(1)"]
    tasks = [
        task("1 a", question="1"),
        task("2 a", "broken", 2, "2"),
        task("2 b", "broken", 1, "2"),
        task("1 b", question="1"),
        task("3 a", question="3"),
    ]
    outcomes, log = run(server, cells, tasks)
    told = statuses(outcomes)
    assert told == {
        "1 a": ["returned"],
        "2 a": ["raised"] * 2,
        "1 b": ["returned"],
        "3 a": ["returned"],
    }
    assert log.broke == {"2 a": "exit"}
    assert len(log.processes) == 2


def test_a_call_that_does_not_end_is_ended_from_outside(hasty):
    """Whoever swallows the interruption is killed soon after, and timed out."""
    code = """
import time
def double(x):
    while True:
        try:
            time.sleep(9999)
        except BaseException:
            continue
"""
    outcomes, log = run(hasty(seconds_per_call=0.3), [code], [task()])
    assert statuses(outcomes) == {"double": ["timed out"]}
    assert log.killed == ["time"]


@pytest.mark.slow
def test_a_process_that_does_not_read_holds_up_nobody(hasty):
    """Code answers in the worker's place and reads no more: what is sent has a deadline too."""
    large = CallGroup("large", (Call("double", (np.zeros(10**6),), "many"),), 9.0)
    outcomes, log = run(hasty(seconds_per_call=0.3), [DOUBLE, DEAF], [large])
    assert statuses(outcomes) == {"large": ["timed out"]}
    assert log.killed == ["time"]


def test_after_many_starts_it_is_given_up(server):
    """Each process may break down on another cell, but not for ever."""
    cells = ["import os; os._exit(1)"] * 10
    outcomes, log = run(server, [*cells, DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["raised"]}
    assert "too often to continue" in outcomes["double"][0].error
    assert len(log.processes) == LIMITS.most_starts


@pytest.mark.slow
def test_after_a_long_time_it_is_given_up():
    """No number of cells, each a little shorter than it may be, takes longer than all may."""
    limits = replace(LIMITS, seconds_in_all=1.0)
    with Server(tiers()[0], limits).started() as short:
        cells = [f"done = {k}\nimport time; time.sleep(0.3)" for k in range(9999)]
        outcomes, _ = run(short, [*cells, DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["raised"]}


if sys.platform == "linux":

    @pytest.mark.slow
    def test_processor_time_is_told_apart_from_memory(hasty):
        """Threads that compute in the background use it up, whatever else is waited for."""
        _, log = run(hasty(most_starts=1), [BUSY, "import time; time.sleep(9999)"], [task()])
        assert log.killed == ["time"]
        assert "processor time" in " ".join(log.cell_errors.values())


def test_a_server_that_is_gone_is_started_again(server):
    """It is nobody's fault: the submission is graded by the next one."""
    before = server._process.pid
    os.kill(before, signal.SIGKILL)
    server._process.wait()
    outcomes, log = run(server, [DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert log.killed == []
    assert server._process.pid != before


if sys.platform == "linux":

    def test_a_server_that_goes_in_the_middle_costs_one_start(server):
        """What then ran is run again."""
        to_it, from_it = server.run()
        frames.receive(from_it, time.monotonic() + 600)
        os.kill(server._process.pid, signal.SIGKILL)
        server._process.wait()
        with pytest.raises(frames.PipeClosed):  # what the server made ends with it
            frames.receive(from_it, time.monotonic() + 600)
        os.close(to_it)
        os.close(from_it)
        assert server.end().ended_for == "server"
        outcomes, _ = run(server, [DOUBLE], [task()])
        assert statuses(outcomes) == {"double": ["returned"]}


@pytest.mark.slow
def test_after_a_time_out_the_others_begin_anew(hasty):
    """What was interrupted in the middle, a lock perhaps that it holds, troubles nobody else."""
    slow = """
import threading, time
lock = threading.Lock()
def slow(x):
    lock.acquire()
    time.sleep(9999)
def double(x):
    assert lock.acquire(timeout=0.1)
    return 2 * x
"""
    tasks = [task("slow", "slow"), task()]
    outcomes, log = run(hasty(seconds_per_call=3.0), [slow], tasks)
    assert statuses(outcomes) == {"slow": ["timed out"], "double": ["returned"]}
    assert log.killed == []
    assert len(log.processes) == 2


def test_a_process_that_does_not_start_is_a_fault(monkeypatch):
    """Nobody is given nothing because a machine lacks something: the grader says so."""
    with Server("none", LIMITS).started() as bare:
        monkeypatch.setattr(session, "SECONDS_TO_START", 0.0)
        with pytest.raises(session.NotStarted, match=r"no process starts in the sandbox \(none\)"):
            run(bare, [DOUBLE], [task()])


def test_a_server_that_does_not_start_is_a_fault(monkeypatch):
    """It is said, and nothing is left behind."""
    monkeypatch.setattr(file_access.SandboxFolders, "python", lambda _: ["false"])
    made = Server("none", LIMITS)
    with pytest.raises(RuntimeError, match=r"\(none\) does not start"), made.started():
        raise AssertionError
    assert not made._scratch.exists()


def test_what_a_student_tells_is_short_and_steers_no_terminal():
    """Words are kept, as far as they can be shown; anything else is no word."""
    assert session._text("caf\u00e9\nok") == "caf\u00e9\nok"
    assert session._text("\x1b[2J\ud800\0") == "\ufffd[2J\ufffd\ufffd"
    assert len(session._text("x" * 10**6)) == session.MOST_TEXT
    assert session._text(["x"]) == session._text(None) == ""
