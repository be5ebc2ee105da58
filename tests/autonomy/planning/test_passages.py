"""Doors hardly wider than the vehicle are flown through, wherever cells lie in them."""

import pytest

from autonomy.planning import (
    Craft,
    FlightLimits,
    PlannerCfg,
    UnreachableError,
    certify,
    plan_trajectory,
)
from autonomy.planning.openings import opening_at
from autonomy.types import FlatReference
from tests.autonomy.planning.test_openings import room_with
from tests.autonomy.planning_worlds import field_of, quadrotor

RADIUS_M = 0.35
CFG = PlannerCfg(vehicle_radius_m=RADIUS_M, min_margin_m=0.02)
LIMITS = FlightLimits()
OFFSETS_M = (0.0, 0.06, 0.125, 0.19)
"""Offsets of the door's centre from the cells, whose edge is 0.25 m."""


def plan(world, at):
    field = field_of(world, half_extent=4.5, height=3.5, resolution=0.25)
    start = FlatReference(position_enu_m=(at + 0.5, -3.0, 1.3))
    goal = (at - 0.5, 3.0, 1.3)
    return plan_trajectory(start, goal, field, world, Craft(LIMITS, quadrotor(), CFG))


@pytest.mark.parametrize("at", OFFSETS_M)
def test_a_door_a_tenth_wider_than_the_sphere_is_passed(at):
    world = room_with(at, 2 * RADIUS_M + 0.1, 0.0, 2.2, 0.0)
    way = plan(world, at)
    proof = certify(way, world, RADIUS_M, LIMITS, quadrotor(), margin_m=0.02)
    assert proof.min_clearance_m < 0.06


def test_a_door_narrower_than_the_sphere_is_refused():
    world = room_with(0.0, 2 * RADIUS_M - 0.02, 0.0, 2.2, 0.0)
    with pytest.raises(UnreachableError, match=r"opening there is 0\.68 m wide") as raised:
        plan(world, 0.0)
    assert raised.value.narrowest_enu_m is not None


@pytest.mark.parametrize("beside", [-0.2, 0.0, 0.2])
def test_an_opening_is_measured_from_a_place_in_or_beside_it(beside):
    world = room_with(0.3, 1.2, 0.0, 2.1, 0.0)
    found = opening_at((0.4, beside, 1.0), world)
    assert found is not None
    assert found.width_m == pytest.approx(1.2, abs=0.02)
    assert found.center_enu_m[0] == pytest.approx(0.3, abs=0.02)
    assert opening_at((0.0, -3.0, 2.0), world) is None
