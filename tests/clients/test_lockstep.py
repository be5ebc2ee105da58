"""The script of docs/lockstep.md, twice: its flight is the same to the bit."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.clients.conftest import TestbenchProcess

PAGE = Path(__file__).parents[2] / "docs" / "lockstep.md"
(SCRIPT,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)


def fly(script: str) -> dict:
    """Verdict of a run that the script keeps the time of; the run ends when it leaves."""
    bench = TestbenchProcess("--lockstep", "--speed", "max", "--json")
    try:
        bench.wait_until_open()
        environment = os.environ | {"MAVLINK20": "1"}
        client = subprocess.run(
            [sys.executable, "-c", script.replace("5760", str(bench.tcp_port))],
            capture_output=True,
            text=True,
            check=False,
            env=environment,
        )
        assert client.returncode == 0, client.stderr
        assert client.stdout.startswith("landed after")
        output, errors = bench.process.communicate()
        assert bench.process.returncode == 0, errors
        return json.loads(output)
    finally:
        bench.kill()


@pytest.mark.timeout(300)
def test_a_script_that_keeps_the_time_flies_the_same_flight_twice():
    first, second = fly(SCRIPT), fly(SCRIPT)
    assert first["reason"] == "ended by the client that kept the time"
    assert first["state_hash"] == second["state_hash"]
    assert first["sim_seconds"] == second["sim_seconds"] > 5.0
