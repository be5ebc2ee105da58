"""The script of docs/camera.md, run as it stands, takes a photograph that is there to see."""

import pytest

from tests.clients.conftest import TestbenchProcess, run_page


@pytest.mark.timeout(150)
def test_the_script_of_the_page_takes_a_photograph(tmp_path):
    folder = tmp_path / "captures"
    bench = TestbenchProcess("--captures", str(folder), "--headless-seconds", "600")
    try:
        bench.wait_until_open()
        ((word, _, name),) = (line.split() for line in run_page("camera.md", bench))
        assert word == "taken"
        assert (folder / name).stat().st_size > 10_000
        assert "Traceback" not in bench.stop()
    finally:
        bench.kill()
