"""Where the vehicle looks: as far aside as somebody may come from, within its limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.planning import FlightLimits
from autonomy.types import FlatReference
from scenarios.pilot.gaze import MOVER_SPEED_MPS, Gaze, danger_rad

LIMITS = FlightLimits()
STEP_US = 20_000


def headings(gaze, seconds, speed_mps, course_rad=0.0, *, looks_around=True, since_us=0):
    """Yaw of each setpoint, eastwards at a speed."""
    setpoint = FlatReference(position_enu_m=(0.0, 0.0, 5.0), velocity_enu_mps=(speed_mps, 0.0, 0.0))
    times = since_us + STEP_US * np.arange(round(seconds * 50) + 1)
    turns = [gaze.turn(t, setpoint, course_rad, looks_around=looks_around) for t in times.tolist()]
    return np.array([turn.yaw_rad for turn in turns])


@given(st.floats(0.1, 8.0), st.floats(0.1, MOVER_SPEED_MPS), st.floats(-math.pi, math.pi))
def test_nobody_who_meets_the_vehicle_comes_from_farther_aside(speed, other, heading):
    relative = np.subtract((speed, 0.0), (other * math.cos(heading), other * math.sin(heading)))
    bearing = abs(math.atan2(relative[1], relative[0]))
    assert bearing <= danger_rad(speed) + 1e-9 or math.hypot(*relative) < 1e-9


@pytest.mark.parametrize(("speed_mps", "aside_deg"), [(1.0, 60.0), (2.9, 60.0), (4.0, 18.6)])
def test_in_flight_it_turns_to_and_fro_as_far_as_it_must(speed_mps, aside_deg):
    yaw = np.degrees(headings(Gaze(LIMITS), 12.0, speed_mps))
    assert yaw.max() == pytest.approx(aside_deg, abs=4.0)
    assert yaw.min() == pytest.approx(-aside_deg, abs=4.0)
    # Either side again within five seconds.
    right = np.flatnonzero(yaw < -0.8 * aside_deg) / 50
    assert np.diff(right).max() < 5.0


def test_where_it_stands_it_turns_all_round_in_time():
    gaze = Gaze(LIMITS)
    assert not gaze.has_looked_round(0)
    yaw = headings(gaze, 4.5, 0.0, None)
    assert np.ptp(yaw) > math.radians(285.0)
    assert gaze.has_looked_round(4_500_000)
    # A next look around is one of its own.
    assert not gaze.has_looked_round(4_500_000)


def test_a_look_around_ends_where_something_holds_its_gaze():
    gaze = Gaze(LIMITS)
    gaze.kept_rad = 1.0
    assert not gaze.has_looked_round(0)
    headings(gaze, 8.1, 0.0, None)
    assert gaze.has_looked_round(8_100_000)


def test_it_keeps_to_what_is_to_be_kept_in_view_and_looks_ahead_where_it_must_not_look_around():
    gaze = Gaze(LIMITS)
    headings(gaze, 1.0, 2.0)
    assert gaze.is_on_it
    gaze.kept_rad = 2.5
    assert not gaze.is_on_it
    kept = headings(gaze, 4.0, 2.0, since_us=1_000_000)
    assert math.remainder(kept[-1] - 2.5, math.tau) == pytest.approx(0.0, abs=0.01)
    assert gaze.is_on_it
    ahead = headings(gaze, 5.0, 2.0, looks_around=False, since_us=5_000_000)
    assert math.remainder(ahead[-1], math.tau) == pytest.approx(0.0, abs=0.01)


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(0.0, 6.0), st.booleans(), st.booleans()), max_size=6))
def test_it_turns_no_faster_than_the_motion_allows(stretches):
    gaze, time_us, yaw = Gaze(LIMITS), 0, []
    for speed, looks_around, stands in stretches:
        course = None if stands else 1.0
        yaw.append(
            headings(gaze, 1.0, speed, course, looks_around=looks_around, since_us=time_us)[:-1]
        )
        time_us += 1_000_000
    rate = np.diff(np.concatenate([*yaw, []])) * 50
    assert np.all(np.abs(rate) <= LIMITS.yaw_rate_radps + 1e-9)
    assert np.all(np.abs(np.diff(rate)) * 50 <= LIMITS.yaw_acceleration_radps2 + 1e-6)
