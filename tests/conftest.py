"""How the tests are run, and what a run says at its head."""

from hypothesis import HealthCheck, settings

from fieldgrade.isolation.server import TIERS
from hostile.case import HERE

# No test is timed: a busy machine would fail it. The same examples come on every run.
settings.register_profile(
    "fieldrecon", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fieldrecon")


def pytest_report_header():
    """Name the walls behind which hostile submissions are tried, and those that are missing."""
    missing = ", ".join(tier for tier in TIERS if tier not in HERE)
    left_out = f"; not on this machine, so their cases are LEFT OUT: {missing}" if missing else ""
    return f"isolation: {', '.join(HERE)}{left_out}"
