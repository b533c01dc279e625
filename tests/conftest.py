"""Settings for every test."""

import os

import pytest
from hypothesis import HealthCheck, settings

# shared machines stall: a slow example is no failure
settings.register_profile("house", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("house")


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """With TACTILE_REQUIRE_ALL=1, a test skipped for a missing package fails: a green full run hides nothing."""
    outcome = yield
    report = outcome.get_result()
    if report.skipped and os.environ.get("TACTILE_REQUIRE_ALL") and "could not import" in str(report.longrepr):
        report.outcome = "failed"
