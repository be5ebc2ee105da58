"""Scoring: contacts, resting place and errors are judged from the history alone."""

import hashlib
import math
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aeroscene.scene import InteractionArea
from autonomy.types import ControlLevel
from flightsim.plant.record import HISTORY_DTYPE
from scenarios.run.scoring import (
    FlightLog,
    FlightTally,
    is_over_area,
    rotation_angle_rad,
    score_flight,
)

LEG_M = 0.1
TICK_US = 4_000

AREA = InteractionArea(
    id=3,
    object_id=None,
    polygon=((9.0, -1.0, 2.0), (11.0, -1.0, 2.0), (11.0, 1.0, 2.0), (9.0, 1.0, 2.0)),
    centroid=(10.0, 0.0, 2.0),
    radius=1.0,
    drone_class="medium",
    slope_rad=0.0,
    clearance_m=20.0,
    surface="concrete",
)


def flight(*segments):
    """A history of (seconds, position, is_touching) segments, each at rest."""
    rows = [np.zeros(round(s * 1e6) // TICK_US, HISTORY_DTYPE) for s, _, _ in segments]
    for part, (_, position, is_touching) in zip(rows, segments, strict=True):
        part["position_true_enu_m"] = part["position_est_enu_m"] = position
        part["is_touching"] = is_touching
    history = np.concatenate(rows)
    history["time_us"] = np.arange(1, len(history) + 1) * TICK_US
    history["quat_true_wxyz"] = history["quat_est_wxyz"] = (1, 0, 0, 0)
    history["setpoint_level"] = ControlLevel.TRAJECTORY
    return history


START, AIR = (0.0, 0.0, LEG_M), (5.0, 0.0, 8.0)
LANDED = (10.2, 0.1, 2.0 + LEG_M)
GOOD = ((1, START, 1), (5, AIR, 0), (1, LANDED, 1))


def test_a_good_landing_has_no_contact_before_touchdown():
    score = score_flight(flight(*GOOD), AREA, (10.0, 0.0, 2.0), LEG_M)
    assert score.has_flown
    assert score.has_touched_area
    assert score.is_inside_area
    assert score.contacts_before_touchdown == 0
    assert score.touchdown_error_m == pytest.approx(math.hypot(0.2, 0.1))


def test_brushing_a_tree_on_the_way_counts_once_however_it_rattles():
    rattle = [(0.02, AIR, i % 2) for i in range(8)]
    score = score_flight(flight(GOOD[0], GOOD[1], *rattle, GOOD[1], GOOD[2]), AREA, None, LEG_M)
    assert score.contacts_before_touchdown == 1


def test_two_brushes_apart_count_twice():
    brush = (0.02, AIR, 1)
    score = score_flight(
        flight(GOOD[0], GOOD[1], brush, GOOD[1], brush, *GOOD[1:]), AREA, None, LEG_M
    )
    assert score.contacts_before_touchdown == 2


def test_a_bounce_after_touchdown_is_no_contact_before_it():
    bounce = ((0.1, LANDED, 1), (0.3, (10.2, 0.1, 2.0 + LEG_M + 0.02), 0), (1, LANDED, 1))
    score = score_flight(flight(*GOOD[:2], *bounce), AREA, None, LEG_M)
    assert score.contacts_before_touchdown == 0
    assert score.is_inside_area


@pytest.mark.parametrize("place", [(12.0, 0.0, 2.1), (10.0, 0.0, 0.1), (10.0, 0.0, 3.0)])
def test_resting_beside_below_or_above_the_area_is_not_inside(place):
    score = score_flight(flight(*GOOD[:2], (1, place, 1)), AREA, None, LEG_M)
    assert not score.is_inside_area
    assert not score.has_touched_area


def test_a_vehicle_that_never_leaves_the_ground_has_not_flown():
    assert not score_flight(flight((3, START, 1)), AREA, None, LEG_M).has_flown


def test_errors_count_from_arming_on():
    history = flight(*GOOD)
    history["setpoint_level"][:250] = ControlLevel.OFF
    history["position_est_enu_m"][:250] += 100.0
    history["position_est_enu_m"][250:] += (0.3, 0.0, 0.4)
    assert score_flight(history, AREA, None, LEG_M).position_rmse_m == pytest.approx(0.5)


def test_a_flight_that_never_armed_has_no_errors():
    history = flight((1, START, 1))
    history["setpoint_level"] = ControlLevel.OFF
    assert math.isnan(score_flight(history, AREA, None, LEG_M).position_rmse_m)


@given(st.floats(1e-7, math.pi), st.integers(0, 2**32 - 1))
def test_rotation_angle_agrees_with_scipy_even_where_it_is_tiny(angle_rad, seed):
    a = Rotation.random(rng=seed)
    axis = Rotation.random(rng=seed + 1).apply([1.0, 0.0, 0.0])
    b = a * Rotation.from_rotvec(angle_rad * axis)
    quats = [r.as_quat(scalar_first=True)[None] for r in (a, b)]
    assert rotation_angle_rad(*quats)[0] == pytest.approx(angle_rad, rel=1e-6, abs=1e-9)


def test_a_sloping_area_tolerates_heights_that_its_slope_explains():
    slope = InteractionArea(
        **{name: getattr(AREA, name) for name in AREA.__slots__} | {"slope_rad": 0.2}
    )
    point = np.array([[10.9, 0.0, 2.3]])
    assert is_over_area(point, slope)[0]
    assert not is_over_area(point, AREA)[0]


@given(st.lists(st.integers(2, 400), max_size=12), st.integers(0, 2**32 - 1))
def test_a_flight_is_judged_alike_however_it_is_cut(lengths, seed):
    rng = np.random.default_rng(seed)
    brush = (0.02, AIR, 1)
    history = flight(GOOD[0], GOOD[1], brush, GOOD[1], brush, *GOOD[1:])
    history["position_est_enu_m"] += rng.normal(size=(len(history), 3))
    tally, start = FlightTally(), 0
    for length in [*lengths, len(history)]:
        if start < len(history):
            tally.add(history[start : start + length])
            start += length
    whole = score_flight(history, AREA, (10.0, 0.0, 2.0), LEG_M)
    cut = tally.score(AREA, (10.0, 0.0, 2.0), LEG_M)
    assert whole.contacts_before_touchdown == 2
    assert cut.position_rmse_m == pytest.approx(whole.position_rmse_m, rel=1e-12)
    for name in ("has_flown", "contacts_before_touchdown", "is_inside_area", "touchdown_error_m"):
        assert getattr(cut, name) == getattr(whole, name)


def test_the_hash_is_that_of_every_row():
    history = flight(*GOOD)
    plant = SimpleNamespace(history=history[:5])
    log = FlightLog(plant)
    for start in range(0, len(history), 5):
        plant.history = history[start : start + 5]
        log.on_tick()
        if start == 400:
            log.state_hash()  # Asking for it in between changes nothing.
    assert log.state_hash() == hashlib.blake2b(history.tobytes(), digest_size=16).hexdigest()


def test_a_flight_that_is_not_judged_takes_no_more_memory_the_longer_it_lasts():
    air, ground = (flight((2, AIR, 0))[:5], flight((2, START, 1))[:5])
    plant = SimpleNamespace(history=air)
    log = FlightLog(plant, is_judged=False)

    def tick(count):
        for index in range(count):
            plant.history = ground if index % 100 > 50 else air
            log.on_tick()

    tick(1000)
    tracemalloc.start()
    tick(5000)
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert grown < 300_000  # A hundred seconds of rows are 10 MB or more.
