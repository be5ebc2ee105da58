"""The script of docs/camera.md, run as it stands, takes a photograph in the air."""

import json

import pytest

from tests.clients.conftest import TestbenchProcess, run_page


@pytest.mark.timeout(150)
def test_the_script_of_the_page_takes_a_photograph(tmp_path):
    folder = tmp_path / "captures"
    bench = TestbenchProcess("--captures", str(folder), "--headless-seconds", "600")
    try:
        bench.wait_until_open()
        flying, taken, landed = run_page("camera.md", bench)
        assert (flying, landed) == ("flying", "landed")
        word, _, name = taken.split()
        assert word == "taken"
        # The photograph's own record says where the camera truly was.
        pose = json.loads((folder / name).with_suffix(".json").read_text())
        assert pose["position_enu_m_true"][2] > 1.5
        assert (folder / name).stat().st_size > 10_000
        assert "Traceback" not in bench.stop()
    finally:
        bench.kill()
