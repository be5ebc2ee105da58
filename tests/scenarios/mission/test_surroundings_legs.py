"""Straight legs are proved like any plan; only what a vehicle stood on is not asked about."""

import numpy as np
import pytest

from autonomy.planning import CertificateError, MovingObstacles, PlanningError
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.surroundings import survey
from tests.scenarios.landing_scenes import yard

STANDING = (0.0, 0.0, 0.11)
UP = (0.0, 0.0, 2.5)


@pytest.fixture(scope="module")
def world():
    return survey(yard(), AIRFRAMES["iris"])


def test_the_way_up_needs_the_exemption_of_its_first_metre(world):
    with pytest.raises(CertificateError, match="clearance falls"):
        world.certified_leg(STANDING, UP, 0.3)
    leg = world.certified_leg(STANDING, UP, 0.3, exempt_m=1.0)
    assert leg.sample(0.0).position_enu_m == STANDING
    assert leg.min_clearance_m > world.planner.min_margin_m


def test_no_exemption_leads_through_a_container(world):
    on_top = (9.0, 0.0, 2.5 + 0.11)
    with pytest.raises(CertificateError, match="clearance falls"):
        world.certified_leg(on_top, (9.0, 0.0, 0.6), 0.0, exempt_m=1.0)
    with pytest.raises(CertificateError, match="clearance falls"):
        world.certified_leg((4.0, 0.0, 2.5), (9.0, 0.0, 2.5), 0.0, exempt_m=1.0)


def test_a_leg_waits_for_nobody_so_one_that_meets_somebody_is_refused(world):
    above = (0.0, 0.0, 6.0)
    ball = MovingObstacles.balls(
        np.array([[0.0, 0.0, 4.2]]), np.zeros((1, 3)), np.array([0.3]), growth_mps=0.0
    )
    world.certified_leg(UP, above, 0.0)
    with pytest.raises(PlanningError, match="moving obstacle 0"):
        world.certified_leg(UP, above, 0.0, moving=ball)


def test_a_stop_is_certified_and_stays_away_from_who_comes_along(world):
    leg = world.certified_leg(UP, (-8.0, 0.0, 2.5), 0.0)
    stop = world.brake(leg, leg.duration_s / 2)
    end = stop.sample(stop.duration_s)
    assert end.velocity_enu_mps == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    coming = MovingObstacles.balls(
        np.array([[-12.0, 0.0, 2.5]]), np.array([[3.0, 0.0, 0.0]]), np.array([0.3])
    )
    aside = world.brake(leg, leg.duration_s / 2, moving=coming)
    place = np.array(aside.sample(aside.duration_s).position_enu_m)
    assert np.linalg.norm(place[1:] - [0.0, 2.5]) > world.radius_m + 0.3


def test_a_stop_in_the_midst_of_what_moves_comes_no_nearer(world):
    leg = world.certified_leg(UP, (-8.0, 0.0, 2.5), 0.0)
    around = MovingObstacles.balls(np.array([[-4.0, 0.0, 2.5]]), np.zeros((1, 3)), np.array([6.0]))
    stop = world.brake(leg, leg.duration_s / 2, moving=around)
    times = np.linspace(0.0, stop.duration_s, 50)
    depth_m = around.distances(stop.positions(times), times)[0][0] + around.growth_mps * times
    assert depth_m[0] < 0.0
    assert depth_m.min() > depth_m[0] - 0.01
