"""The whole stack where nobody gave the pilot a map: it flies by what it sees."""

import numpy as np
import pytest

from autonomy.planning import PlanningError
from flightsim.cameras import Cameras
from flightsim.cameras.depth_noise import depth_noise
from flightsim.mavlink.client.client import MavlinkClient
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.mission.mission import plan_mission
from scenarios.pilot import Phase, Pilot, PilotCfg
from scenarios.trials.figures import Goal
from scenarios.trials.flight_log import FlightLog
from tests.scenarios.landing_scenes import ON_CONTAINER, yard
from tests.thorough import THOROUGH

KINDS = {
    "sure": TestbenchCfg(speed="max"),
    "a poor receiver": TestbenchCfg(speed="max", gnss="standard"),
    "a camera that errs": TestbenchCfg(speed="max", depth_camera="d435"),
}


def fly(cfg, prepare=None, *, expects_traffic=False):
    """Flight to the container without a map: the pilot, its score, and the map that it made."""
    bench = Testbench(yard(), cfg, has_network=False)
    with bench:
        noise = depth_noise(cfg.depth_camera, cfg.seed, "yard")
        cameras = Cameras(bench.plant, depth_noise=noise)
        mission = plan_mission(yard(), bench.airframe, area=ON_CONTAINER, map_source="onboard")
        world = mission.surroundings
        hover = world.field.cells(np.array(mission.hover_enu_m))
        assert world.field.distance_m[tuple(hover)] == 0.0
        client = MavlinkClient(bench.stack.pipe(), bench.frame)
        brief = PilotCfg(expects_traffic=expects_traffic)
        pilot = Pilot(client, mission, cameras.render_depth, brief)
        if prepare is not None:
            prepare(pilot)
        log = FlightLog(bench.plant)
        bench.observers += [log.on_tick, lambda: pilot.update(bench.plant.time_us)]
        bench.simulator.run(until_us=round(90e6), stop=lambda: pilot.is_done)
        score = log.score(Goal(area=pilot.area, chosen_enu_m=pilot.touchdown_enu_m))
        cameras.close()
    assert world.field.distance_m[tuple(hover)] > world.radius_m
    return pilot, score


@pytest.mark.parametrize(
    "kind", [pytest.param("a poor receiver", marks=THOROUGH), "a camera that errs"]
)
def test_a_container_that_nobody_told_of_is_seen_and_landed_on(kind):
    cfg = KINDS[kind]
    pilot, score = fly(cfg)
    assert pilot.phase is Phase.DONE
    assert score.contacts_before_touchdown == 0
    assert score.touchdown_error_m is not None
    # A receiver of 1.3 m that nothing ties to the map lands 1.6 m off.
    assert score.touchdown_error_m < (0.3 if cfg.gnss == "rtk" else 1.2)
    assert all(change.target is not Phase.HAND_OVER for change in pilot.transitions)


def test_noise_in_the_way_down_is_looked_at_again():
    refused = []

    def refuse_twice(pilot):
        leg = pilot._flight.leg

        def refusing(to, *args, **kwargs):
            is_down = to[2] < pilot._flight.hover_enu_m[2] - 0.5
            if is_down and pilot.phase in {Phase.SEARCH, Phase.ALIGN} and len(refused) < 4:
                refused.append(to)
                raise PlanningError("something in the air")
            return leg(to, *args, **kwargs)

        pilot._flight.leg = refusing

    pilot, score = fly(KINDS["sure"], refuse_twice)
    again = [(change.source, change.target) for change in pilot.transitions]
    assert (Phase.ALIGN, Phase.SEARCH) in again
    assert all(target is not Phase.HAND_OVER for _, target in again)
    assert pilot.phase is Phase.DONE
    assert score.contacts_before_touchdown == 0
    assert score.touchdown_error_m < 0.3


def test_ground_that_comes_into_view_is_nothing_that_moves():
    pilot, score = fly(KINDS["sure"], expects_traffic=True)
    assert pilot.phase is Phase.DONE, pilot.verdict.reason
    assert Phase.HOLD not in {change.target for change in pilot.transitions}
    assert score.contacts_before_touchdown == 0
