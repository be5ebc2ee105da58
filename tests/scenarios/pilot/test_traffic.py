"""What moves in the way is seen from on board and evaded; without eyes for it, it is met."""

import numpy as np
import pytest

from autonomy.planning import MovingObstacles
from autonomy.types import FlatReference
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.mission import plan_mission
from scenarios.pilot import Phase
from scenarios.pilot.movers import room_to_movers_m
from scenarios.pilot.pace import AMONG_MOVERS
from tests.scenarios.landing_scenes import FAR_LAWN, ON_CONTAINER, field, yard
from tests.scenarios.pilot.crossing import crosser

LOOKED_S = 13.5
"""When a pilot in the yard sets out that rises and looks around before."""
VEHICLE_M = 0.38


@pytest.fixture(scope="module")
def plan():
    return plan_mission(field(), AIRFRAMES["iris"], area=FAR_LAWN).trajectory


@pytest.fixture(scope="module")
def level():
    """The way in the yard from as high above the start as the way leads."""
    limits = AMONG_MOVERS.limits
    mission = plan_mission(yard(), AIRFRAMES["iris"], area=ON_CONTAINER, limits=limits)
    x, y, _ = mission.takeoff_enu_m
    top = FlatReference(position_enu_m=(x, y, mission.hover_enu_m[2]))
    return mission.surroundings.plan(top, mission.hover_enu_m)


def test_a_pilot_that_looks_out_rises_first_and_looks_around(demo):
    demo = demo(yard(), expects_traffic=True)
    yaw = []
    demo.fly(until=lambda: yaw.append(demo.bench.plant.truth) or demo.pilot.phase is Phase.NAVIGATE)
    heights = np.array([truth.position_enu_m[2] for truth in yaw])
    assert heights[-1] == pytest.approx(demo.mission.hover_enu_m[2], abs=0.1)
    w, x, y, z = np.array([truth.quat_wxyz for truth in yaw[:: max(len(yaw) // 400, 1)]]).T
    heading = np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    assert np.ptp(heading) > np.radians(285.0)


@pytest.mark.parametrize(
    ("share", "speed_mps", "angle_deg"), [(0.51, 1.8, 96.0), (0.58, 2.9, -145.0)]
)
def test_somebody_who_crosses_the_plan_is_evaded(demo, level, share, speed_mps, angle_deg):
    other = crosser(level, LOOKED_S, share, speed_mps, angle_deg=angle_deg)
    demo = demo(yard(), ON_CONTAINER, traffic=[other])
    pilot = demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert demo.score().contacts_before_touchdown == 0
    assert demo.gap_m > VEHICLE_M + 0.3
    changes = [replan.reason for replan in pilot.replans]
    changes += [change.reason for change in pilot.transitions if change.target is Phase.HOLD]
    assert any("something that moves would come within" in reason for reason in changes)


def test_a_pilot_that_does_not_look_out_meets_them(demo):
    # Else the tests above would show nothing.
    alone = demo(field(), FAR_LAWN)
    begin_s = alone.fly_to(Phase.NAVIGATE)._flight.take_over_us * 1e-6
    other = crosser(alone.pilot.trajectory, begin_s, 0.5, 2.0)
    demo = demo(field(), FAR_LAWN, traffic=[other], expects_traffic=False)
    demo.fly(until=lambda: demo.gap_m < VEHICLE_M, limit_s=20.0)
    assert demo.gap_m < VEHICLE_M


def test_room_to_what_moves_is_that_of_the_moment(plan):
    middle = plan.duration_s / 2
    there = plan.positions(np.array([middle]))
    still = np.zeros((1, 3))
    standing = MovingObstacles.balls(there, still, np.array([0.5]), growth_mps=0.0)
    assert room_to_movers_m(plan, middle - 2.0, standing, 0.4) == pytest.approx(-0.9, abs=0.2)
    # By the time that it is far gone, or before the predictions reach so far, there is room.
    assert room_to_movers_m(plan, plan.duration_s, standing, 0.4) > 5.0
    assert room_to_movers_m(plan, middle - 8.0, standing, 0.4) > 1.0
    none = MovingObstacles.balls(still[:0], still[:0], np.zeros(0))
    assert room_to_movers_m(plan, 0.0, none, 0.4) == np.inf
