"""The real stacks stop before a wall that our ring scan shows, once they are told to mind it.

They fly where AEROSCENE_PX4 or AEROSCENE_ARDUCOPTER names a binary.
"""

from dataclasses import replace

import pytest

from flightsim.bridges.launch import ardupilot
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.testbench import Testbench
from tests.flightsim.bridges.real import ARDUCOPTER, PX4, Pilot, needs
from tests.flightsim.handmade import empty_scene
from tests.scenarios.landing_scenes import thing

WALL_M = 16.0
PX4_MARGIN_M = 4.0
ARDUCOPTER_M = (0.5, 3.0)
"""About its AVOID_MARGIN of 2 m, which it overshoots at this speed before it backs away."""
POSITION_MODE = 3
FULL_AHEAD, MIDDLE = 1000, 500
BY_MAVLINK = 2
SPEED_MPS = 2.0
VELOCITY_ALONE = 0b110111000111


@pytest.fixture
def scene():
    """A wall to the east, which the vehicle faces."""
    wall = thing(1, "container", (WALL_M + 0.5, 0.0, 5.0), (1.0, 30.0, 10.0))
    return replace(empty_scene(), objects=(replace(wall, scene_id="handmade"),))


def nearest_m(bench, seconds):
    """Least distance from the wall within some seconds."""
    nearest_m = WALL_M

    def watch():
        nonlocal nearest_m
        nearest_m = min(nearest_m, WALL_M - bench.plant.truth.position_enu_m[0])

    bench.observers.append(watch)
    bench.run(seconds)
    return nearest_m


@pytest.mark.parametrize("real", [pytest.param(PX4, marks=needs(PX4))])
def test_px4_by_its_collision_prevention(real, scene):
    with Testbench(scene, real.cfg(autopilot_binary=real.binary)) as bench:
        pilot = Pilot(bench, real)
        client, system = pilot.client, pilot.client.telemetry.system_id
        kind = mavlink.MAV_PARAM_TYPE_REAL32
        client._send(mavlink.MAVLink_param_set_message(system, 1, b"CP_DIST", PX4_MARGIN_M, kind))
        pilot.take_off()
        ahead = 0

        def push():
            client._send(mavlink.MAVLink_manual_control_message(system, ahead, 0, MIDDLE, 0, 0))

        bench.observers.append(push)
        bench.run(1.0)
        pilot.demand(mavlink.MAV_CMD_DO_SET_MODE, 1, POSITION_MODE)
        # Without a report of obstacles it would not move at all: CP_GO_NO_DATA is 0.
        ahead = FULL_AHEAD
        assert nearest_m(bench, 20.0) == pytest.approx(PX4_MARGIN_M, abs=1.0)
        assert bench.external.reports.mode.value == "Position"


@pytest.mark.parametrize("real", [pytest.param(ARDUCOPTER, marks=needs(ARDUCOPTER))])
def test_arducopter_by_its_avoidance(real, scene, monkeypatch):
    usual = ardupilot.parameters
    monkeypatch.setattr(ardupilot, "parameters", lambda a: usual(a) | {"PRX1_TYPE": BY_MAVLINK})
    with Testbench(scene, real.cfg(autopilot_binary=real.binary)) as bench:
        pilot = Pilot(bench, real)
        client, system = pilot.client, pilot.client.telemetry.system_id
        pilot.take_off()
        east = (0.0, SPEED_MPS, 0.0)

        def push():
            client._send(
                mavlink.MAVLink_set_position_target_local_ned_message(
                    *(bench.plant.time_us // 1000, system, 1, mavlink.MAV_FRAME_LOCAL_NED),
                    *(VELOCITY_ALONE, 0, 0, 0, *east, 0, 0, 0, 0, 0),
                )
            )

        bench.observers.append(push)
        least_m, most_m = ARDUCOPTER_M
        assert least_m < nearest_m(bench, 20.0) < most_m
        assert least_m < WALL_M - bench.plant.truth.position_enu_m[0] < most_m
        assert bench.external.reports.mode.value == "GUIDED"
