from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.areas.landing import PERCH_HEIGHT_M, AreaLimits, derive_interaction_areas
from aeroscene.areas.needs import LEGS_M, MAX_SLOPE_RAD, NEEDS, PERCH_NEEDS, STEP_M, area_needs
from aeroscene.areas.obstacles import Obstructions
from aeroscene.areas.spread import spread
from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw, quat_product
from aeroscene.scene.catalogue import LANDABLE, NO_PERCH, by_name
from aeroscene.solids.freespace import build_distance_field, reachable
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.solids import colliding
from tests.aeroscene.sampling_solids import any_holds, holds


def near(primitives, x, y, reach_m):
    solids = colliding(primitives)
    low = np.array([x - reach_m, y - reach_m, -np.inf])
    high = np.array([x + reach_m, y + reach_m, np.inf])
    return [solids.primitives[i] for i in solids.near(low, high)]


def disc(area, radius_m, heights):
    """Points at some heights above the plane of an area, on rings up to a radius."""
    x, y, z = area.centroid
    gradient, *_ = np.linalg.lstsq(
        np.array(area.polygon)[:, :2] - (x, y), np.array(area.polygon)[:, 2] - z
    )
    turns = np.linspace(0, 2 * math.pi, 12, endpoint=False)
    rings = [(0.0, 0.0)]
    for fraction in (0.5, 0.98):
        r = fraction * radius_m
        rings += [(r * math.cos(t), r * math.sin(t)) for t in turns]
    return np.array([(x + u, y + v, z + gradient @ (u, v) + h) for u, v in rings for h in heights])


def test_areas_bear_are_clear_and_leave_room_for_their_class(scene):
    primitives = scene_primitives(scene)
    for area in scene.interaction_areas:
        needs = area_needs(area)
        x, y, _ = area.centroid
        around = near(primitives, x, y, 4.0)
        if area.object_id is None:
            points = disc(area, area.radius, [0.0])
            off_m = points[:, 2] - scene.relief.height_m(*points[:, :2].T)
            assert np.abs(off_m).max() < 0.006, area
        else:
            own = [p for p in around if p.object_id == area.object_id]
            assert any_holds(own, disc(area, area.radius, [-0.004])).all(), area
        above = np.linspace(STEP_M + 0.001, needs.clearance_m - 0.01, 9)
        assert not any_holds(around, disc(area, area.radius, above)).any(), area
        body_m = max(area.radius, needs.body_radius_m)
        rotors = np.linspace(LEGS_M + 0.001, needs.clearance_m - 0.01, 7)
        assert not any_holds(around, disc(area, body_m - 0.01, rotors)).any(), area
        assert area.radius >= needs.surface_radius_m


def test_polygons_are_plane_of_their_slope_and_hold_the_circle(scene):
    for area in scene.interaction_areas:
        offset = np.array(area.polygon) - area.centroid
        gradient, *_ = np.linalg.lstsq(offset[:, :2], offset[:, 2])
        assert np.abs(offset[:, :2] @ gradient - offset[:, 2]).max() < 3e-4
        assert math.atan(np.hypot(*gradient)) == pytest.approx(area.slope_rad, abs=1e-3)
        assert area.slope_rad <= MAX_SLOPE_RAD + 1e-5
        middle = np.mean(area.polygon, axis=0)
        assert np.linalg.norm(middle - area.centroid) < 0.05
        assert area.clearance_m >= area_needs(area).clearance_m


def test_areas_are_reached_from_the_start_by_their_class(scene):
    field = build_distance_field(scene)
    for needs in (*NEEDS.values(), PERCH_NEEDS):
        flooded = reachable(field, scene.start_position_enu_m, needs.flight_radius_m)
        for area in scene.interaction_areas:
            if area_needs(area) is needs:
                i, j, k = field.cell(area.centroid)
                assert flooded[i, j, k : k + 7].any(), area


def test_areas_do_not_overlap(scene):
    places = [(area.object_id, area) for area in scene.interaction_areas]
    for index, (bearer, area) in enumerate(places):
        for other_bearer, other in places[index + 1 :]:
            if bearer == other_bearer and abs(area.centroid[2] - other.centroid[2]) < 0.1:
                apart = math.dist(area.centroid, other.centroid)
                assert apart >= area.radius + other.radius - 0.001


def test_landing_areas_lie_on_categories_that_may_carry_a_drone(scene):
    for area in scene.landing_areas:
        bearer = scene.object_by_id.get(area.object_id)
        assert scene.relief is not None if bearer is None else bearer.category in LANDABLE


def test_perches_are_small_high_and_on_nothing_soft(scene):
    for area in scene.perching_areas:
        bearer = scene.object_by_id[area.object_id]
        assert bearer.category not in NO_PERCH
        assert area.drone_class == "small"
        foot_m = bearer.bbox.p[2] - bearer.bbox.s[2] / 2
        assert area.centroid[2] - foot_m >= PERCH_HEIGHT_M


def test_every_scene_has_areas_far_from_the_start_for_both_vehicles(scene):
    least_m = 8 if scene.domain == "indoor" else 15

    def is_far(area: InteractionArea) -> bool:
        return math.dist(area.centroid, scene.start_position_enu_m) >= least_m

    far = Counter(area.drone_class for area in scene.landing_areas if is_far(area))
    assert far["medium"] + far["large"] >= 2
    assert far["small"] >= 4


def test_limits_keep_a_well_spread_part_of_all(scene_42):
    limits = AreaLimits(small=12, medium=4, large=2, perching=3)
    primitives = scene_primitives(scene_42)
    every = derive_interaction_areas(scene_42, primitives)
    kept = derive_interaction_areas(scene_42, primitives, limits=limits)
    counts = Counter((area.kind, area.drone_class) for area in kept)
    assert counts["landing", "small"] == 12
    assert counts["landing", "medium"] == 4
    assert counts["landing", "large"] == 2
    assert counts["perching", "small"] == 3
    assert {area.centroid for area in kept} <= {area.centroid for area in every}
    assert [area.id for area in kept] == list(range(len(kept)))
    assert kept == derive_interaction_areas(scene_42, primitives, limits=limits)
    small = [a.centroid for a in every if a.kind == "landing" and a.drone_class == "small"]
    chosen = [a.centroid for a in kept if a.kind == "landing" and a.drone_class == "small"]
    rng = np.random.default_rng(0)
    by_chance = [
        least_distance([small[i] for i in rng.choice(len(small), 12, replace=False)])
        for _ in range(30)
    ]
    assert least_distance(chosen) > np.median(by_chance)


def test_landing_pads_are_kept_whatever_the_limits():
    pads = [("landing_pad", (x, 8.0, 0.05), (3.0, 3.0, 0.1)) for x in (-6.0, 0.0)]
    decks = [("deck", (x, y, 0.25), (3.0, 3.0, 0.5)) for x in (-12.0, 6.0, 12.0) for y in (-8, 12)]
    scene = simple_scene(*decks, *pads)
    limits = AreaLimits(small=0, medium=3, large=0, perching=0)
    found = derive_interaction_areas(scene, limits=limits)
    assert len(found) == 3
    assert {area.object_id for area in found} >= {6, 7}


def least_distance(places):
    return min(math.dist(a, b) for i, a in enumerate(places) for b in places[i + 1 :])


@given(
    st.lists(st.tuples(*[st.floats(-50, 50)] * 3), min_size=1, max_size=30, unique=True),
    st.integers(0, 35),
)
def test_spreading_takes_the_farthest_of_those_that_come_to_something(places, limit):
    chosen = spread(places, (0.0, 0.0, 0.0), limit, lambda i: None if i % 3 == 0 else i)
    assert len(chosen) == min(limit, sum(i % 3 != 0 for i in range(len(places))))
    assert len(set(chosen)) == len(chosen)
    left = [i for i in range(len(places)) if i % 3]
    for turn, index in enumerate(chosen):
        references = [places[i] for i in chosen[:turn]] or [(0.0, 0.0, 0.0)]
        reach = [min(math.dist(places[i], r) for r in references) for i in left]
        assert min(math.dist(places[index], r) for r in references) >= max(reach) - 1e-9
        left.remove(index)


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


def landing_areas(scene):
    return [area for area in derive_interaction_areas(scene) if area.kind == "landing"]


def test_a_free_table_is_a_small_area_with_its_whole_top():
    scene = simple_scene(("table", (0.0, 0.0, 0.375), (1.0, 2.0, 0.75)))
    (area,) = derive_interaction_areas(scene)
    assert area.centroid == (0.0, 0.0, 0.75)
    assert area.radius == pytest.approx(0.5, abs=0.002)
    assert area.drone_class == "small"
    assert area.clearance_m == 11.25
    assert len(area.polygon) == 4


def test_what_stands_on_a_table_or_hangs_over_it_takes_the_area_away():
    table = ("table", (0.0, 0.0, 0.375), (1.0, 1.0, 0.75))
    assert len(landing_areas(simple_scene(table))) == 1
    lamp = ("lamp", (0.0, 0.0, 1.0), (0.3, 0.3, 0.5))
    assert landing_areas(simple_scene(table, lamp)) == []
    low_roof = ("canopy", (0.0, 0.0, 1.1), (4.0, 4.0, 2.2))
    found = landing_areas(simple_scene(table, low_roof))
    assert [area.object_id for area in found] == [1]


def test_a_surface_that_nobody_can_reach_is_no_area():
    pad = ("landing_pad", (5.0, 5.0, 0.05), (3.0, 3.0, 0.1))
    walls = [
        ("wall", (5.0 + dx, 5.0 + dy, 3.0), (sx, sy, 6.0))
        for dx, dy, sx, sy in ((4, 0, 0.3, 8.3), (-4, 0, 0.3, 8.3), (0, 4, 8, 0.3), (0, -4, 8, 0.3))
    ]
    lid = ("wall", (5.0, 5.0, 6.2), (8.6, 8.6, 0.4))
    assert [a.drone_class for a in landing_areas(simple_scene(pad, *walls))] == ["medium"]
    assert landing_areas(simple_scene(pad, *walls, lid)) == []


@pytest.mark.parametrize(
    ("side_m", "drone_class"), [(1.0, "small"), (2.2, "small"), (2.6, "medium"), (5.6, "large")]
)
def test_the_class_is_the_largest_that_fits(side_m, drone_class):
    deck = ("deck", (0.0, 0.0, 0.25), (side_m, side_m, 0.5))
    best = landing_areas(simple_scene(deck))[0]
    assert best.drone_class == drone_class


def test_a_car_bears_one_area_on_its_roof():
    scene = simple_scene(("car", (0.0, 0.0, 0.75), (4.5, 1.9, 1.5)))
    (area,) = derive_interaction_areas(scene)
    assert area.centroid[2] == 1.5


def test_open_sky_is_preferred_to_a_spot_below_something():
    lawn = ("lawn", (0.0, 0.0, 0.03), (20.0, 20.0, 0.06))
    canopy = ("canopy", (0.0, 0.0, 2.0), (8.0, 8.0, 4.0))
    found = landing_areas(simple_scene(lawn, canopy))
    on_lawn = [area for area in found if area.object_id == 0]
    assert on_lawn
    for area in on_lawn:
        x, y, _ = area.centroid
        assert math.hypot(max(abs(x) - 4, 0), max(abs(y) - 4, 0)) >= area.radius
    assert all(area.clearance_m > 11 for area in on_lawn)


def block(position, quat_wxyz, size, kind="box", object_id=0, vertices=()):
    return Primitive(
        kind=kind,
        position_enu_m=position,
        quat_wxyz=quat_wxyz,
        size_m=size,
        material="wood",
        object_id=object_id,
        collides=True,
        vertices_m=vertices,
    )


def leaning(slope_rad, yaw_rad):
    """Attitude of a slab that rises towards its own x axis, which heads to a yaw."""
    turn = (math.cos(slope_rad / 2), 0.0, -math.sin(slope_rad / 2), 0.0)
    return quat_product(quat_from_yaw(yaw_rad), turn)


BOARD = ("deck", (0.0, 0.0, 1.0), (3.0, 3.0, 0.5))


@given(st.floats(math.radians(0.5), MAX_SLOPE_RAD), st.floats(-3.1, 3.1))
@settings(max_examples=12, deadline=None)
def test_a_leaning_slab_bears_an_area_of_its_slope(slope_rad, yaw_rad):
    slab = block((0.0, 0.0, 1.0), leaning(slope_rad, yaw_rad), (3.0, 3.0, 0.2))
    (area,) = derive_interaction_areas(simple_scene(BOARD), [slab])
    assert area.kind == "landing"
    assert area.drone_class == "medium"
    assert area.slope_rad == pytest.approx(slope_rad, abs=1e-4)
    assert holds(slab, disc(area, area.radius, [-0.002])).all()
    assert not holds(slab, disc(area, area.radius, [0.002])).any()


@pytest.mark.parametrize("kind", ["box", "mesh", "cylinder"])
def test_what_leans_by_more_than_ten_degrees_bears_nothing(kind):
    corners = tuple((x, y, z) for x in (-1.5, 1.5) for y in (-1.5, 1.5) for z in (-0.1, 0.1))
    for slope_deg, n_areas in ((9.9, 1), (10.2, 0)):
        quat = leaning(math.radians(slope_deg), 0.4)
        size = (3.0, 3.0, 0.2)
        slab = block((0.0, 0.0, 1.0), quat, size, kind, vertices=corners if kind == "mesh" else ())
        assert len(derive_interaction_areas(simple_scene(BOARD), [slab])) == n_areas


def ramp(length_m, rise_m):
    half = length_m / 2
    return tuple((x, y, z) for x, z in ((-half, 0.0), (half, 0.0), (half, rise_m)) for y in (-3, 3))


def test_a_ramp_bears_on_its_slope_and_what_stands_on_it_is_in_the_way():
    wedge = block(
        (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (12.0, 6.0, 1.5), "mesh", vertices=ramp(12.0, 1.5)
    )
    scene = simple_scene(("terrain", (0.0, 0.0, 0.75), (12.0, 6.0, 1.5)), BOARD)
    free = derive_interaction_areas(scene, [wedge])
    assert {area.slope_rad for area in free} == {round(math.atan(1.5 / 12), 5)}
    assert max(area.radius for area in free) > 2.6
    # A crate whose foot is sunk into the hill; only its upper part is seen.
    crate = block((0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.2), object_id=1)
    found = derive_interaction_areas(scene, [wedge, crate])
    on_slope = [area for area in found if area.object_id == 0]
    assert on_slope
    for area in on_slope:
        assert not holds(crate, disc(area, area.radius, np.linspace(0.02, 1.4, 8))).any()
    on_crate = [area for area in found if area.object_id == 1]
    assert [area.centroid[2] for area in on_crate] == [1.6]


def test_a_bench_and_a_wall_top_are_perches_and_a_thin_wall_is_none():
    bench = ("bench", (0.0, 0.0, 0.225), (0.5, 2.0, 0.45))
    wall = ("wall", (6.0, 0.0, 1.0), (0.5, 6.0, 2.0))
    thin = ("wall", (-6.0, 0.0, 1.0), (0.3, 6.0, 2.0))
    seat = block((0.0, 0.0, 0.225), (1.0, 0.0, 0.0, 0.0), (0.5, 2.0, 0.45), object_id=0)
    stones = [
        block(p, (1.0, 0.0, 0.0, 0.0), s, object_id=number)
        for number, (_, p, s) in enumerate((wall, thin), 1)
    ]
    areas = derive_interaction_areas(simple_scene(bench, wall, thin), [seat, *stones])
    assert {(area.object_id, area.kind, area.centroid[2]) for area in areas} == {
        (0, "perching", 0.45),
        (1, "perching", 2.0),
    }
    assert all(area.radius >= PERCH_NEEDS.surface_radius_m for area in areas)


def test_a_wide_face_of_a_building_is_no_perch():
    roof = ("building", (0.0, 0.0, 3.0), (10.0, 10.0, 6.0))
    top = block((0.0, 0.0, 3.0), (1.0, 0.0, 0.0, 0.0), (10.0, 10.0, 6.0))
    assert derive_interaction_areas(simple_scene(roof), [top]) == ()


def test_what_is_seen_edge_on_takes_nothing_from_a_face():
    outline = shapely.box(0, 0, 4, 4)
    edge_on = shapely.LineString([(1, 1), (3, 1)])
    crate = shapely.box(2, 2, 3, 3)
    taken = Obstructions(np.array([edge_on, crate]), np.zeros(2), np.ones(2))
    assert taken.subtracted_from(outline).area == pytest.approx(15.0)
    assert taken.cleared_from(outline, 0.5, 0.1).area < 15.0
