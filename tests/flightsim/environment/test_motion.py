"""Movers on their paths: smooth, as fast as told, and where they are depends on time alone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightsim.environment.motion import new_movers, place_mover
from flightsim.environment.movers import MOVER_KINDS, MoverError, MovingObstacle
from flightsim.environment.paths import smooth_path

points = st.lists(
    st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(0, 3)), min_size=3, max_size=6
)
obstacles = st.builds(
    MovingObstacle,
    kind=st.sampled_from(["person", "car", "drone"]),
    path_enu_m=points.map(lambda p: ((30.0, 0.0, 0.0), *p)),
    speed_mps=st.floats(0.3, 5.0),
    is_loop=st.booleans(),
    phase=st.floats(0.0, 0.99),
)


def places(obstacle, times_s, rate=1.0):
    movers, control = new_movers([obstacle])
    rows = []
    for t in times_s:
        place_mover(movers[0], control, t, rate)
        rows.append((movers["position_enu_m"][0].copy(), movers["velocity_enu_mps"][0].copy()))
    position, velocity = (np.array(column) for column in zip(*rows, strict=True))
    return position, velocity


@given(obstacles, st.floats(0.0, 300.0))
@settings(max_examples=30)
def test_velocity_is_the_derivative_of_position_and_continuous(obstacle, start_s):
    h = 1e-3
    times = start_s + h * np.arange(400)
    position, velocity = places(obstacle, times)
    slope = (position[2:] - position[:-2]) / (2 * h)
    np.testing.assert_allclose(slope, velocity[1:-1], atol=0.05)
    # At a hairpin between half-metre pieces the direction reverses within one of them.
    assert np.abs(np.diff(velocity, axis=0)).max() < 0.1 + 8 * h * obstacle.speed_mps**2 / 0.25


@given(obstacles)
@settings(max_examples=30)
def test_nothing_is_faster_than_told(obstacle):
    _, velocity = places(obstacle, np.linspace(0.0, 120.0, 400))
    assert np.linalg.norm(velocity, axis=1).max() <= obstacle.speed_mps * (1 + 1e-9)


def test_to_and_fro_reaches_both_ends_and_rests_there():
    ends = ((0.0, 0.0, 0.0), (12.0, 0.0, 0.0))
    walker = MovingObstacle(kind="person", path_enu_m=ends, speed_mps=1.5)
    position, velocity = places(walker, np.arange(0.0, 60.0, 0.01))
    assert position[:, 0].min() == pytest.approx(0.0, abs=1e-6)
    assert position[:, 0].max() == pytest.approx(12.0, abs=1e-6)
    rests = np.abs(velocity[:, 0]) < 1e-9
    assert 2.0 < 0.01 * rests.sum() < 10.0
    acceleration = np.diff(velocity[:, 0]) / 0.01
    limit = MOVER_KINDS["person"].acceleration_mps2
    assert np.abs(acceleration).max() <= limit + 1e-6


def test_a_person_walks_face_first_and_a_car_reverses():
    ends = ((0.0, 0.0, 0.0), (10.0, 0.0, 0.0))
    facing = {}
    for kind in ("person", "car"):
        movers, control = new_movers([MovingObstacle(kind=kind, path_enu_m=ends, speed_mps=2.0)])
        yaws = set()
        for t in np.arange(0.0, 40.0, 0.05):
            place_mover(movers[0], control, t, 1.0)
            if movers["distance_rate_mps"][0] < -1.0:
                yaws.add(round(math.cos(movers["yaw_rad"][0])))
        facing[kind] = yaws
    assert facing == {"person": {-1}, "car": {1}}


def test_a_loop_comes_round():
    square = ((0.0, 0.0, 2.0), (8.0, 0.0, 2.0), (8.0, 8.0, 2.0), (0.0, 8.0, 2.0))
    drone = MovingObstacle(kind="drone", path_enu_m=square, speed_mps=2.0, is_loop=True)
    position, _ = places(drone, [0.0, 16.0, 32.0, 8.0])
    np.testing.assert_allclose(position[[1, 2]], position[[0, 0]], atol=1e-9)
    assert np.linalg.norm(position[3] - position[0]) > 10.0


def test_a_path_cuts_corners_by_less_than_a_third_of_a_metre():
    corner = ((0.0, 0.0, 0.0), (6.0, 0.0, 0.0), (6.0, 6.0, 0.0))
    path = smooth_path(corner, is_loop=False)
    points = path.sample(np.linspace(0.0, path.length_m, 500))
    gap = np.minimum(np.abs(points[:, 1]), np.abs(points[:, 0] - 6.0))
    assert gap.max() < 0.3
    np.testing.assert_allclose(points[[0, -1]], np.array(corner)[[0, -1]], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "valid"),
    [
        ({"kind": "dog"}, "valid: person, car, drone"),
        ({"path_enu_m": ((0.0, 0.0, 0.0),)}, "0.1 m or more"),
        ({"path_enu_m": ((0.0, 0.0, 0.0), (math.nan, 0.0, 0.0))}, "finite points"),
        ({"speed_mps": 0.0}, "above 0 and up to 20"),
        ({"phase": 1.0}, "below 1"),
    ],
)
def test_an_impossible_mover_is_refused_with_what_is_valid(change, valid):
    fine = {"kind": "person", "path_enu_m": ((0.0, 0.0, 0.0), (5.0, 0.0, 0.0)), "speed_mps": 1.0}
    with pytest.raises(MoverError, match=valid):
        MovingObstacle(**fine | change)
