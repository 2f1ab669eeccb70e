"""Settings of the tests, and the header of a test run."""

import gc
import signal

from hypothesis import HealthCheck, settings

from fieldgrade.isolation.server import TIERS
from hostile.case import HERE

# Shells start background jobs with Ctrl-C ignored, and programs inherit this. Some tests send it.
signal.signal(signal.SIGINT, signal.default_int_handler)

# No test has a deadline, which a busy machine would miss. Every run has the same examples.
settings.register_profile(
    "fieldrecon", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fieldrecon")


def pytest_collection_finish():
    """Spare the garbage collector the modules and items, which stay: saves a tenth of the time."""
    gc.freeze()


def pytest_report_header():
    """Name the available sandboxes for hostile submissions, and the missing ones."""
    missing = ", ".join(tier for tier in TIERS if tier not in HERE)
    left_out = f"; not on this machine, so their cases are LEFT OUT: {missing}" if missing else ""
    return f"isolation: {', '.join(HERE)}{left_out}"
