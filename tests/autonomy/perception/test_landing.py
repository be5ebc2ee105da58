import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.perception import (
    ElevationMap,
    LandingNeeds,
    assess,
    choose_site,
    objection,
    site_at,
)
from tests.autonomy.depth_scene import LEVEL, box, look_down, quat_of

NEEDS = LandingNeeds(footprint_radius_m=0.25, body_radius_m=0.4)
CELL_M = 0.05
HERE = (0.0, 0.0, 0.0)
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def mapped(*images):
    """One image stands for as many as it takes to believe it."""
    elevation = ElevationMap(HERE)
    for image in images if len(images) > 1 else images * NEEDS.min_frames:
        elevation.add(image)
    return elevation


def judged(*images, allowed=None):
    elevation = mapped(*images)
    return elevation, assess(elevation, NEEDS, allowed)


def distance_to(elevation, x, y):
    east, north = np.meshgrid(*elevation.cell_centres())
    return np.hypot(east - x, north - y)


def safe_at(elevation, landing, x, y):
    return bool(landing.is_safe[elevation.cell(x, y)])


def test_flat_ground_is_safe_and_the_preferred_point_is_taken():
    elevation, landing = judged(look_down())
    site = choose_site(landing, elevation, NEEDS, (0.2, -0.1, 0.0))
    assert site is not None
    assert site.position_enu_m == pytest.approx((0.2, -0.1, 0.0), abs=1e-4)
    assert site.slope_rad == pytest.approx(0.0, abs=1e-4)
    assert site.roughness_m == pytest.approx(0.0, abs=1e-4)
    assert site.clearance_m > 1.0
    assert objection(landing, elevation, NEEDS, site.position_enu_m) is None
    assert site_at(landing, elevation, site.position_enu_m) == site


@given(st.floats(0.0, 20.0), st.floats(-math.pi, math.pi))
@settings(max_examples=20)
def test_slope_is_measured_and_judged(slope_deg, heading):
    rise = math.tan(math.radians(slope_deg))
    gradient = (rise * math.cos(heading), rise * math.sin(heading))
    elevation, landing = judged(look_down(gradient=gradient))
    site = site_at(landing, elevation, HERE)
    assert site is not None
    assert math.degrees(site.slope_rad) == pytest.approx(slope_deg, abs=0.3)
    if abs(slope_deg - 10.0) > 0.4:
        assert safe_at(elevation, landing, 0.0, 0.0) == (slope_deg < 10.0)


@pytest.mark.parametrize("drop_m", [0.1, 0.5, 2.0])
def test_a_step_is_an_edge_above_and_an_obstacle_below(drop_m):
    terrace = box((-5.0, 0.0, drop_m / 2), (10.0, 20.0, drop_m))  # ends at x = 0
    elevation, landing = judged(look_down((0.1, 0.0, 4.0 + drop_m), boxes=[terrace]))
    east, _ = elevation.cell_centres()
    rows = [elevation.cell(0.0, y)[0] for y in (-0.5, 0.0, 0.5)]
    safe = landing.is_safe[rows].all(axis=0)
    unsafe = ~landing.is_safe[rows].any(axis=0)
    # The feet need the edge out of their circle, the rotors nothing but air beyond it.
    assert unsafe[(east > -NEEDS.footprint_radius_m) & (east < NEEDS.body_radius_m)].all()
    assert safe[(east > -1.0) & (east < -NEEDS.footprint_radius_m - 2 * CELL_M)].all()
    assert safe[(east > NEEDS.body_radius_m + 2 * CELL_M) & (east < 1.0)].all()


@given(
    st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    st.floats(0.1, 0.6),
    st.floats(0.12, 1.5),
)
@settings(max_examples=20)
def test_a_box_keeps_the_whole_vehicle_away(place, width, height):
    elevation, landing = judged(
        look_down(boxes=[box((*place, height / 2), (width, width, height))])
    )
    away = distance_to(elevation, *place)
    # The feet may fit on its top.
    may_stand = width / 2 > NEEDS.footprint_radius_m - CELL_M
    # Three pixels make an obstacle: of a cell that it covers less than half of there may be fewer.
    reach = width / 2 + NEEDS.body_radius_m - CELL_M / 2
    near = (away < reach) & (away > (0.12 if may_stand else -1.0))
    assert not landing.is_safe[near].any()


def test_a_thin_pole_keeps_the_whole_vehicle_away():
    elevation, landing = judged(look_down(boxes=[box((0.31, 0.12, 0.5), (0.02, 0.02, 1.0))]))
    away = distance_to(elevation, 0.31, 0.12)
    assert not landing.is_safe[away < NEEDS.body_radius_m - CELL_M].any()
    site = choose_site(landing, elevation, NEEDS, (0.31, 0.12, 0.0))
    assert site is not None
    assert math.dist(site.position_enu_m[:2], (0.31, 0.12)) > NEEDS.body_radius_m


def test_what_is_lower_than_the_rotors_may_stand_beside_the_feet():
    kerb = box((0.45, 0.0, 0.02), (0.2, 4.0, 0.04))
    elevation, landing = judged(look_down(boxes=[kerb]))
    assert safe_at(elevation, landing, 0.0, 0.0)
    tall = box((0.45, 0.0, 0.06), (0.2, 4.0, 0.12))
    elevation, landing = judged(look_down(boxes=[tall]))
    assert not safe_at(elevation, landing, 0.0, 0.0)
    assert "rises 0.12 m" in str(objection(landing, elevation, NEEDS, HERE))


def test_unobserved_ground_under_the_feet_is_unsafe():
    image = look_down()
    image.depth_m[118:122, 158:162] = math.nan  # 6 cm
    elevation, landing = judged(image)
    away = distance_to(elevation, 0.0, 0.0)
    assert not landing.is_safe[away < NEEDS.footprint_radius_m - CELL_M].any()
    assert "not all of the ground under the feet" in str(
        objection(landing, elevation, NEEDS, (0.1, 0.1, 0.0))
    )


def test_what_may_hide_behind_a_wall_is_an_obstacle():
    # Ground shows again 1.05 m from the camera; who stands at 1.4 m has rotors over what is hidden.
    wall = box((0.5, 0.0, 1.0), (0.05, 6.0, 2.0))
    elevation, landing = judged(look_down((0.0, 0.0, 4.0), boxes=[wall]))
    assert not elevation.is_observed[elevation.cell(0.95, 0.0)]
    assert "beside the vehicle" in str(objection(landing, elevation, NEEDS, (1.4, 0.0, 0.0)))
    assert safe_at(elevation, landing, 1.6, 0.0)


def test_what_hides_below_a_roof_edge_is_no_obstacle():
    roof = box((-4.0, 0.0, 3.0), (9.0, 20.0, 6.0))  # ends at x = 0.5, ground shows from x = 1.25
    elevation, landing = judged(look_down((0.0, 0.0, 10.0), boxes=[roof]))
    assert not elevation.is_observed[elevation.cell(0.8, 0.0)]
    assert safe_at(elevation, landing, 0.5 - NEEDS.footprint_radius_m - 2 * CELL_M, 0.0)


@pytest.mark.parametrize("width", [0.8, 1.2])
def test_a_table_top_is_landed_on_in_its_middle(width):
    table = box((0.1, -0.1, 0.375), (width, width, 0.75))
    elevation = mapped(look_down((0.0, 0.0, 4.0), boxes=[table]))
    polygon = [(0.1 + x * width / 2, -0.1 + y * width / 2, 0.75) for x, y in CORNERS]
    landing = assess(elevation, NEEDS, elevation.cells_within(polygon))
    site = choose_site(landing, elevation, NEEDS, (0.1, -0.1, 0.75))
    assert site is not None
    assert site.position_enu_m[2] == pytest.approx(0.75, abs=1e-3)
    assert np.abs(np.array(site.position_enu_m[:2]) - (0.1, -0.1)).max() < width / 2 - 0.25


def test_a_stool_is_too_small():
    stool = box((0.0, 0.0, 0.25), (0.4, 0.4, 0.5))
    elevation, landing = judged(look_down(boxes=[stool]))
    assert not landing.is_safe[distance_to(elevation, 0.0, 0.0) < 0.6].any()
    assert "height range" in str(objection(landing, elevation, NEEDS, HERE))


def test_noise_and_an_uncertain_pose_leave_flat_ground_safe_and_level():
    rng = np.random.default_rng(5)
    elevation = ElevationMap(HERE)
    for _ in range(6):
        believed = (
            tuple(np.array([0.0, 0.0, 4.0]) + rng.normal(0.0, [0.05, 0.05, 0.1])),
            quat_of(rng.normal(0.0, math.radians(0.4), 3)),
        )
        image = look_down(believed=believed)
        image.depth_m[:] += rng.normal(0.0, 0.002, image.depth_m.shape)
        elevation.add(image)
    landing = assess(elevation, NEEDS)
    site = choose_site(landing, elevation, NEEDS, HERE)
    assert site is not None
    assert landing.is_safe[distance_to(elevation, 0.0, 0.0) < 0.5].all()
    assert math.degrees(site.slope_rad) < 1.0


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.1))
@settings(max_examples=20)
def test_every_cell_is_judged_as_if_it_were_fitted_alone(seed, roughness):
    rng = np.random.default_rng(seed)
    elevation = ElevationMap((0.0, 0.0, 80.0), half_extent_m=0.8)
    n = len(elevation.height_m)
    elevation.n_frames[:] = NEEDS.min_frames * (rng.uniform(size=(n, n)) > 0.003)
    elevation.variance_m2[elevation.is_observed] = 0.0
    elevation.height_m[:] = 80.0 + rng.normal(0.0, roughness, (n, n))
    elevation.top_m[:] = elevation.height_m + rng.uniform(0.0, 0.02, (n, n))
    elevation.bottom_m[:] = elevation.height_m - rng.uniform(0.0, 0.02, (n, n))
    landing = assess(elevation, NEEDS)
    east, north = np.meshgrid(*elevation.cell_centres())
    for row, column in rng.integers(9, n - 9, (5, 2)):
        x, y = east - east[row, column], north - north[row, column]
        foot = np.hypot(x, y) <= NEEDS.footprint_radius_m + CELL_M / 2 + 1e-9
        body = np.hypot(x, y) <= NEEDS.body_radius_m + CELL_M / 2 + 1e-9
        if not elevation.is_observed[foot].all():
            assert np.isnan(landing.surface_m[row, column])
            assert not landing.is_safe[row, column]
            continue
        design = np.column_stack([np.ones(foot.sum()), x[foot], y[foot]])
        fit, *_ = np.linalg.lstsq(design, elevation.height_m[foot].astype(float), rcond=None)
        plane = fit[0] + fit[1] * x + fit[2] * y
        assert landing.surface_m[row, column] == pytest.approx(fit[0], abs=1e-5)
        slope = math.atan(math.hypot(fit[1], fit[2]))
        assert landing.slope_rad[row, column] == pytest.approx(slope, abs=1e-5)
        span = np.max((elevation.top_m - plane)[foot]) - np.min((elevation.bottom_m - plane)[foot])
        assert landing.roughness_m[row, column] == pytest.approx(span, abs=3e-5)
        rise = np.max((elevation.ceiling_m - plane)[body])
        assert landing.rise_m[row, column] == pytest.approx(rise, abs=3e-5)


def test_only_allowed_cells_are_chosen_and_room_counts_within_them():
    elevation = mapped(look_down())
    polygon = [(0.5, 0.5, 0.0), (1.3, 0.5, 0.0), (1.3, 1.3, 0.0), (0.5, 1.3, 0.0)]
    allowed = elevation.cells_within(polygon)
    landing = assess(elevation, NEEDS, allowed)
    site = choose_site(landing, elevation, NEEDS, HERE)
    assert site is not None
    assert allowed[elevation.cell(*site.position_enu_m[:2])]
    # A metre nearer is worth little: the middle of the square it is, give or take.
    assert math.dist(site.position_enu_m[:2], (0.9, 0.9)) < 0.2
    assert site.clearance_m < 0.46
    assert (
        choose_site(assess(elevation, NEEDS, ~np.isfinite(allowed)), elevation, NEEDS, HERE) is None
    )


def test_cost_is_one_where_it_is_unsafe_and_falls_with_room():
    boxes = [box((0.8, 0.0, 0.5), (0.4, 0.4, 1.0))]
    elevation, landing = judged(look_down(boxes=boxes))
    observed = elevation.is_observed
    assert landing.cells_enu_m.shape == (np.count_nonzero(observed), 3)
    assert landing.cost.shape == (len(landing.cells_enu_m),)
    assert np.all(landing.cost[~landing.is_safe[observed]] == 1.0)
    assert np.all(landing.cost[landing.is_safe[observed]] < 0.51)
    assert landing.cost.min() == 0.0
    on_the_box = np.hypot(*(landing.cells_enu_m[:, :2] - (0.8, 0.0)).T) < 0.1
    np.testing.assert_allclose(landing.cells_enu_m[on_the_box, 2], 1.0, atol=1e-4)
    order = np.argsort(landing.clearance_m[observed])
    assert np.all(np.diff(landing.cost[order]) <= 1e-6)


def test_nothing_seen_means_nowhere_to_land():
    elevation = ElevationMap(HERE)
    landing = assess(elevation, NEEDS)
    assert not landing.is_safe.any()
    assert len(landing.cells_enu_m) == 0
    assert choose_site(landing, elevation, NEEDS, HERE) is None
    assert site_at(landing, elevation, HERE) is None


def test_places_off_the_map_are_refused():
    elevation, landing = judged(look_down())
    for place in ((50.0, 0.0, 0.0), (-50.0, 0.0, 0.0), (0.0, 3.04, 0.0)):
        assert site_at(landing, elevation, place) is None
        assert objection(landing, elevation, NEEDS, place) is not None


def test_the_edge_of_what_was_seen_is_no_place_for_rotors():
    elevation, landing = judged(look_down((0.0, 0.0, 2.0)))
    half = 2.0 * math.tan(math.radians(30.0))
    east, _ = np.meshgrid(*elevation.cell_centres())
    # The nose, and with it the image's top, points east.
    assert not landing.is_safe[np.abs(east) > half - NEEDS.body_radius_m + 2 * CELL_M].any()
    assert landing.is_safe[elevation.cell(half - NEEDS.body_radius_m - 3 * CELL_M, 0.0)]
    place = (half - NEEDS.body_radius_m + 2 * CELL_M, 0.0, 0.0)
    assert "was observed" in str(objection(landing, elevation, NEEDS, place))


def test_steepness_is_named():
    elevation, landing = judged(look_down(gradient=(0.2493, 0.0)))  # 14 deg
    reason = str(objection(landing, elevation, NEEDS, HERE))
    assert re.fullmatch(r"slope 1[34]\.\d deg, up to 0\.\d more, at most 10\.0", reason)


def test_something_that_moves_in_is_noticed():
    frames = [look_down()] * 6
    crate = box((0.1, 0.0, 0.15), (0.3, 0.3, 0.3))
    elevation, landing = judged(*frames, look_down(boxes=[crate]))
    assert not safe_at(elevation, landing, 0.0, 0.0)


def test_height_offset_between_frames_is_no_roughness():
    frames = [look_down(believed=((0.0, 0.0, 4.0 + z), LEVEL)) for z in (0.0, 0.15, -0.1)]
    elevation, landing = judged(*frames)
    assert landing.roughness_m[elevation.cell(0.0, 0.0)] < 1e-3


def noisy(image, rng, inverse_sigma):
    """The image as a stereo camera has it, a few pixels matched with something else altogether."""
    disparity = 1.0 / image.depth_m + rng.normal(0.0, inverse_sigma, image.depth_m.shape)
    wrong = rng.uniform(size=image.depth_m.shape) < 5e-4
    disparity[wrong] = 1.0 / rng.uniform(0.5, 8.0, np.count_nonzero(wrong))
    return dataclasses.replace(image, depth_m=(1.0 / disparity).astype(np.float32))


def test_ground_that_was_seen_too_seldom_is_not_safe():
    elevation = ElevationMap(HERE)
    for n_frames in range(1, NEEDS.min_frames + 1):
        elevation.add(look_down())
        landing = assess(elevation, NEEDS)
        assert safe_at(elevation, landing, 0.0, 0.0) == (n_frames >= NEEDS.min_frames)


def test_wrong_matches_neither_make_nor_break_a_site():
    rng = np.random.default_rng(2)
    stool = box((0.9, 0.0, 0.25), (0.4, 0.4, 0.5))
    frames = [noisy(look_down(boxes=[stool]), rng, 0.001) for _ in range(12)]
    elevation, landing = judged(*frames)
    away = distance_to(elevation, 0.9, 0.0)
    inside = distance_to(elevation, 0.0, 0.0) < 1.4
    assert not landing.is_safe[away < 0.2 + NEEDS.body_radius_m - CELL_M].any()
    assert landing.is_safe[inside & (away > 0.3 + NEEDS.body_radius_m + 2 * CELL_M)].mean() > 0.95


def test_what_is_too_uncertain_from_above_is_known_from_nearby():
    rng = np.random.default_rng(4)
    elevation = ElevationMap(HERE)
    for _ in range(4):
        elevation.add(noisy(look_down((0.0, 0.0, 5.0)), rng, 0.006))
    assert "heights known to" in str(objection(assess(elevation, NEEDS), elevation, NEEDS, HERE))
    for _ in range(3):
        elevation.add(noisy(look_down((0.0, 0.0, 1.5)), rng, 0.006))
    assert safe_at(elevation, assess(elevation, NEEDS), 0.0, 0.0)


def test_a_low_step_shows_through_the_noise_on_the_way_down():
    rng = np.random.default_rng(6)
    step = box((0.5, 0.0, 0.03), (1.0, 4.0, 0.06))  # begins at x = 0
    elevation = ElevationMap(HERE)
    for height in (4.0, 3.6, 3.2, 2.8, 2.4, 2.0, 1.6, 1.4):
        elevation.add(noisy(look_down((0.0, 0.0, height), boxes=[step]), rng, 0.003))
    reason = str(objection(assess(elevation, NEEDS), elevation, NEEDS, HERE))
    assert re.match(r"(height range|slope|something rises)", reason)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("footprint_radius_m", 0.0),
        ("footprint_radius_m", 0.5),
        ("max_slope_rad", 0.0),
        ("max_slope_rad", 2.0),
    ],
)
def test_impossible_needs_are_refused_by_name(field, value):
    good = {"footprint_radius_m": 0.2, "body_radius_m": 0.4}
    with pytest.raises(ValueError, match=f"{field} {value} is not valid"):
        LandingNeeds(**(good | {field: value}))
