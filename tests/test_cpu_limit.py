"""The limit of a test: CPU time ends it, waiting does not, and a hang is ended at last."""

import os
import sys

pytest_plugins = "pytester"

TESTS = """
import subprocess
import sys
import time
import pytest
from tests import cpu_limit

cpu_limit.WALL_PER_CPU = 100.0  # so that another load on the machine changes nothing here

@pytest.mark.timeout(0.4)
def test_busy():
    while True:
        pass

@pytest.mark.timeout(0.4)
def test_busy_child():
    subprocess.run([sys.executable, "-S", "-c", "while True: pass"])

@pytest.mark.timeout(0.4)
def test_waits():
    time.sleep(1.0)

@pytest.fixture
def slow_to_set_up():
    while True:
        pass

@pytest.mark.timeout(0.4)
def test_busy_fixture(slow_to_set_up):
    pass

@pytest.mark.timeout(0.03)
def test_hangs():
    time.sleep(60.0)
"""


def test_cpu_time_ends_a_test_and_waiting_does_not(pytester, monkeypatch):
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    pytester.makepyfile(TESTS)
    result = pytester.runpytest_subprocess(
        "-p", "pytest_timeout", "-p", "tests.cpu_limit", "-p", "no:cacheprovider", "-rA"
    )
    result.assert_outcomes(passed=1, failed=3, errors=1)
    result.stdout.fnmatch_lines_random(
        [
            "PASSED *test_waits",
            "FAILED *test_busy - Failed: over the limit of 0.4 s of CPU time*",
            "FAILED *test_busy_child - Failed: over the limit of 0.4 s of CPU time*",
            "ERROR *test_busy_fixture - Failed: over the limit of 0.4 s of CPU time*",
            "FAILED *test_hangs - Failed: over the limit of 0.03 s of CPU time, or 3 s of wall*",
        ]
    )
