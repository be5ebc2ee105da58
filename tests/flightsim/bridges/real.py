"""The real flight stacks, for tests where AEROSCENE_PX4 or AEROSCENE_ARDUCOPTER names a binary."""

import math
import os
import shlex
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from flightsim.mavlink.client import CommandState
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.testbench import TestbenchCfg
from tests.instances import own_instance

_NAN = float("nan")


class Real(NamedTuple):
    """A flight stack, its binary, and how it takes off."""

    name: str
    title: str
    variable: str
    takeoff: tuple
    height_m: float

    @property
    def binary(self):
        return os.environ.get(self.variable, "")

    def cfg(self, **more):
        options = {"autopilot": self.name, "speed": "max", "instance": own_instance(), **more}
        return TestbenchCfg(**options)

    def start(self, start_line, folder):
        """Start it by the line that the run prints, as a user does."""
        words = shlex.split(start_line.replace("$PATH", os.environ["PATH"]))
        n_variables = next(k for k, word in enumerate(words) if "=" not in word)
        variables = dict(word.split("=", 1) for word in words[:n_variables])
        arguments = words[n_variables + 1 :]
        if self.name == "px4":
            etc = str(Path(self.binary).parent.parent / "etc")
            arguments = [etc, *arguments, "-w", str(folder)]
        with (folder / "output.txt").open("ab") as log:
            return subprocess.Popen(
                [self.binary, *arguments],
                cwd=folder,
                env={**os.environ, **variables},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )


ARM = (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
PX4 = Real("px4", "PX4", "AEROSCENE_PX4", (ARM, (mavlink.MAV_CMD_NAV_TAKEOFF, *(_NAN,) * 7)), 2.5)
ARDUCOPTER = Real(
    "ardupilot",
    "ArduPilot",
    "AEROSCENE_ARDUCOPTER",
    (
        (mavlink.MAV_CMD_DO_SET_MODE, 1, 4),  # GUIDED
        ARM,
        (mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 5.0),
    ),
    5.0,
)


def needs(real):
    """Skips what cannot be flown here, and gives it time."""
    return [
        pytest.mark.skipif(not real.binary, reason=f"{real.variable} names no binary"),
        pytest.mark.timeout(600),
    ]


class Pilot:
    """A client in the process, which says commands until they are accepted."""

    def __init__(self, bench, real):
        self.bench, self.real, self.client = bench, real, bench.connect()
        self._start_m = self.height_m = 0.0
        self._start_m = bench.plant.truth.position_enu_m[2]
        bench.observers.append(self._look)
        bench.run(60.0, until=lambda: self.client.telemetry.has_state)

    def _look(self):
        self.client.update(self.bench.plant.time_us)
        self.height_m = self.bench.plant.truth.position_enu_m[2] - self._start_m

    def demand(self, command, *params):
        for _ in range(60):
            sent = self.client.command(command, *params)
            self.bench.run(10.0, until=lambda sent=sent: sent.is_done)
            if sent.state is CommandState.ACCEPTED:
                return
            self.bench.run(1.0)
        raise AssertionError(f"{command}: {sent.outcome()}, {self.client.telemetry.texts[-3:]}")

    def take_off(self):
        for command, *params in self.real.takeoff:
            self.demand(command, *params)
        self.bench.run(20.0)

    def error(self):
        """Distance in metres and angle in degrees of its estimate from the truth."""
        truth, believed = self.bench.plant.truth, self.bench.plant.estimate
        share = abs(sum(a * b for a, b in zip(truth.quat_wxyz, believed.quat_wxyz, strict=True)))
        angle_deg = math.degrees(2.0 * math.acos(min(1.0, share)))
        return math.dist(truth.position_enu_m, believed.position_enu_m), angle_deg
