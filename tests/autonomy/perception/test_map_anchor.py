"""The anchor finds by depth images how far the estimate is off, and claims no more than it saw."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.perception.map_anchor import MapAnchor
from autonomy.perception.map_anchor_cfg import SEEN_SO_FAR, MapAnchorCfg
from autonomy.perception.map_match import MapMatcher
from autonomy.planning import Obstacles
from autonomy.types import FlatReference
from tests.autonomy.depth_scene import LEVEL, box, look_down, quat_of

GROUND = ((0.0, 0.0, -1.0), (60.0, 60.0, 2.0))
YARD = [
    ((1.2, 0.9, 0.6), (1.0, 0.7, 1.2)),
    ((-1.4, 0.6, 0.9), (0.8, 1.1, 1.8)),
    ((0.3, -1.6, 0.4), (1.6, 0.6, 0.8)),
    ((4.2, 1.5, 1.0), (0.9, 2.0, 2.0)),
    ((3.6, -2.4, 0.5), (1.5, 1.0, 1.0)),
    ((-4.0, -1.2, 0.7), (1.1, 1.4, 1.4)),
    ((-0.7, 3.9, 0.8), (2.0, 0.9, 1.6)),
]
KNOWN = MapAnchorCfg(horizontal_sigma_m=0.3, vertical_sigma_m=0.3)
LEVEL_FLIGHT = [(0.0, 0.0, 5.0), (1.0, 0.5, 5.0), (2.5, 0.0, 5.5), (-2.0, 1.0, 5.0)]


def world(solids):
    centers, sizes = zip(*solids, GROUND, strict=True)
    return Obstacles.boxes(np.array(centers), np.tile(LEVEL, (len(centers), 1)), np.array(sizes))


def matcher(solids):
    return MapMatcher(world(solids))


def seen(solids, error, eye=(0.0, 0.0, 5.0), quat=LEVEL, believed_quat=None):
    """From `eye` down, by an estimate that is off by `error`."""
    believed = (tuple(np.add(eye, error)), believed_quat or quat)
    return look_down(eye, quat, boxes=[box(*solid) for solid in solids], believed=believed)


def lacking(anchor, error):
    """What the anchor leaves of an error."""
    return np.add(anchor.fix.offset_enu_m, error)


@pytest.mark.parametrize("error", [(0.3, -0.25, 0.3), (-0.2, 0.3, -0.3), (0.0, 0.0, 0.0)])
def test_decimetres_are_found_from_one_image(error):
    anchor = MapAnchor(matcher(YARD), KNOWN)
    fix = anchor.update(0.0, seen(YARD, error))
    assert fix.accepted
    assert np.abs(lacking(anchor, error)).max() < 0.05
    assert fix.sigma_m < 0.1


@pytest.mark.parametrize("error", [(1.7, -1.2, 2.0), (-2.4, 1.5, -1.6), (0.4, 2.8, 3.1)])
def test_metres_are_found_from_a_few_images(error):
    anchor = MapAnchor(matcher(YARD))
    for k, eye in enumerate(LEVEL_FLIGHT):
        anchor.update(0.5 * k, seen(YARD, error, eye))
    assert np.abs(lacking(anchor, error)).max() < 0.1


def test_a_bare_floor_tells_the_height_and_nothing_else():
    anchor = MapAnchor(matcher([]), KNOWN)
    fix = anchor.update(0.0, seen([], (0.25, -0.2, 0.3)))
    assert fix.accepted
    east, north, up = fix.offset_enu_m
    assert (east, north) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert up == pytest.approx(-0.3, abs=0.02)
    assert fix.sigma_m == pytest.approx(0.3, abs=0.01)


def test_along_a_ridge_only_the_way_across_is_told():
    ridge = [((0.0, 0.0, 0.75), (50.0, 1.5, 1.5))]
    anchor = MapAnchor(matcher(ridge), KNOWN)
    fix = anchor.update(0.0, seen(ridge, (0.25, 0.25, 0.0)))
    east, north, _ = fix.offset_enu_m
    assert east == pytest.approx(0.0, abs=0.01)
    assert north == pytest.approx(-0.25, abs=0.05)
    assert fix.sigma_m == pytest.approx(0.3, abs=0.02)


def test_the_far_side_of_a_thin_roof_is_not_what_was_seen():
    roof = [((0.0, 0.0, 2.0), (8.0, 8.0, 0.3))]
    anchor = MapAnchor(matcher(roof), KNOWN)
    anchor.update(0.0, seen(roof, (0.0, 0.0, -0.25)))
    assert lacking(anchor, (0.0, 0.0, -0.25))[2] == pytest.approx(0.0, abs=0.03)


def test_what_fits_in_two_places_is_refused():
    posts = [((3.0 * i, 3.0 * j, 1.0), (0.8, 0.8, 2.0)) for i in range(-5, 6) for j in range(-5, 6)]
    cfg = MapAnchorCfg(horizontal_sigma_m=30.0, vertical_sigma_m=0.1)
    anchor = MapAnchor(matcher(posts), cfg)
    fix = anchor.update(0.0, seen(posts, (1.5, 1.4, 0.0)))
    assert not fix.accepted
    assert "as well" in fix.reason
    assert fix.offset_enu_m == (0.0, 0.0, 0.0)


def test_an_image_of_the_sky_changes_nothing_and_says_why():
    anchor = MapAnchor(matcher(YARD), KNOWN)
    image = seen(YARD, (0.2, 0.0, 0.0))
    fix = anchor.update(0.0, replace(image, depth_m=np.full_like(image.depth_m, np.inf)))
    assert not fix.accepted
    assert "0 points" in fix.reason
    assert fix.offset_enu_m == (0.0, 0.0, 0.0)


def test_what_the_map_does_not_have_does_not_pull():
    error = (0.25, -0.2, 0.2)
    people = [((-0.2, 0.3, 0.9), (0.5, 0.5, 1.8)), ((2.4, -0.6, 0.9), (0.5, 0.5, 1.8))]
    anchor = MapAnchor(matcher(YARD), KNOWN)
    fix = anchor.update(0.0, seen([*YARD, *people], error))
    assert fix.accepted
    assert np.abs(lacking(anchor, error)).max() < 0.08


def test_another_place_altogether_is_refused():
    elsewhere = [
        ((x, y, 2.0), (0.6, 0.6, 0.4)) for x in (-2.0, -0.7, 0.7, 2.0) for y in (-1.0, 1.0)
    ]
    anchor = MapAnchor(matcher(YARD), KNOWN)
    boxes = [box(*solid) for solid in elsewhere]
    image = look_down((0.0, 0.0, 3.2), boxes=boxes, ground=-3.0)
    assert not anchor.update(0.0, image).accepted


def test_most_of_an_error_of_heading_is_found_too():
    turned = quat_of((0.0, 0.0, math.radians(4.0)))
    anchor = MapAnchor(matcher(YARD), replace(KNOWN, yaw_sigma_rad=math.radians(4.0)))
    for k in range(4):
        anchor.update(0.5 * k, seen(YARD, (0.1, 0.1, 0.0), believed_quat=turned))
    assert anchor.fix.yaw_rad == pytest.approx(-math.radians(4.0), abs=math.radians(1.3))


def test_noise_of_the_camera_is_borne():
    rng = np.random.default_rng(5)
    error = (0.3, -0.25, 0.3)
    image = seen(YARD, error)
    noisy = 1.0 / (1.0 / image.depth_m + rng.normal(0.0, 0.002, image.depth_m.shape))
    anchor = MapAnchor(matcher(YARD), KNOWN)
    anchor.update(0.0, replace(image, depth_m=noisy.astype(np.float32)))
    assert np.abs(lacking(anchor, error)).max() < 0.08


@pytest.mark.parametrize(("claimed_m", "least_m", "most_m"), [(0.05, 0.0, 0.13), (1.8, 0.4, 2.0)])
def test_no_more_is_doubted_than_the_estimate_claims(claimed_m, least_m, most_m):
    # Above a bare floor nothing takes a doubt away again, and who doubts sees nothing move.
    anchor = MapAnchor(matcher([]))
    anchor.claim(claimed_m)
    anchor.update(0.0, seen([], (0.0, 0.0, 0.0)))
    shares = []
    for n in range(1, 6):
        mover = ((0.3 * n - 0.9, 0.0, 4.0), (0.6, 0.6, 0.3))
        shares.append(anchor.update(0.2 * n, seen([mover], (0.0, 0.0, 0.0))).inlier_share)
    assert max(shares) < 0.93
    assert least_m < anchor.sigma_m < most_m


def test_a_place_that_is_known_is_taken_over_at_once():
    anchor = MapAnchor(matcher(YARD))
    anchor.stand_at(0.0, (1.3, -2.1, 4.0), (0.0, 0.0, 0.2), 0.05)
    position, _ = anchor.to_map((1.3, -2.1, 4.0), 0.0)
    assert position == pytest.approx((0.0, 0.0, 0.2), abs=0.01)
    assert anchor.sigma_m == pytest.approx(0.05, abs=0.01)


def test_what_the_position_moves_beyond_the_velocity_is_not_taken_for_flight():
    anchor = MapAnchor(matcher([]), SEEN_SO_FAR)
    anchor.stand_at(0.0, (0.5, 0.0, -1.0), (0.0, 0.0, 0.0), 0.01)
    for n in range(200):
        time_s = 0.02 * n
        believed = (0.5 + 1.0 * time_s + 0.1 * time_s, -0.2 * time_s, -1.0)
        anchor.follow(time_s, believed, (1.0, 0.0, 0.0))
        anchor.advance(time_s)
    assert anchor.to_map(believed, 0.0)[0] == pytest.approx((time_s, 0.0, 0.0), abs=0.01)
    # A silence tells nothing of the way.
    anchor.follow(time_s + 5.0, (20.0, 0.0, -1.0), (1.0, 0.0, 0.0))
    assert anchor.offset_enu_m == pytest.approx((time_s - believed[0], 0.2 * time_s, 1.0), abs=0.01)


def test_a_better_estimate_is_believed_for_longer():
    sigmas = []
    for accuracy_m in (0.05, 1.6):
        anchor = MapAnchor(matcher(YARD))
        anchor.claim(accuracy_m)
        anchor.stand_at(0.0, (0.0, 0.0, 0.2), (0.0, 0.0, 0.2), 0.05)
        anchor.stand_at(20.0, (0.0, 0.0, 0.2), (0.0, 0.0, 0.2), 100.0)  # only time passes
        sigmas.append(anchor.sigma_m)
    assert sigmas[0] < 0.15 < 0.3 < sigmas[1]


def test_the_offset_in_use_never_jumps_and_arrives():
    cfg = replace(KNOWN, slew_mps=0.4)
    error = (0.3, -0.25, 0.3)
    anchor = MapAnchor(matcher(YARD), cfg)
    anchor.advance(0.0)
    anchor.update(0.0, seen(YARD, error))
    before = np.array(anchor.offset_enu_m)
    assert np.all(before == 0.0)
    for tick in range(1, 200):
        anchor.advance(0.02 * tick)
        after = np.array(anchor.offset_enu_m)
        assert np.linalg.norm(after - before) <= 0.4 * 0.02 + 1e-9
        before = after
    np.testing.assert_allclose(before, anchor.fix.offset_enu_m, atol=0.005)


def test_the_same_images_make_the_same_anchor():
    def flown():
        anchor = MapAnchor(matcher(YARD))
        return [
            anchor.update(0.5 * k, seen(YARD, (1.0, 0.6, 1.1), eye)).offset_enu_m
            for k, eye in enumerate(LEVEL_FLIGHT)
        ]

    assert flown() == flown()


coordinates = st.tuples(*[st.floats(-50.0, 50.0)] * 3)


@settings(max_examples=40, deadline=None)
@given(coordinates, coordinates, coordinates, st.floats(-3.1, 3.1))
def test_setpoints_go_out_as_telemetry_comes_in(offset, place, velocity, yaw):
    anchor = MapAnchor(matcher([]))
    anchor.stand_at(0.0, (0.0, 0.0, 0.0), offset, 0.01)
    wanted = FlatReference(position_enu_m=place, velocity_enu_mps=velocity, yaw_rad=yaw)
    sent = anchor.to_estimate(wanted)
    position, back = anchor.to_map(sent.position_enu_m, sent.yaw_rad)
    assert position == pytest.approx(place, abs=1e-9)
    assert back == pytest.approx(yaw, abs=1e-9)
    assert anchor.vector_to_map(sent.velocity_enu_mps) == pytest.approx(velocity, abs=1e-9)


def test_an_image_in_the_map_shows_what_the_map_has():
    error = (0.3, -0.25, 0.3)
    obstacles = world(YARD)
    anchor = MapAnchor(MapMatcher(obstacles), KNOWN)
    image = seen(YARD, error)
    anchor.advance(0.0)
    anchor.update(0.0, image)
    for second in range(1, 12):
        anchor.advance(float(second))
    points = anchor.image_to_map(image).points_enu_m()[::50]
    assert np.median(np.abs(obstacles.signed_distance(points)[0])) < 0.02
