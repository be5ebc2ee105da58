"""What depth images say of cells: free, occupied, unknown; and the obstacles that follow."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from autonomy.mapping import SeenMap
from autonomy.mapping.distances import boxes_about
from autonomy.mapping.rays import FREE_AT, HIT, MOST_OCCUPIED, OCCUPIED_AT
from autonomy.mapping.seen_map_cfg import SeenMapCfg
from tests.autonomy.depth_scene import box, look_down
from tests.autonomy.mapping.whole import distance_to_marked
from tests.autonomy.planning_worlds import seeds

LOW, HIGH = (-6.0, -6.0, 0.0), (14.0, 6.0, 6.0)
EYE = (0.0, 0.0, 2.0)
WALL = box((5.1, 0.0, 3.0), (0.2, 12.0, 6.0))


def look_ahead(eye=EYE, boxes=(WALL,), **options):
    return look_down(eye, pitch_down=0.0, boxes=boxes, **options)


def seen_by(*images):
    seen = SeenMap(LOW, HIGH)
    for image in images:
        seen.observe(image)
    return seen


def state(seen, *point):
    evidence = seen.evidence[tuple(seen.cells(np.array(point)))]
    return "free" if evidence <= FREE_AT else "occupied" if evidence >= OCCUPIED_AT else "unknown"


def test_cells_are_free_before_a_wall_occupied_in_it_and_unknown_behind():
    seen = seen_by(look_ahead(), look_ahead())
    assert state(seen, 3.0, 0.0, 2.0) == "free"
    assert state(seen, 5.05, 0.0, 2.0) == "occupied"
    assert state(seen, 6.0, 0.0, 2.0) == "unknown"
    assert state(seen, 0.0, 4.0, 2.0) == "unknown"


def test_one_image_frees_nothing_and_one_that_hits_takes_two_back():
    seen = seen_by(look_ahead())
    assert state(seen, 3.0, 0.0, 2.0) == "unknown"
    seen = seen_by(look_ahead(), look_ahead(), look_ahead(boxes=[box((3, 0, 2), (1, 3, 3))]))
    assert state(seen, 2.6, 0.0, 2.0) == "unknown"


def test_the_sky_is_free_up_to_the_range():
    seen = seen_by(*[look_ahead(boxes=())] * 2)
    assert state(seen, 7.0, 0.0, 3.0) == "free"
    assert state(seen, 9.0, 0.0, 3.0) == "unknown"


def test_a_hole_in_the_image_is_free_as_far_as_what_is_around_it():
    image = look_ahead()
    image.depth_m[100:120, 150:170] = np.inf
    seen = seen_by(image, image)
    assert state(seen, 4.0, 0.0, 2.0) == "free"
    assert state(seen, 6.0, 0.0, 2.1) == "unknown"


def mismatched(image, rng, share=0.0005):
    """The image with a few pixels of any depth, as a stereo camera matches them."""
    is_wrong = rng.random(image.depth_m.shape) < share
    image.depth_m[is_wrong] = rng.uniform(0.3, 8.0, np.count_nonzero(is_wrong))
    return image


def test_pixels_that_matched_something_else_close_no_cell():
    rng = np.random.default_rng(0)
    plain = seen_by(*[look_ahead()] * 12)
    noisy = seen_by(*[mismatched(look_ahead(), rng) for _ in range(12)])
    was_free = plain.evidence <= FREE_AT
    assert np.count_nonzero(was_free) > 2000
    assert np.mean(noisy.evidence[was_free] <= FREE_AT) > 0.999
    assert not np.any(noisy.evidence[was_free] >= OCCUPIED_AT)


def test_a_thing_of_a_few_pixels_is_still_seen():
    ball = box((4.05, 0.05, 2.05), (0.06, 0.06, 0.06))
    seen = seen_by(*[look_ahead(boxes=(WALL, ball))] * 2)
    assert state(seen, 4.05, 0.05, 2.05) == "occupied"


def test_what_is_behind_a_thin_pole_is_not_free():
    pole = box((4.0, 0.05, 2.0), (0.03, 0.03, 4.0))
    seen = seen_by(*[look_ahead(boxes=(pole,))] * 2)
    assert state(seen, 3.9, 0.05, 2.0) == "occupied"
    assert state(seen, 6.0, 0.07, 2.0) == "unknown"
    assert state(seen, 6.0, 1.0, 2.0) == "free"


@given(seeds)
@settings(max_examples=8)
def test_no_solid_reaches_far_into_a_free_cell(seed):
    rng = np.random.default_rng(seed)
    boxes = [box(rng.uniform((2, -4, 0), (8, 4, 4)), rng.uniform(0.1, 2, 3)) for _ in range(8)]
    half = rng.uniform(-0.3, 0.3, 4)
    images = [
        look_ahead((0.0, y, 2.0), boxes, quat=(math.cos(a), 0.0, 0.0, math.sin(a)))
        for y, a in zip(rng.uniform(-1, 1, 4), half, strict=True)
    ]
    seen = seen_by(*images, *images)
    free = np.argwhere(seen.evidence <= FREE_AT)
    centres = seen.centres(free)
    for low, high in boxes:
        if not np.all((low < EYE) & (high > EYE)):
            inside = np.minimum(centres - low, high - centres).min(axis=1)
            assert inside.max() < 0.1


def test_the_air_above_the_start_is_free_until_something_is_seen_there():
    seen = SeenMap(LOW, HIGH)
    seen.assume_free_column((1.0, 0.0, 0.0))
    assert state(seen, 1.0, 0.0, 0.1) == "free"
    assert state(seen, 1.0, 0.9, 3.0) == "free"
    assert state(seen, 1.0, 0.0, 4.0) == "unknown"
    assert seen.obstacles.signed_distance(np.array([[1.0, 0.0, 1.5]]))[0] > 0.8
    block = box((1.1, 0.0, 2.0), (0.2, 1.0, 1.0))
    seen.observe(look_ahead((-2.0, 0.0, 2.0), (block,)))
    assert state(seen, 1.05, 0.0, 2.0) != "free"


def test_one_image_that_errs_does_not_close_the_air_above_the_start():
    seen = SeenMap(LOW, HIGH)
    seen.assume_free_column((1.0, 0.0, 0.0))
    seen.observe(look_ahead((-2.0, 0.0, 2.0), (box((1.1, 0.0, 2.0), (0.2, 1.0, 1.0)),)))
    seen.observe(look_ahead((-2.0, 0.0, 2.0)))
    assert state(seen, 1.05, 0.0, 2.0) == "free"


@pytest.mark.parametrize(("evidence", "is_free"), [(HIT, True), (MOST_OCCUPIED, False)])
def test_the_air_that_the_vehicle_fills_is_free_but_what_stands_there_is_not(evidence, is_free):
    seen = SeenMap(LOW, HIGH)
    hit = tuple(seen.cells(np.array((1.1, 0.3, 2.1))))
    seen.evidence[hit] = evidence
    seen.be_at((1.0, 0.0, 2.0), 0.4, 0.1)
    assert (seen.evidence[hit] <= FREE_AT) == is_free
    assert state(seen, 1.0, 0.0, 2.0) == state(seen, 0.7, 0.0, 2.2) == "free"
    assert state(seen, 1.0, 0.7, 2.0) == "unknown"


def test_what_the_vehicle_may_stand_on_is_not_free():
    seen = SeenMap(LOW, HIGH)
    seen.be_at((1.0, 0.0, 2.1), 0.4, 0.1)
    assert state(seen, 1.0, 0.0, 2.1) == "free"
    assert state(seen, 1.0, 0.0, 1.9) == "unknown"


@given(seeds)
@settings(max_examples=30)
def test_boxes_stand_for_all_that_is_not_free_and_nothing_that_is(seed):
    rng = np.random.default_rng(seed)
    is_free = rng.random(rng.integers(1, 9, 3)) < rng.uniform(0.2, 1.0)
    obstacles = boxes_about(is_free, np.array([1.0, -2.0, 0.5]), 0.25)
    free = np.argwhere(is_free)
    if not len(free):
        return
    points = np.array([1.0, -2.0, 0.5]) + (free + 0.5) * 0.25
    # Outside the block nothing is free.
    whole = distance_to_marked(np.pad(~is_free, 1, constant_values=True), 0.25, 9.0)
    expected = whole[1:-1, 1:-1, 1:-1][tuple(free.T)]
    np.testing.assert_allclose(obstacles.signed_distance(points)[0], expected, atol=1e-6)


def test_distances_follow_what_is_seen():
    seen = seen_by(look_ahead(), look_ahead())
    before = seen.field.distance_m.copy()
    for _ in range(2):
        seen.observe(look_ahead((0.0, 1.0, 2.0)))
    # Outside the volume nothing is free.
    marked = np.pad(seen.evidence > FREE_AT, 1, constant_values=True)
    expected = distance_to_marked(marked, 0.25, 1.5)[1:-1, 1:-1, 1:-1]
    np.testing.assert_allclose(seen.field.distance_m, expected, atol=1e-6)
    assert np.any(seen.field.distance_m != before)


def test_what_stands_is_told_from_what_only_passed():
    seen = seen_by(*[look_ahead()] * 5, look_ahead(boxes=[box((3, 0, 2), (0.4, 0.4, 2))]))
    wall, passer = (5.05, 0.0, 2.0), (2.85, 0.0, 2.0)
    points = np.array([wall, passer])
    assert seen.distance_to_seen_m(points)[0] == pytest.approx(0.0)
    standing = seen.distance_to_seen_m(points, MOST_OCCUPIED)
    assert standing[0] == pytest.approx(0.0)
    assert standing[1] == pytest.approx(1.25)


@given(seeds)
@settings(max_examples=8)
def test_an_image_counts_once_for_each_cell_and_alike_in_a_map_that_cuts_it(seed):
    rng = np.random.default_rng(seed)
    eye = tuple(rng.uniform((-2, -2, 1), (2, 2, 3)))
    boxes = [box(rng.uniform((2, -4, 0), (8, 4, 4)), rng.uniform(0.1, 2, 3)) for _ in range(8)]
    half = rng.uniform(-1.5, 1.5)
    image = look_ahead(eye, boxes, quat=(math.cos(half), 0.0, 0.0, math.sin(half)))
    whole = SeenMap((-20.0, -20.0, -12.0), (20.0, 20.0, 16.0))
    part = SeenMap((-1.0, -1.5, 0.5), (6.0, 2.0, 4.0))
    for seen in (whole, part):
        seen.observe(image)
    assert set(np.unique(whole.evidence)) == {-1, 0, HIT}
    first = whole.cells(part.centres(np.zeros(3, dtype=int)))
    cut = tuple(slice(a, a + n) for a, n in zip(first, part.evidence.shape, strict=True))
    assert np.array_equal(part.evidence, whole.evidence[cut])


@given(seeds)
@settings(max_examples=10)
def test_distances_at_points_are_those_to_the_boxes_about_what_is_not_free(seed):
    rng = np.random.default_rng(seed)
    seen = SeenMap((0.0, 0.0, 0.0), (5.0, 4.0, 3.0))
    seen.evidence[rng.random(seen.evidence.shape) < rng.uniform(0.9, 1.0)] = FREE_AT
    points = rng.uniform((0.0, 0.0, 0.0), (5.0, 4.0, 3.0), (60, 3))
    is_free = seen.evidence[tuple(seen.cells(points).T)] <= FREE_AT
    away_m = seen.obstacles.signed_distance(points)[0]
    expected = np.where(is_free, np.minimum(away_m, seen.cfg.cap_m), 0.0)
    np.testing.assert_allclose(seen.distance_m(points), expected, atol=1e-6)


MEMORY = Path("/proc/self/statm")


def resident_mb():
    return int(MEMORY.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


@pytest.mark.skipif(not MEMORY.exists(), reason="reads Linux's own figures")
def test_a_map_of_a_district_takes_memory_for_what_is_seen_alone():
    SeenMap(LOW, HIGH).route_in(np.array([(0, 0, 0), (9, 9, 9)]), 0.5)
    before_mb = resident_mb()
    seen = SeenMap((-200.0, -200.0, 0.0), (200.0, 200.0, 60.0))
    for _ in range(2):
        seen.observe(look_ahead())
    block = seen.search_block(seen.cells(np.array(EYE)))
    route_m = seen.route_in(block, 0.5).distance_m
    assert seen.seen_room(block, 0.5).top > 0
    # An array of bytes for each cell would take 600 MB, one of distances 2,300 MB.
    assert route_m.nbytes / 2**20 > 50
    assert resident_mb() - before_mb < 400
    assert state(seen, 3.0, 0.0, 2.0) == "free"
    assert seen.distance_m(np.array([(3.0, 0.0, 2.0)]))[0] > 0.5


@given(seeds)
@settings(max_examples=8)
def test_a_wide_map_has_the_routes_of_any_other_in_the_block_of_a_search(seed):
    rng = np.random.default_rng(seed)
    usual = SeenMap(LOW, HIGH)
    wide = SeenMap(LOW, HIGH, SeenMapCfg(most_whole_cells=1, search_m=3.0))
    assert wide.is_wide
    assert not usual.is_wide
    boxes = [box(rng.uniform((2, -4, 0), (8, 4, 4)), rng.uniform(0.1, 2, 3)) for _ in range(8)]
    for _ in range(3):
        y = rng.uniform(-1, 1)
        for seen in (usual, wide):
            seen.observe(look_ahead((0.0, y, 2.0), boxes))
    cell = usual.cells(rng.uniform(LOW, HIGH))
    block = wide.search_block(cell)
    assert np.all(block[1] - block[0] <= 25)
    cut = tuple(slice(a, b) for a, b in block.T)
    expected = usual.route_in(usual.search_block(cell), 0.6).distance_m[cut]
    found = wide.route_in(block, 0.6)
    assert np.array_equal(found.distance_m, expected)
    np.testing.assert_allclose(found.centres(cell - block[0]), usual.centres(cell))
    room = wide.seen_room(block, 0.6)
    layers = np.flatnonzero((usual.field.distance_m[cut] >= np.float32(0.6)).any(axis=(0, 1)))
    assert room.top == (layers[-1] if len(layers) else -1)
