"""The scripts of docs/connect.md, run as they stand right after the start of the testbench."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "connect.md"
SCRIPTS = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)


@pytest.mark.timeout(150)
@pytest.mark.parametrize("script", SCRIPTS, ids=["mavsdk", "pymavlink"])
def test_a_script_of_the_page_takes_off_and_lands(testbench, script):
    # Only the ports are others, so that tests can run side by side.
    script = script.replace("14540", str(14540 + testbench.instance))
    script = script.replace("5760", str(testbench.tcp_port))
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    above, landed = done.stdout.splitlines()
    assert above.endswith("m above the start")
    assert landed == "landed"
