"""The script of docs/camera.md, run as it stands, takes a photograph that is there to see."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.clients.conftest import TestbenchProcess

PAGE = Path(__file__).parents[2] / "docs" / "camera.md"
(SCRIPT,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.timeout(150)
def test_the_script_of_the_page_takes_a_photograph(tmp_path):
    folder = tmp_path / "captures"
    bench = TestbenchProcess("--captures", str(folder), "--headless-seconds", "600")
    try:
        bench.wait_until_open()
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT.replace("14540", str(14540 + bench.instance))],
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        word, _, name = done.stdout.split()
        assert word == "taken"
        assert (folder / name).stat().st_size > 10_000
        assert "Traceback" not in bench.stop()
    finally:
        bench.kill()
