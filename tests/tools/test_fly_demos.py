"""Medians that the demos' table is made of, and what a real stack's hover is measured against."""

import fly_demos
import fly_waypoints
import pytest

from flightsim.vehicles.catalogue import AIRFRAMES


def result(vehicle, error_m, *, success=True):
    row = dict.fromkeys(fly_demos.MEDIANS, 1.0)
    return row | {"vehicle": vehicle, "success": success, "touchdown_error_m": error_m}


def cells(table):
    return [list(column.cells) for column in table.columns]


def test_medians_are_of_the_flights_that_landed_for_each_vehicle():
    flown = [result("iris", 0.1), result("iris", 0.3), result("iris", 9.0, success=False)]
    vehicles, landed, errors, *_ = cells(fly_demos.medians([*flown, result("hummingbird", 0.5)]))
    assert vehicles == ["iris", "hummingbird"]
    assert landed == ["2 of 3", "1 of 1"]
    assert errors == ["0.2", "0.5"]


def test_a_figure_that_was_not_measured_is_none():
    row = result("iris", 0.1)
    del row["tracking_rmse_m"]
    place = 2 + list(fly_demos.MEDIANS).index("tracking_rmse_m")
    assert cells(fly_demos.medians([row]))[place] == ["-"]
    assert cells(fly_demos.medians([row, result("iris", 0.1)]))[place] == ["1"]
    assert cells(fly_demos.medians([result("iris", 0.1, success=False)]))[2] == ["-"]


def test_ardupilot_hovers_with_less_throttle_high_up_and_px4_does_not():
    iris = AIRFRAMES["iris"]
    low, high = (fly_waypoints.hover_throttle("ardupilot", iris, at_m) for at_m in (0.0, 488.0))
    assert high / low == pytest.approx(0.954, abs=1e-3)  # of the standard atmosphere
    assert fly_waypoints.hover_throttle("px4", iris, 488.0) == pytest.approx(
        iris.quadrotor.hover_thrust_fraction
    )
