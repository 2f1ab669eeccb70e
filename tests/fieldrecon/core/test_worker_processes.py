"""Worker processes: each is prepared first, and Ctrl-C is left to the parent."""

import os
import signal

from fieldrecon._core.worker_processes import WorkerPool, _ctrl_c_blocked


def prepare() -> None:
    os.environ["PREPARED"] = "yes"


def test_a_worker_is_prepared_before_its_first_call():
    """It runs `begin`, here a module's function, which this process does not run."""
    with WorkerPool(1, begin=prepare) as pool:
        assert pool.submit(os.getenv, "PREPARED").result() == "yes"
    assert "PREPARED" not in os.environ


def test_ctrl_c_is_blocked_while_a_worker_is_started():
    """Afterwards the mask is the one before."""
    with _ctrl_c_blocked():
        assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
