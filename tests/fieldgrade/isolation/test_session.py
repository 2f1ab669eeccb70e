"""A session with one submission: failing cells are left out, and the others are run again."""

import os
import re
import signal
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from fieldcheck.calls import Call
from fieldgrade.isolation import file_access, process, session
from fieldgrade.isolation.server import MEBIBYTE, Limits, MachineFailed, Server, tiers
from fieldgrade.isolation.session import CallGroup, run
from fieldgrade.sandbox import frames

# Generous limits for busy machines; tests of time limits use the fixture `hasty`.
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
else:
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
    """The server with some of its time limits lowered."""

    def lowered(**seconds):
        monkeypatch.setattr(server, "limits", replace(LIMITS, **seconds))
        return server

    return lowered


def test_cells_are_run_and_functions_are_called(server):
    """Arrays are passed in and returned, and the process ends."""
    outcomes, log = run(server, ["import numpy as np", DOUBLE], [task(count=2)])
    assert statuses(outcomes) == {"double": ["returned", "returned"]}
    np.testing.assert_array_equal(outcomes["double"][0].values, [[2, 2, 2]])
    assert log.killed == []
    assert log.cell_errors == {}
    assert len(log.processes) == 1


@pytest.mark.slow
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
def test_a_cell_that_crashes_is_left_out(server, code, reason, sentence):
    """The cells before and after it are run, and the reason is reported."""
    outcomes, log = run(server, [DOUBLE, code, "double = double"], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert list(log.cell_errors) == [1]
    assert len(log.processes) == 2
    assert log.killed == [reason]
    assert re.search(sentence, log.cell_errors[1].error)


@pytest.mark.slow
def test_a_cell_that_exceeds_its_time_limit_is_left_out(hasty):
    """The cell sleeps, so that it uses no processor time."""
    sleep = "import time\ntime.sleep(9999)"
    outcomes, log = run(hasty(seconds_per_cell=3.0), [DOUBLE, sleep], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert log.killed == ["time"]
    assert "stopped after 3 seconds" in log.cell_errors[1].error


def test_a_stub_is_passed_over_below_an_answer_only(server):
    """A function of a library is not an answer, and a later answer replaces a stub."""
    stub = "def {}(x):\n    raise NotImplementedError"
    cells = [stub.format("double"), DOUBLE, stub.format("double")]
    cells += ["from numpy import *", stub.format("gradient"), stub.format("gradient")]
    outcomes, log = run(server, cells, [task(), task("gradient", "gradient")])
    assert statuses(outcomes) == {"double": ["returned"], "gradient": ["unwritten"]}
    assert log.stubs == ["double"]


def test_a_call_that_crashes_affects_its_question_only(server):
    """Other calls for this question are skipped; other questions continue in a new process."""
    cells = [DOUBLE, "import os\ndef broken(x):\n    os._exit(1)"]
    tasks = [
        task("1 a", question="1"),
        task("2 a", "broken", 2, "2"),
        task("2 b", "broken", 1, "2"),
        task("1 b", question="1"),
        task("3 a", question="3"),
    ]
    outcomes, log = run(server, cells, tasks)
    statuses_found = statuses(outcomes)
    assert statuses_found == {
        "1 a": ["returned"],
        "2 a": ["raised"] * 2,
        "1 b": ["returned"],
        "3 a": ["returned"],
    }
    assert log.broke == {"2 a": "exit"}
    assert len(log.processes) == 2


@pytest.mark.slow
def test_the_memory_of_the_grader_for_returned_values_is_limited(server, monkeypatch):
    """Groups share room for large values; each has its own room for values of ordinary size."""
    monkeypatch.setattr(session, "KEPT_OF_EACH_GROUP", 1000)
    monkeypatch.setattr(session, "KEPT_OF_ALL", 2000)
    large = "import numpy as np\ndef large(x):\n    return np.ones(200)"
    tasks = [task("a", "large", 2), task("b", "large"), task("c", count=40)]
    outcomes, _ = run(server, [DOUBLE, large], tasks)
    assert statuses(outcomes) == {
        "a": ["returned", "raised"],
        "b": ["returned"],
        "c": ["returned"] * 40,
    }
    assert outcomes["a"][1].error == process.TOO_LARGE


@pytest.mark.slow
def test_after_a_value_that_is_too_large_the_other_calls_are_skipped(server, monkeypatch):
    """A file that returns 32 MB in each of hundreds of calls would delay a whole class."""
    monkeypatch.setattr(session, "KEPT_OF_EACH_GROUP", 100)
    monkeypatch.setattr(session, "KEPT_OF_ALL", 0)
    code = (
        "import numpy as np\nmade = []\ndef large(x):\n    made.append(0)\n    return np.ones(99)"
    )
    counting = "def count(x):\n    return np.ones(1) * len(made)"
    tasks = [task("large", "large", 5), task("count", "count")]
    outcomes, _ = run(server, ["import numpy as np", code, counting], tasks)
    assert [outcome.error for outcome in outcomes["large"]] == [process.TOO_LARGE] * 5
    assert outcomes["count"][0].values[0] == 1


@pytest.mark.slow
def test_a_call_that_ignores_its_interruption_is_killed(hasty):
    """Its outcome is `timed out`."""
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
def test_sending_to_a_process_that_does_not_read_times_out(hasty):
    """The code answers in place of the worker and then reads no more."""
    large = CallGroup("large", (Call("double", (np.zeros(10**6),), "many"),), 9.0)
    outcomes, log = run(hasty(seconds_per_call=0.3), [DOUBLE, DEAF], [large])
    assert statuses(outcomes) == {"large": ["timed out"]}
    assert log.killed == ["time"]


def test_after_too_many_crashes_only_what_the_answers_need_is_run(server):
    """The crashes of other cells, also of those that assign something, cost no answer."""
    cells = ["import os", *["x = os._exit(1)"] * 10]
    outcomes, log = run(server, [*cells, DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert log.needed_only
    assert len(log.processes) == LIMITS.most_starts // 2 + 1


@pytest.mark.slow
def test_after_half_of_the_time_only_what_the_answers_need_is_run(hasty):
    """No cell is at fault: together they take longer than a submission may."""
    slow = [f"done_{k} = 1\nimport time; time.sleep(0.5)" for k in range(60)]
    outcomes, log = run(hasty(seconds_in_all=8.0), [*slow, DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert log.needed_only
    assert log.cell_errors == {}


def test_a_submission_whose_answers_need_too_many_crashes_is_abandoned(server):
    """The number of process starts is limited."""
    cells = ["import os", *["double = os._exit(1)"] * 10]
    outcomes, log = run(server, [*cells, DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["raised"]}
    assert "too often to continue" in outcomes["double"][0].error
    assert len(log.processes) == LIMITS.most_starts


@pytest.mark.slow
def test_a_submission_that_takes_too_long_in_total_is_abandoned():
    """Many cells below the limit of a cell cannot exceed the limit of the whole submission."""
    limits = replace(LIMITS, seconds_in_all=1.0)
    with Server(tiers()[0], limits).started() as short:
        cells = [f"done = {k}\nimport time; time.sleep(0.3)" for k in range(9999)]
        outcomes, _ = run(short, [*cells, DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["raised"]}


if sys.platform == "linux":

    @pytest.mark.slow
    def test_exceeded_processor_time_is_reported(hasty):
        """Background threads use up the processor time while the cell sleeps."""
        _, log = run(hasty(most_starts=1), [BUSY, "import time; time.sleep(9999)"], [task()])
        assert log.killed == ["time"]
        assert "processor time" in " ".join(map(str, log.cell_errors.values()))


def test_a_failure_of_the_machine_gives_no_outcome(server, monkeypatch):
    """The system kills the process, or the server reports a failure; the submission runs again."""
    real = Server.end
    for change in ({"killed": False, "signal": 9}, {"machine": "the system killed: no memory"}):
        with monkeypatch.context() as patch:
            patch.setattr(Server, "end", lambda s, p=False, c=change: replace(real(s, p), **c))
            with pytest.raises(MachineFailed, match="the system killed"):
                run(server, [DOUBLE], [task()])
    outcomes, _ = run(server, [DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}


@pytest.mark.slow
def test_a_killed_server_is_restarted(server):
    """The submission is graded by the new server."""
    before = server._process.pid
    os.kill(before, signal.SIGKILL)
    server._process.wait()
    outcomes, log = run(server, [DOUBLE], [task()])
    assert statuses(outcomes) == {"double": ["returned"]}
    assert log.killed == []
    assert server._process.pid != before


if sys.platform == "linux":

    @pytest.mark.slow
    def test_a_server_that_is_killed_during_a_run_is_restarted(server):
        """The interrupted work is repeated."""
        to_it, from_it = server.run()
        frames.receive(from_it, time.monotonic() + 600)
        os.kill(server._process.pid, signal.SIGKILL)
        server._process.wait()
        with pytest.raises(frames.PipeClosed):  # what the server made ends with it
            frames.receive(from_it, time.monotonic() + 600)
        os.close(to_it)
        os.close(from_it)
        assert "server ended" in server.end().machine
        outcomes, _ = run(server, [DOUBLE], [task()])
        assert statuses(outcomes) == {"double": ["returned"]}


@pytest.mark.slow
def test_after_a_timeout_other_calls_run_in_a_new_process(hasty):
    """The interrupted call may hold a lock that other calls need."""
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


@pytest.mark.slow
def test_a_process_that_does_not_start_is_a_grader_failure(monkeypatch):
    """A defect of the machine does not cost a student points."""
    with Server("none", LIMITS).started() as bare:
        monkeypatch.setattr(process, "SECONDS_TO_START", 0.0)
        with pytest.raises(process.NotStarted, match=r"no process starts in the sandbox \(none\)"):
            run(bare, [DOUBLE], [task()])


def test_a_server_that_does_not_start_is_a_grader_failure(monkeypatch):
    """The error is raised, and no folder is left behind."""
    monkeypatch.setattr(file_access.SandboxFolders, "python", lambda _: ["false"])
    made = Server("none", LIMITS)
    with pytest.raises(RuntimeError, match=r"\(none\) does not start"), made.started():
        raise AssertionError
    assert not made._scratch.folder.exists()


def test_text_from_submissions_is_shortened_and_stripped_of_control_characters():
    """Text that can be printed is kept, and objects that are not text are dropped."""
    assert process.as_text("caf\u00e9\nok") == "caf\u00e9\nok"
    assert process.as_text("\x1b[2J\ud800\0") == "\ufffd[2J\ufffd\ufffd"
    assert len(process.as_text("x" * 10**6)) == process.MOST_TEXT
    assert process.as_text(["x"]) == process.as_text(None) == ""
