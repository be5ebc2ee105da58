"""Scores: contacts, touchdown, resting place, rotors and errors, from the history alone."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.trials.bounds import is_over_area
from scenarios.trials.contacts import Contact
from scenarios.trials.figures import Goal
from scenarios.trials.measures.estimation import rotation_angle_rad
from scenarios.trials.result import figures
from scenarios.trials.score import score_flight
from tests.scenarios.trials.histories import AIR, AREA, BESIDE, HOVER, LANDED, LEG_M, START, flight

IRIS = AIRFRAMES["iris"]
GOAL = Goal(area=AREA, chosen_enu_m=(10.0, 0.0, 2.0))


def score(*segments, goal=GOAL, **options):
    return score_flight(flight(*segments, **options), IRIS, goal)


GOOD = ((1, START, 1), (5, AIR, 0), (2, LANDED, 1))


def test_a_good_landing_has_no_contact_before_touchdown():
    found = score(*GOOD)
    assert found.has_flown
    assert found.is_down
    assert found.lift_off_s == pytest.approx(1.0, abs=0.01)
    assert found.touchdown_s == pytest.approx(6.0, abs=0.01)
    assert found.landed_area == AREA.id
    assert found.n_soles_inside == 4
    assert found.contacts_before_touchdown == 0
    assert found.touchdown_error_m == pytest.approx(math.hypot(0.2, 0.1))
    assert found.is_at_rest
    assert found.slide_m == 0.0


def test_without_a_choice_the_error_is_that_from_the_centroid():
    assert score(*GOOD, goal=Goal(area=AREA)).touchdown_error_m == pytest.approx(
        math.hypot(0.2, 0.1)
    )
    away = Goal(area=AREA, chosen_enu_m=(10.2, 0.4, 2.0))
    assert score(*GOOD, goal=away).touchdown_error_m == pytest.approx(0.3)
    beside = Goal(area=AREA, chosen_enu_m=(11.1, 0.1, 2.0))
    assert score(*GOOD, goal=beside).touchdown_error_m == pytest.approx(math.hypot(0.2, 0.1))


def test_brushing_a_tree_on_the_way_counts_once_however_it_rattles():
    rattle = [(0.02, AIR, i % 2) for i in range(8)]
    assert score(GOOD[0], GOOD[1], *rattle, GOOD[1], GOOD[2]).contacts_before_touchdown == 1


def test_two_brushes_apart_count_twice():
    brush = (0.02, AIR, 1)
    found = score(GOOD[0], GOOD[1], brush, GOOD[1], brush, *GOOD[1:])
    assert found.contacts_before_touchdown == 2


def test_a_bounce_after_touchdown_is_no_contact_before_it():
    above = (*LANDED[:2], LANDED[2] + 0.02)
    found = score(*GOOD[:2], (0.1, LANDED, 1), (0.3, above, 0), (1, LANDED, 1))
    assert found.contacts_before_touchdown == 0
    assert found.landed_area == AREA.id
    assert found.touchdown_s == pytest.approx(6.0, abs=0.01)


@pytest.mark.parametrize("place", [(12.0, 0.0, 2.1), (10.0, 0.0, 0.1), (10.0, 0.0, 3.0)])
def test_resting_beside_below_or_above_the_area_is_not_inside(place):
    found = score(*GOOD[:2], (1, place, 1))
    assert found.is_down
    assert found.landed_area is None
    assert found.n_soles_inside == 0


def test_one_sole_over_the_edge_is_told():
    # The soles of an Iris stand 0.13 m ahead and behind, 0.20 and 0.22 m aside.
    found = score(*GOOD[:2], (1, (10.95, 0.0, 2.0 + LEG_M), 1))
    assert found.landed_area is None
    assert found.n_soles_inside == 2


def test_soles_turn_with_the_vehicle():
    at = (10.0, 0.85, 2.0 + LEG_M)
    half = math.sqrt(0.5)
    assert score(*GOOD[:2], (1, at, 1)).n_soles_inside == 2
    assert score(*GOOD[:2], (1, at, 1), quat_wxyz=(half, 0.0, 0.0, half)).n_soles_inside == 4


def test_another_area_is_named():
    found = score(
        *GOOD[:2], (1, (14.0, 0.0, 0.0 + LEG_M), 1), goal=Goal(area=AREA, others=[BESIDE])
    )
    assert found.landed_area == BESIDE.id
    assert found.n_soles_inside == 0
    assert found.touchdown_error_m == pytest.approx(4.0)


def test_a_flight_that_ends_in_the_air_has_no_touchdown():
    found = score(*GOOD, (1, AIR, 0))
    assert not found.is_down
    assert found.landed_area is None
    assert found.touchdown_error_m is None
    assert found.rotor_spin_ups == 0


def test_a_flight_has_navigated_once_it_was_above_the_area_with_no_contact_before():
    found = score(*GOOD[:2], (1, (10.5, 0.5, 6.0), 0), GOOD[2])
    assert found.reached_s == pytest.approx(6.0, abs=0.01)
    for place in ((10.0, 0.0, 1.0), (10.0, 0.0, 7.5), (12.0, 0.0, 4.0)):
        assert score(GOOD[0], (5, place, 0)).reached_s is None
    for time_s, is_fine in ((2.0, False), (7.0, True)):
        touch = Contact(
            time_s=time_s, until_s=time_s, what="", object_id=None, position_enu_m=(0.0, 0.0, 0.0)
        )
        touched = dataclasses.replace(found, contacts=(touch,))
        assert figures(touched, AREA)["navigated"] is is_fine
    assert figures(score(GOOD[0]), AREA)["navigated"] is False
    assert figures(found, None)["navigated"] is None


def test_the_speed_of_the_touchdown_is_that_before_the_first_contact():
    history = flight(*GOOD)
    history["velocity_true_enu_mps"][1490:1500] = (0.3, 0.0, -0.4)
    assert score_flight(history, IRIS, GOAL).touchdown_speed_mps == pytest.approx(0.5)
    history["velocity_true_enu_mps"][1490:1500] = 0.0
    history["velocity_true_enu_mps"][1500] = (0.3, 0.0, -0.4)
    assert score_flight(history, IRIS, GOAL).touchdown_speed_mps == 0.0


def test_a_slide_is_the_farthest_that_it_got():
    there = (LANDED[0] + 0.4, *LANDED[1:])
    assert score(*GOOD[:2], (1, LANDED, 1), (1, there, 1), (1, LANDED, 1)).slide_m == pytest.approx(
        0.4
    )


def test_rest_is_judged_by_the_last_half_second():
    history = flight(*GOOD)
    history["velocity_true_enu_mps"][-200] = (0.0, 0.2, 0.0)
    assert score_flight(history, IRIS, GOAL).is_at_rest
    history["velocity_true_enu_mps"][-100] = (0.0, 0.2, 0.0)
    assert not score_flight(history, IRIS, GOAL).is_at_rest


@pytest.mark.parametrize(
    ("shares", "n", "stopped_after_s"),
    [
        ((1.0, 0.0), 0, 0.996),
        ((1.0, 0.16, 0.0), 0, 1.996),
        ((1.0, 0.16, 0.9, 0.0), 1, 2.996),
        ((1.0, 0.16, 0.9, 0.16, 0.9, 0.0), 2, 4.996),
        # Less than half of the speed of hover carries a fifth of the weight.
        ((1.0, 0.16, 0.45, 0.0), 0, 2.996),
        # It was never unloaded before.
        ((1.0, 0.65, 1.0, 0.0), 0, 2.996),
        ((1.0, 0.16), 0, None),
        ((0.0, 0.9), 1, None),
    ],
)
def test_rotors_that_take_the_weight_again_have_spun_up(shares, n, stopped_after_s):
    rotors = [(1, LANDED, 1, share * HOVER) for share in shares]
    found = score(*GOOD[:2], *rotors)
    assert found.rotor_spin_ups == n
    assert found.stopped_after_s == (
        None if stopped_after_s is None else pytest.approx(stopped_after_s)
    )


def test_a_vehicle_that_never_leaves_the_ground_has_not_flown():
    assert not score((3, START, 1)).has_flown


def test_errors_count_from_arming_on():
    history = flight(*GOOD)
    history["setpoint_level"][:250] = 0
    history["position_est_enu_m"][:250] += 100.0
    history["position_est_enu_m"][250:] += (0.3, 0.0, 0.4)
    assert score_flight(history, IRIS, GOAL).position_rmse_m == pytest.approx(0.5)


def test_a_flight_that_never_armed_has_no_errors():
    history = flight((1, START, 1))
    history["setpoint_level"] = 0
    assert math.isnan(score_flight(history, IRIS, GOAL).position_rmse_m)


@given(st.floats(1e-7, math.pi), st.integers(0, 2**32 - 1))
def test_rotation_angle_agrees_with_scipy_even_where_it_is_tiny(angle_rad, seed):
    a = Rotation.random(rng=seed)
    axis = Rotation.random(rng=seed + 1).apply([1.0, 0.0, 0.0])
    b = a * Rotation.from_rotvec(angle_rad * axis)
    quats = [r.as_quat(scalar_first=True)[None] for r in (a, b)]
    assert rotation_angle_rad(*quats)[0] == pytest.approx(angle_rad, rel=1e-6, abs=1e-9)


def test_a_sloping_area_tolerates_heights_that_its_slope_explains():
    slope = dataclasses.replace(AREA, slope_rad=0.2)
    point = np.array([[10.9, 0.0, 2.3]])
    assert is_over_area(point, slope)[0]
    assert not is_over_area(point, AREA)[0]
