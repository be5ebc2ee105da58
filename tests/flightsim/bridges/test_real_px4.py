"""What the real PX4 sees by our sensors; it flies where AEROSCENE_PX4 names a binary."""

from dataclasses import replace

import pytest

from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.testbench import Testbench
from tests.flightsim.bridges.real import PX4, Pilot, needs
from tests.flightsim.handmade import empty_scene
from tests.scenarios.landing_scenes import thing

pytestmark = needs(PX4)
POSITION_MODE = 3
FULL_AHEAD, MIDDLE = 1000, 500


def test_its_collision_prevention_stops_before_a_wall_that_our_ring_scan_shows():
    wall_m = 16.0
    wall = thing(1, "container", (wall_m + 0.5, 0.0, 5.0), (1.0, 30.0, 10.0))
    scene = replace(empty_scene(), objects=(replace(wall, scene_id="handmade"),))
    with Testbench(scene, PX4.cfg(autopilot_binary=PX4.binary)) as bench:
        pilot = Pilot(bench, PX4)
        client, system = pilot.client, pilot.client.telemetry.system_id
        client._send(
            mavlink.MAVLink_param_set_message(
                system, 1, b"CP_DIST", 4.0, mavlink.MAV_PARAM_TYPE_REAL32
            )
        )
        pilot.take_off()
        ahead = 0

        def push():
            client._send(mavlink.MAVLink_manual_control_message(system, ahead, 0, MIDDLE, 0, 0))

        bench.observers.append(push)
        bench.run(1.0)
        pilot.demand(mavlink.MAV_CMD_DO_SET_MODE, 1, POSITION_MODE)
        nearest_m = wall_m

        def watch():
            nonlocal nearest_m
            nearest_m = min(nearest_m, wall_m - bench.plant.truth.position_enu_m[0])

        bench.observers.append(watch)
        # Without a report of obstacles it would not move at all: CP_GO_NO_DATA is 0.
        ahead = FULL_AHEAD
        bench.run(20.0)
        assert bench.external.reports.mode.value == "Position"
        assert nearest_m == pytest.approx(4.0, abs=1.0)
