import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.perception import MoverTracker, MoverTrackerCfg
from autonomy.perception.cell_distances import CellDistances
from tests.autonomy.depth_scene import LEVEL, box, look_down

PERIOD_S = 0.2
EYE = (0.0, 0.0, 2.0)
WALL = box((9.0, 0.0, 1.5), (0.2, 12.0, 3.0))
PILLAR = box((5.0, 1.0, 1.5), (0.5, 0.5, 3.0))
PERSON = np.array([0.3, 0.6, 1.76])


def look(boxes, eye=EYE, *, believed=None, pitch_down=0.2, noise=None):
    """What a camera that faces east sees of the ground and of boxes."""
    believed = None if believed is None else (believed, LEVEL)
    image = look_down(eye, boxes=boxes, believed=believed, pitch_down=pitch_down)
    if noise is not None:
        image.depth_m[:] = 1.0 / (1.0 / image.depth_m + noise.normal(0.0, 0.004, (240, 320)))
    return image


def map_of(boxes):
    """Distance to the ground and to boxes."""

    def distance(points):
        gaps = [points[:, 2]]
        for low, high in boxes:
            beyond = np.maximum(np.maximum(low - points, points - high), 0.0)
            gaps.append(np.linalg.norm(beyond, axis=1))
        return np.min(gaps, axis=0)

    return distance


STATIC = (WALL, PILLAR)
MAP = map_of(STATIC)


def person_at(x, y):
    return box((x, y, PERSON[2] / 2), PERSON)


def followed(place, n_images, *, tracker=None, static=STATIC, start_s=0.0, **options):
    """A tracker that saw a person whose place at each time is given."""
    tracker = MoverTracker() if tracker is None else tracker
    for k in range(n_images):
        t = start_s + k * PERIOD_S
        tracker.update(t, look([*static, person_at(*place(t))], **options), MAP)
    return tracker


def walking(vx, vy, start=(6.0, -2.0)):
    return lambda t: (start[0] + vx * t, start[1] + vy * t)


def test_nothing_moves_where_the_map_explains_everything():
    tracker = MoverTracker()
    for k in range(5):
        tracker.update(k * PERIOD_S, look(STATIC), MAP)
    assert tracker.tracks == []
    assert len(tracker.moving(1.0)) == 0


@given(
    st.floats(-0.12, 0.12),
    st.floats(-0.12, 0.12),
    st.floats(-0.12, 0.12),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=8, deadline=None)
def test_neither_errors_of_the_estimate_nor_noise_make_ghosts(x, y, z, seed):
    rng = np.random.default_rng(seed)
    tracker = MoverTracker()
    for k in range(4):
        believed = (EYE[0] + x, EYE[1] + y, EYE[2] + z)
        tracker.update(k * PERIOD_S, look(STATIC, believed=believed, noise=rng), MAP)
    assert len(tracker.moving(0.6)) == 0


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
@settings(max_examples=8, deadline=None)
def test_position_and_velocity_of_a_walker_after_little_more_than_half_a_second(vx, vy):
    place = walking(vx, vy, (5.5, -1.2))
    moving = followed(place, 5).moving(0.8)
    assert len(moving) == 1
    np.testing.assert_allclose(moving.position_enu_m[0, :2], place(0.8), atol=0.35)
    np.testing.assert_allclose(moving.velocity_enu_mps[0, :2], (vx, vy), atol=0.5)
    assert abs(moving.velocity_enu_mps[0, 2]) < 0.2


def test_the_predicted_solid_holds_the_walker():
    place = walking(0.2, 1.0)
    moving = followed(place, 6).moving(1.0)
    low, high = person_at(*place(1.0))
    corners = np.array(
        [
            [x, y, z]
            for x in (low[0], high[0])
            for y in (low[1], high[1])
            for z in (low[2] + 0.05, high[2] - 0.1)
        ]
    )
    assert moving.distances(corners, np.zeros(8))[0].max() < 0.1
    # And is not much larger.
    assert moving.radius_m[0] + moving.half_extent_m[0, :2].max() < 0.6
    assert moving.radius_m[0] + moving.half_extent_m[0, 2] < 1.4


def test_prediction_runs_on_at_the_velocity_and_grows_unsure():
    tracker = followed(walking(0.0, 1.2), 6)
    now, later = tracker.moving(1.0), tracker.moving(2.0)
    moved = later.position_enu_m - now.position_enu_m
    # Nearly: it may also turn or stand.
    np.testing.assert_allclose(moved, now.velocity_enu_mps, atol=0.1)
    assert later.radius_m[0] > now.radius_m[0]


def test_two_images_are_not_enough_and_three_are():
    assert len(followed(walking(0.0, 1.0), 2).moving(0.4)) == 0
    assert len(followed(walking(0.0, 1.0), 3).moving(0.6)) == 1


def test_what_was_seen_too_seldom_to_count_is_in_question_until_it_counts():
    tracker = followed(walking(0.0, 1.0), 2)
    np.testing.assert_allclose(tracker.in_question()[0, :2], walking(0.0, 1.0)(0.2)[:2], atol=0.4)
    assert followed(walking(0.0, 1.0), 3).in_question().shape == (0, 3)


def test_somebody_who_waits_is_in_the_way_too():
    moving = followed(walking(0.0, 0.0), 6).moving(1.0)
    assert np.linalg.norm(moving.velocity_enu_mps[0]) < 0.1


def test_several_keep_their_tracks_when_they_pass_each_other():
    tracker = MoverTracker()
    for k in range(14):
        t = k * PERIOD_S
        boxes = [*STATIC, person_at(4.0, -2.5 + t), person_at(7.5, 1.0 - t)]
        tracker.update(t, look(boxes), MAP)
    moving = tracker.moving(t)
    assert len(moving) == 2
    order = np.argsort(moving.position_enu_m[:, 0])
    np.testing.assert_allclose(moving.velocity_enu_mps[order, 1], [1.0, -1.0], atol=0.35)


def test_who_is_gone_is_dropped_as_soon_as_the_place_is_seen_empty():
    tracker = followed(walking(0.0, 0.0), 5)
    for k in (5, 6):
        tracker.update(k * PERIOD_S, look(STATIC), MAP)
    assert tracker.tracks == []


def test_who_walks_behind_a_pillar_is_expected_on_the_other_side():
    tracker = followed(walking(0.0, 1.0, (7.0, 0.0)), 6)
    hidden = [box((3.0, 1.0, 1.5), (0.2, 2.5, 3.0))]
    for k in range(6, 11):
        image = look([*STATIC, *hidden, person_at(7.0, k * PERIOD_S)])
        tracker.update(k * PERIOD_S, image, map_of([*STATIC, *hidden]))
    moving = tracker.moving(2.0)
    assert len(moving) == 1
    assert moving.position_enu_m[0, 1] == pytest.approx(2.0, abs=0.5)


def test_who_went_out_of_sight_is_forgotten_in_the_end():
    tracker = followed(walking(0.0, 0.0), 5)
    blind = dataclasses.replace(look(STATIC), depth_m=np.zeros((240, 320), dtype=np.float32))
    tracker.update(2.0, blind, MAP)
    assert len(tracker.moving(2.0)) == 1
    tracker.update(5.9, blind, MAP)
    assert tracker.tracks == []


def test_an_image_without_any_depth_begins_nothing():
    tracker = MoverTracker()
    for value in (math.nan, math.inf, 0.0):
        depth = np.full((240, 320), value, dtype=np.float32)
        tracker.update(0.0, dataclasses.replace(look(STATIC), depth_m=depth), MAP)
    assert tracker.tracks == []


def test_something_too_large_is_no_mover():
    house = box((8.0, 0.0, 2.0), (1.0, 9.0, 4.0))
    tracker = MoverTracker()
    for k in range(4):
        tracker.update(k * PERIOD_S, look([house]), map_of([]))
    assert tracker.tracks == []


def test_who_is_looked_down_on_stands_on_the_ground():
    tracker = MoverTracker()
    for k in range(5):
        image = look([person_at(0.3, 0.0)], eye=(0.0, 0.0, 5.0), pitch_down=math.pi / 2)
        tracker.update(k * PERIOD_S, image, map_of([]))
    moving = tracker.moving(0.8)
    below = moving.distances(np.array([[0.3, 0.0, 0.2]]), np.zeros(1))[0]
    assert below[0, 0] < 0.0


def test_a_map_that_takes_something_in_ends_its_track():
    tracker = MoverTracker(MoverTrackerCfg(remember_s=0.0))
    image = look([*STATIC, person_at(6.0, 0.0)])
    for k in range(4):
        tracker.update(k * PERIOD_S, image, MAP)
    assert len(tracker.moving(0.6)) == 1
    grown = map_of([*STATIC, person_at(6.0, 0.0)])
    for k in (4, 9, 14, 19, 24, 30):
        tracker.update(k * PERIOD_S, image, grown)
    assert tracker.tracks == []


def test_the_same_images_give_the_same_tracks():
    one, other = (
        followed(walking(0.3, 0.7), 6, noise=np.random.default_rng(4)).moving(1.3) for _ in range(2)
    )
    for a, b in zip(one.movers, other.movers, strict=True):
        assert np.array_equal(a, b)


@given(st.lists(st.tuples(*[st.floats(-200.0, 200.0)] * 3), min_size=1, max_size=50))
def test_remembered_distances_are_those_at_the_middle_of_the_cell(points):
    asked = []

    def static(middles):
        asked.append(len(middles))
        return middles[:, 2]

    cells = CellDistances(0.2, math.inf)
    cells.forget_old(0.0)
    array = np.array(points)
    first, again = cells.at(array, static), cells.at(array, static)
    assert np.abs(first - array[:, 2]).max() <= 0.1 + 1e-9
    assert np.array_equal(first, again)
    assert len(asked) == 1
    assert asked[0] == len(np.unique(array // 0.2, axis=0))


def test_distances_are_asked_for_again_when_they_are_old():
    asked = []
    cells = CellDistances(0.2, 1.0)
    for time_s in (0.0, 0.9, 1.1):
        cells.forget_old(time_s)
        cells.at(np.ones((1, 3)), lambda p: (asked.append(len(p)), p[:, 2])[1])
    assert len(asked) == 2
