"""Sensors by option: they reach the run, and bad ones end it in one line."""

import subprocess
import sys

import numpy as np
import pytest

from flightsim.testbench import TestbenchCfg
from scenarios.recording import layout
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.scenarios.recording.conftest import Contents


class Idle:
    """A companion that looks through everything it has and does nothing."""

    is_done, verdict, area = False, None, None

    def __init__(self, aboard):
        self.aboard, self.scans, self.frames = aboard, [], []

    def update(self, time_us):
        scan = self.aboard.scan()
        if scan is not None and scan not in self.scans:
            self.scans.append(scan)
        if time_us % 200_000 == 0:
            self.frames.append(self.aboard.render("left"))


def test_options_reach_companion_and_recording(tmp_path):
    angles = tmp_path / "angles.csv"
    angles.write_text("azimuth_deg,elevation_deg\n0,-90\n0,-45\n")
    bench = TestbenchCfg(
        speed="max",
        camera_size="32x24",
        camera=("left,yaw=90,fov=80",),
        segmentation=True,
        lidar=str(angles),
        optical_flow=True,
    )
    path = tmp_path / "flight.rrd"
    cfg = SitlCfg(scene="field", bench=bench, record=path, camera_hz=5.0, headless_seconds=0.5)
    made = []
    with Sitl(
        cfg, pilot=lambda aboard: made.append(Idle(aboard)) or made[0], has_network=False
    ) as run:
        run.bench.simulator.run(until_us=500_000, stop=lambda: False)
        flow = run.bench.plant.sensors.optical_flow
    (idle,) = made
    assert flow.integration_us == 20_000
    assert [scan.time_us for scan in idle.scans] == [100_000, 200_000, 300_000, 400_000, 500_000]
    height_m = run.bench.airframe.leg_length_m + 0.1
    assert idle.scans[0].range_m == pytest.approx((height_m, 2**0.5 * height_m), abs=0.08)
    assert len(idle.frames) == 2
    assert idle.frames[0].rgb.shape == (24, 32, 3)
    assert idle.frames[0].class_ids.shape == (24, 32)
    assert idle.frames[0].fx == pytest.approx(12.0 / np.tan(np.radians(40.0)))
    entities = Contents(path).entities()
    for camera in ("forward", "down", "left"):
        assert f"/{layout.camera_classes(camera)}" in entities
    assert f"/{layout.LIDAR}" in entities


def test_a_bad_option_ends_the_command_in_one_line():
    command = [sys.executable, "-m", "scenarios.cli.sitl", "--lidar", "vlp32"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "lidar 'vlp32' is unknown; valid: vlp16, mid40, or a file" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
