"""The scripts of docs/clients, run as they stand right after the start of the testbench."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGES = Path(__file__).parents[2] / "docs" / "clients"


def run(page: str, bench) -> list[str]:
    """Lines that the script of a page prints; only its ports are others."""
    (script,) = re.findall(r"```python\n(.*?)```", (PAGES / page).read_text(), re.DOTALL)
    script = script.replace("14540", str(14540 + bench.instance))
    script = script.replace("5760", str(bench.tcp_port))
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.timeout(150)
@pytest.mark.parametrize("page", ["mavsdk.md", "pymavlink.md"])
def test_a_script_of_a_page_takes_off_and_lands(testbench, page):
    above, landed = run(page, testbench)
    assert above.endswith("m above the start")
    assert landed == "landed"


@pytest.mark.timeout(150)
def test_the_script_for_dronekit_flies_to_a_place_as_with_ardupilot(copter):
    pytest.importorskip("dronekit", reason="dronekit2 comes with the extra `dev`")
    above, landed = run("dronekit.md", copter)
    assert above.endswith("m above the start")
    assert landed == "landed"
