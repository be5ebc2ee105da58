from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from aeroscene.catalogue import by_name
from aeroscene.freespace import build_distance_field, reachable
from aeroscene.landing import CLEARANCE_M, NEEDS, STEP_M, derive_landing_areas
from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneObject
from aeroscene.shapes import scene_primitives
from aeroscene.voxels import bounds
from tests.aeroscene.solids import any_holds


def near(primitives, x, y, reach_m):
    found = []
    for primitive in primitives:
        low, high = bounds(primitive)
        if (
            primitive.collides
            and low[0] < x + reach_m
            and low[1] < y + reach_m
            and high[0] > x - reach_m
            and high[1] > y - reach_m
        ):
            found.append(primitive)
    return found


def disc(x, y, radius_m, heights):
    turns = np.linspace(0, 2 * math.pi, 12, endpoint=False)
    rings = [(x, y)]
    for fraction in (0.5, 0.98):
        r = fraction * radius_m
        rings += [(x + r * math.cos(t), y + r * math.sin(t)) for t in turns]
    plane = np.array(rings)
    return np.array([(px, py, z) for px, py in plane for z in heights])


def test_areas_bear_are_clear_and_leave_room_for_their_class(scene):
    primitives = scene_primitives(scene)
    for area in scene.interaction_areas:
        x, y, z = area.centroid
        needs = NEEDS[area.drone_class]
        around = near(primitives, x, y, 4.0)
        own = [p for p in around if p.object_id == area.object_id]
        bearing = disc(x, y, area.radius, [z - 0.004])
        assert any_holds(own, bearing).all(), area
        above = disc(x, y, area.radius, np.linspace(z + STEP_M + 0.001, z + CLEARANCE_M - 0.01, 9))
        assert not any_holds(around, above).any(), area
        body_m = max(area.radius, needs.body_radius_m)
        rotors = disc(x, y, body_m - 0.01, np.linspace(z + 0.1, z + CLEARANCE_M - 0.01, 7))
        assert not any_holds(around, rotors).any(), area
        assert area.radius >= needs.surface_radius_m - 0.001


def test_polygons_are_level_and_hold_the_circle(scene):
    for area in scene.interaction_areas:
        assert {vertex[2] for vertex in area.polygon} == {area.centroid[2]}
        assert area.slope_rad == 0.0
        middle = np.mean(area.polygon, axis=0)
        assert np.linalg.norm(middle - area.centroid) < 0.05
        assert area.clearance_m >= CLEARANCE_M


def test_areas_are_reached_from_the_start_by_their_class(scene):
    field = build_distance_field(scene)
    for name, needs in NEEDS.items():
        flood = reachable(field, scene.start_position_enu_m, needs.flight_radius_m)
        for area in scene.interaction_areas:
            if area.drone_class == name:
                i, j, k = field.cell(area.centroid)
                assert flood[i, j, k : k + 7].any(), area


def test_areas_do_not_overlap(scene):
    places = [(area.object_id, area) for area in scene.interaction_areas]
    for index, (bearer, area) in enumerate(places):
        for other_bearer, other in places[index + 1 :]:
            if bearer == other_bearer and abs(area.centroid[2] - other.centroid[2]) < 0.1:
                apart = math.dist(area.centroid, other.centroid)
                assert apart >= area.radius + other.radius


def test_bearers_are_categories_that_may_carry_a_drone(scene):
    for area in scene.interaction_areas:
        assert by_name()[scene.object_by_id[area.object_id].category].is_landable


def test_numbers_are_of_the_papers_order(scenes):
    counts = [Counter(area.drone_class for area in scene.interaction_areas) for scene in scenes]
    means = {name: np.mean([count[name] for count in counts]) for name in NEEDS}
    assert 30 <= means["small"] <= 55
    assert 8 <= means["medium"] <= 17
    assert 3.5 <= means["large"] <= 7.5


def test_every_scene_has_outdoor_areas_far_from_the_start_for_both_vehicles(scene):
    def is_far(area: InteractionArea) -> bool:
        is_outdoor = scene.object_by_id[area.object_id].domain == "outdoor"
        return is_outdoor and math.dist(area.centroid, scene.start_position_enu_m) >= 15

    far = Counter(area.drone_class for area in scene.interaction_areas if is_far(area))
    assert far["medium"] + far["large"] >= 4
    assert far["small"] >= 10


def simple_scene(*objects):
    """Some objects, as (category, centre, size), on the bare ground."""
    return Scene(
        scene_id="simple",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-15.0, -15.0, 0.0),
        extent_max_enu_m=(15.0, 15.0, 12.0),
        start_position_enu_m=(-10.0, -10.0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=0.0,
        longitude_deg=0.0,
        altitude_m=0.0,
        objects=tuple(
            SceneObject(
                id=number,
                scene_id="simple",
                parent_id=None,
                category_id=by_name()[name].id,
                bbox=OrientedBox(p, (1.0, 0.0, 0.0, 0.0), s),
                domain="outdoor",
                attributes={"form": "flat"},
            )
            for number, (name, p, s) in enumerate(objects)
        ),
    )


def test_a_free_table_is_a_small_area_with_its_whole_top():
    scene = simple_scene(("table", (0.0, 0.0, 0.375), (1.0, 2.0, 0.75)))
    (area,) = derive_landing_areas(scene)
    assert area.centroid == (0.0, 0.0, 0.75)
    assert area.radius == pytest.approx(0.5, abs=0.002)
    assert area.drone_class == "small"
    assert area.clearance_m == 11.25
    assert len(area.polygon) == 4


def test_what_stands_on_a_table_or_hangs_over_it_takes_the_area_away():
    table = ("table", (0.0, 0.0, 0.375), (1.0, 1.0, 0.75))
    assert len(derive_landing_areas(simple_scene(table))) == 1
    lamp = ("lamp", (0.0, 0.0, 1.0), (0.3, 0.3, 0.5))
    assert derive_landing_areas(simple_scene(table, lamp)) == ()
    low_roof = ("canopy", (0.0, 0.0, 1.1), (4.0, 4.0, 2.2))
    found = derive_landing_areas(simple_scene(table, low_roof))
    assert [area.object_id for area in found] == [1]


def test_a_surface_that_nobody_can_reach_is_no_area():
    pad = ("landing_pad", (5.0, 5.0, 0.05), (3.0, 3.0, 0.1))
    walls = [
        ("wall", (5.0 + dx, 5.0 + dy, 3.0), (sx, sy, 6.0))
        for dx, dy, sx, sy in ((4, 0, 0.3, 8.3), (-4, 0, 0.3, 8.3), (0, 4, 8, 0.3), (0, -4, 8, 0.3))
    ]
    lid = ("wall", (5.0, 5.0, 6.2), (8.6, 8.6, 0.4))
    assert [a.drone_class for a in derive_landing_areas(simple_scene(pad, *walls))] == ["medium"]
    assert derive_landing_areas(simple_scene(pad, *walls, lid)) == ()


@pytest.mark.parametrize(
    ("side_m", "drone_class"), [(1.0, "small"), (2.2, "small"), (2.6, "medium"), (5.6, "large")]
)
def test_the_class_is_the_largest_that_fits(side_m, drone_class):
    deck = ("deck", (0.0, 0.0, 0.25), (side_m, side_m, 0.5))
    (area,) = derive_landing_areas(simple_scene(deck))
    assert area.drone_class == drone_class


def test_a_car_bears_one_area_on_its_roof():
    scene = simple_scene(("car", (0.0, 0.0, 0.75), (4.5, 1.9, 1.5)))
    (area,) = derive_landing_areas(scene)
    assert area.centroid[2] == 1.5


def test_open_sky_is_preferred_to_a_spot_below_something():
    lawn = ("lawn", (0.0, 0.0, 0.03), (20.0, 20.0, 0.06))
    canopy = ("canopy", (0.0, 0.0, 2.0), (8.0, 8.0, 4.0))
    found = derive_landing_areas(simple_scene(lawn, canopy))
    on_lawn = [area for area in found if area.object_id == 0]
    assert on_lawn
    for area in on_lawn:
        x, y, _ = area.centroid
        assert math.hypot(max(abs(x) - 4, 0), max(abs(y) - 4, 0)) >= area.radius
    assert all(area.clearance_m > 11 for area in on_lawn)
