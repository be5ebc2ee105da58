"""Tracking error of a recorded flight: by the planned path of the moment."""

import measure_tracking
import numpy as np
import pytest
from judging.recording import Plan, Recording

SPEED_MPS = 2.0


@pytest.fixture
def flight():
    """Along x, and half way along y instead, by a second plan."""
    time_s = np.arange(0.0, 12.0, 0.02)
    x_m = SPEED_MPS * np.clip(time_s - 1.0, 0.0, 2.0)
    y_m = SPEED_MPS * np.clip(time_s - 3.0, 0.0, 4.0)
    turn = np.array([2.0 * SPEED_MPS, 0.0, 0.0])
    ahead = np.linspace([0.0, 0.0, 0.0], [4.0 * SPEED_MPS, 0.0, 0.0], 9)
    aside = np.linspace(turn, turn + [0.0, 4.0 * SPEED_MPS, 0.0], 5)
    return Recording(
        time_s=time_s,
        position_enu_m=np.column_stack([x_m, y_m, 0.0 * time_s]),
        plans=[Plan(1.0, 4.0, ahead), Plan(3.0, 4.0, aside)],
    )


def test_who_flies_each_plan_while_it_holds_has_no_error(flight):
    errors_m = measure_tracking.tracking_errors_m(flight)
    assert len(errors_m) == pytest.approx(6.0 / 0.02, abs=2)
    assert errors_m.max() < 1e-9


def test_an_offset_counts_and_a_lag_does_not(flight):
    flight.position_enu_m += [0.0, 0.0, 0.3]
    assert measure_tracking.tracking_errors_m(flight) == pytest.approx(0.3)
    flight.position_enu_m -= [0.0, 0.0, 0.3]
    late = np.maximum(np.arange(len(flight.time_s)) - 5, 0)  # 0.1 s
    flight.position_enu_m = flight.position_enu_m[late]
    assert np.median(measure_tracking.tracking_errors_m(flight)) < 1e-9


def test_a_plan_that_is_only_shown_does_not_count(flight):
    flight.plans[0] = Plan(1.0, 4.0, flight.plans[0].points_enu_m + [0.0, 0.0, 2.0])
    assert len(measure_tracking.tracking_errors_m(flight)) == pytest.approx(4.0 / 0.02, abs=2)
