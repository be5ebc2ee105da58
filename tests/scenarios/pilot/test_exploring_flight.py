"""The whole stack where nobody gave the pilot a map: it flies by what it sees."""

import numpy as np
import pytest

from flightsim.mavlink.client.client import MavlinkClient
from flightsim.sensors.cameras import Cameras
from flightsim.sensors.cameras.depth_noise import depth_noise
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.mission.mission import plan_mission
from scenarios.pilot import Phase, Pilot, PilotCfg
from scenarios.trials.flight_log import FlightLog
from scenarios.trials.score import Goal
from tests.scenarios.landing_scenes import ON_CONTAINER, yard

KINDS = {
    "sure": TestbenchCfg(speed="max"),
    "a poor receiver": TestbenchCfg(speed="max", gnss="standard"),
    "a camera that errs": TestbenchCfg(speed="max", depth_camera="d435"),
}


@pytest.mark.parametrize("cfg", KINDS.values(), ids=KINDS)
def test_a_container_that_nobody_told_of_is_seen_and_landed_on(cfg):
    bench = Testbench(yard(), cfg, has_network=False)
    with bench:
        noise = depth_noise(cfg.depth_camera, cfg.seed, "yard")
        cameras = Cameras(bench.plant, depth_noise=noise)
        mission = plan_mission(yard(), bench.airframe, area=ON_CONTAINER, map_source="onboard")
        world = mission.surroundings
        hover = np.array(mission.hover_enu_m)
        assert world.field.distance_m[tuple(world.field.cells(hover))] == 0.0
        client = MavlinkClient(bench.pilot_link.client, bench.frame)
        pilot = Pilot(client, mission, cameras.render, PilotCfg())
        log = FlightLog(bench.plant)
        bench.observers += [log.on_tick, lambda: pilot.update(bench.plant.time_us)]
        bench.simulator.run(until_us=round(90e6), stop=lambda: pilot.is_done)
        score = log.score(Goal(area=pilot.area, chosen_enu_m=pilot.touchdown_enu_m))
        cameras.close()
    assert pilot.phase is Phase.DONE
    assert score.contacts_before_touchdown == 0
    assert score.touchdown_error_m is not None
    # A receiver of 1.3 m that nothing ties to the map lands 1.6 m off.
    assert score.touchdown_error_m < (0.3 if cfg.gnss == "rtk" else 1.2)
    assert world.field.distance_m[tuple(world.field.cells(hover))] > world.radius_m
    assert all(change.target is not Phase.HAND_OVER for change in pilot.transitions)
