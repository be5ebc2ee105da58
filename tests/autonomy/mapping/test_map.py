"""What is unknown: nothing in a map that was given, everything unseen in one that grows."""

import numpy as np
import pytest

from autonomy.mapping import GivenMap, SeenMap
from autonomy.planning import DistanceField, Obstacles
from tests.autonomy.depth_scene import box, look_down

LOW, HIGH = (-6.0, -6.0, 0.0), (14.0, 6.0, 6.0)
WALL = ((5.1, 0.0, 3.0), (0.2, 12.0, 6.0))
BEFORE, BEHIND = np.array([[3.0, 0.0, 2.0]]), np.array([[8.0, 0.0, 2.0]])


@pytest.fixture
def given():
    """All of a room that a wall divides; the start is before the wall."""
    walls = Obstacles.boxes(np.array([WALL[0]]), np.array([[1.0, 0, 0, 0]]), np.array([WALL[1]]))
    axes = [np.arange(low + 0.25, high, 0.5) for low, high in zip(LOW, HIGH, strict=True)]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    distance = walls.signed_distance(cells.reshape(-1, 3))[0].reshape(cells.shape[:3])
    field = DistanceField(
        origin_enu_m=tuple(cells[0, 0, 0].tolist()),
        resolution_m=0.5,
        distance_m=np.clip(distance, 0.0, 3.0).astype(np.float32),
    )
    return GivenMap(obstacles=walls, field=field, is_reachable=cells[..., 0] < WALL[0][0])


@pytest.fixture
def growing():
    """The same room, seen twice from before the wall."""
    seen = SeenMap(LOW, HIGH)
    for _ in range(2):
        seen.observe(look_down((0.0, 0.0, 2.0), pitch_down=0.0, boxes=[box(*WALL)]))
    return seen


def test_a_given_map_knows_what_nobody_saw(given):
    assert given.is_given
    for place, room_m in ((BEFORE, 2.0), (BEHIND, 2.8)):
        for kind in ("distance_m", "rough_distance_m", "distance_to_seen_m", "static_distance_m"):
            assert getattr(given, kind)(place) == pytest.approx(room_m)
    assert given.may_be_reached(tuple(BEFORE[0]))
    assert not given.may_be_reached(tuple(BEHIND[0]))


def test_a_growing_map_keeps_out_of_what_it_did_not_see(growing):
    assert not growing.is_given
    assert growing.distance_m(BEFORE) > 0.0
    assert growing.distance_m(BEHIND) <= 0.0
    assert growing.static_distance_m(BEFORE) > 0.0
    assert growing.static_distance_m(BEHIND) == 0.0
    # Yet it may turn out to be free, and be reached.
    assert growing.distance_to_seen_m(BEHIND) > 0.0
    assert growing.may_be_reached(tuple(BEHIND[0]))


def test_nothing_unseen_is_clear_however_far_from_what_was_seen():
    seen = SeenMap(LOW, HIGH)
    seen.assume_free_column((-4.0, 0.0, 0.0))
    points = np.random.default_rng(0).uniform(LOW, HIGH, (500, 3))
    for part in (points, points[points[:, 0] > 6.0]):
        is_free = seen.evidence[tuple(seen.cells(part).T)] < 0
        room_m = seen.distance_m(part)
        assert np.array_equal(room_m > 0.0, is_free)
        assert np.abs(seen.rough_distance_m(part) - np.maximum(room_m, 0.0)).max() < 0.22
    assert np.all(seen.rough_distance_m(points + (100.0, 0.0, 0.0)) == 0.0)


def test_a_surface_that_comes_into_view_does_not_move_but_what_comes_into_free_air_does():
    seen = SeenMap(LOW, HIGH)
    wall, thing = np.array([[5.05, 0.0, 2.0]]), np.array([[3.05, 0.0, 2.0]])
    for n in range(4):
        seen.observe(look_down((0.0, 0.0, 2.0), pitch_down=0.0, boxes=[box(*WALL)]))
        assert seen.static_distance_m(wall) == 0.0
        if n > 1:
            assert seen.static_distance_m(thing) > 0.5
    for _ in range(2):
        there = [box(*WALL), box((3.1, 0.0, 2.0), (0.2, 0.5, 0.5))]
        seen.observe(look_down((0.0, 0.0, 2.0), pitch_down=0.0, boxes=there))
        assert seen.static_distance_m(thing) > 0.5
