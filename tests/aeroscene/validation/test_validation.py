from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.areas.reachability import FIELD_CAP_M
from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id
from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import Solids, colliding
from aeroscene.validation import validate
from aeroscene.validation.boxes import outside, overlaps
from aeroscene.validation.columns import spans
from tests.aeroscene.sampling_solids import holds
from tests.aeroscene.solids.test_voxels import primitives
from tests.flightsim.handmade import incline, relief_scene

LAWN, TABLE, CHAIR, CAR, CRATE, WALL, DECK = range(7)


def thing(number, category, p, s, parent=None, yaw_rad=0.0):
    return SceneObject(
        id=number,
        scene_id="garden",
        parent_id=parent,
        category_id=category_id(category),
        bbox=OrientedBox(p, quat_from_yaw(yaw_rad), s),
        domain="outdoor",
        attributes={"form": "hedge"} if category == "fence" else {},
    )


OBJECTS = (
    thing(LAWN, "lawn", (0.0, 0.0, 0.05), (26.0, 26.0, 0.1)),
    thing(TABLE, "table", (4.0, 0.0, 0.475), (1.2, 2.0, 0.75), LAWN, 0.3),
    thing(CHAIR, "chair", (5.5, 0.0, 0.55), (0.5, 0.5, 0.9), LAWN, 2.0),
    thing(CAR, "car", (-6.0, 4.0, 0.85), (4.4, 1.8, 1.5), LAWN, 1.0),
    thing(CRATE, "crate", (6.0, 6.0, 0.6), (1.0, 1.0, 1.0), LAWN),
    thing(WALL, "wall", (0.0, -9.0, 1.1), (0.3, 6.0, 2.0), LAWN),
    thing(DECK, "deck", (-6.0, -5.0, 0.35), (4.0, 4.0, 0.5), LAWN),
)


def garden(objects=OBJECTS):
    scene = Scene(
        scene_id="garden",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-15.0, -15.0, 0.0),
        extent_max_enu_m=(15.0, 15.0, 12.0),
        start_position_enu_m=(0.0, 6.0, 0.1),
        start_yaw_rad=0.0,
        latitude_deg=0.0,
        longitude_deg=0.0,
        altitude_m=0.0,
        objects=tuple(objects),
    )
    return replace(scene, interaction_areas=derive_interaction_areas(scene))


@pytest.fixture(scope="module")
def sound():
    return garden()


def with_box(scene, number, p, q=None):
    """The scene with one object elsewhere and its areas as they were."""
    objects = list(scene.objects)
    box = objects[number].bbox
    objects[number] = replace(objects[number], bbox=OrientedBox(p, q or box.q, box.s))
    return replace(scene, objects=tuple(objects))


def area_on(scene, bearer, kind="landing"):
    return next(a for a in scene.interaction_areas if (a.object_id, a.kind) == (bearer, kind))


def with_area(scene, area, **changes):
    areas = [replace(a, **changes) if a is area else a for a in scene.interaction_areas]
    return replace(scene, interaction_areas=tuple(areas))


def details(scene, kind):
    return [finding.detail for finding in validate(scene) if finding.kind == kind]


def test_a_sound_scene_has_no_findings(sound):
    assert {area.object_id for area in sound.landing_areas} >= {LAWN, TABLE, CAR, CRATE, DECK}
    assert validate(sound) == ()


def test_corpus_scenes_of_all_domains_keep_what_their_areas_claim(scenes):
    assert {scene.domain for scene in scenes} == {"indoor", "outdoor", "mixed"}
    for scene in scenes:
        assert [f for f in validate(scene) if f.area_id is not None] == []


def test_a_box_moved_into_another_overlaps(sound):
    (finding,) = [
        f for f in validate(with_box(sound, CHAIR, (4.2, 0.3, 0.55))) if f.kind == "overlap"
    ]
    assert finding.object_id == CHAIR
    assert finding.scene_id == "garden"
    assert "chair 2 and table 1 overlap with an IoU of 0." in finding.detail


def test_a_tilted_box_is_judged_too(sound):
    q = (math.cos(0.2), 0.0, math.sin(0.2), 0.0)
    assert details(with_box(sound, CHAIR, (4.2, 0.3, 0.6), q), "overlap")
    assert not details(with_box(sound, CHAIR, (8.2, 0.3, 0.6), q), "overlap")


def test_what_a_parent_holds_is_no_overlap():
    drawer = thing(7, "box", (4.0, 0.0, 0.475), (0.5, 0.5, 0.6), TABLE)
    assert details(garden((*OBJECTS, drawer)), "overlap") == []
    stranger = replace(drawer, parent_id=LAWN)
    assert len(details(garden((*OBJECTS, stranger)), "overlap")) == 1


@pytest.mark.parametrize("lift_m", [0.03, 0.3, 2.0])
def test_a_lifted_chair_floats(sound, lift_m):
    (detail,) = details(with_box(sound, CHAIR, (5.5, 0.0, 0.55 + lift_m)), "floating")
    assert detail == (
        f"chair 2 has its feet at {0.1 + lift_m:.2f} m, {lift_m:.2f} m above what is below; "
        "valid: at most 0.02 m"
    )


def test_a_gap_below_two_centimetres_is_none(sound):
    assert details(with_box(sound, CHAIR, (5.5, 0.0, 0.56)), "floating") == []


def test_half_over_an_edge_does_not_stand():
    on_deck = thing(7, "crate", (-6.0, -5.0, 1.0), (0.8, 0.8, 0.8), DECK)
    assert details(garden((*OBJECTS, on_deck)), "floating") == []
    over_edge = thing(7, "crate", (-3.9, -5.0, 1.0), (0.8, 0.8, 0.8), DECK)
    (detail,) = details(garden((*OBJECTS, over_edge)), "floating")
    assert "with their middle 0.10 m beside what bears them" in detail


def test_a_part_of_a_building_may_hang_from_its_side_but_not_in_the_air():
    block = thing(7, "building", (8.0, -8.0, 4.1), (6.0, 6.0, 8.0), LAWN)
    gallery = thing(8, "floor", (3.5, -8.0, 3.1), (3.1, 3.0, 0.2), 7)
    assert details(garden((*OBJECTS, block, gallery)), "floating") == []
    away = replace(gallery, bbox=replace(gallery.bbox, p=(2.5, -8.0, 3.1)))
    assert len(details(garden((*OBJECTS, block, away)), "floating")) == 1


def test_what_stands_on_a_leaning_or_sunk_foot_stands():
    hill = thing(7, "terrain", (8.0, -8.0, 0.75), (10.0, 8.0, 1.3), LAWN)
    hill = replace(hill, attributes={"form": "ramp"})
    slope = 1.3 / 10.0
    # Sunk uphill: the downhill edge stands at the height of the ground there.
    crate = thing(8, "crate", (8.0, -8.0, 0.1 + slope * 4.5 + 0.5), (1.0, 1.0, 1.0), 7)
    assert details(garden((*OBJECTS, hill, crate)), "floating") == []
    lifted = replace(crate, bbox=replace(crate.bbox, p=(8.0, -8.0, 0.1 + slope * 5.5 + 0.55)))
    assert len(details(garden((*OBJECTS, hill, lifted)), "floating")) == 1


def test_a_car_beyond_the_extent_is_outside(sound):
    (finding,) = [
        f for f in validate(with_box(sound, CAR, (-14.0, 4.0, 0.85))) if f.kind == "outside"
    ]
    assert finding.object_id == CAR
    assert "car 3 reaches 0.946 m beyond the extent along x" in finding.detail


def walls_around(x, y):
    sides = ((1.5, 0.0), (-1.5, 0.0), (0.0, 1.5), (0.0, -1.5))
    found = [
        thing(
            10 + n, "wall", (x + dx, y + dy, 2.1), (0.3, 3.3, 4.0), LAWN, 0.0 if dx else math.pi / 2
        )
        for n, (dx, dy) in enumerate(sides)
    ]
    lid = thing(14, "wall", (x, y, 4.25), (3.4, 3.4, 0.3), LAWN)
    return [*found, lid]


def test_an_area_that_is_walled_off_is_unreachable(sound):
    area = area_on(sound, CRATE)
    closed = replace(sound, objects=(*sound.objects, *walls_around(6.0, 6.0)))
    found = [f for f in validate(closed) if f.kind == "unreachable"]
    assert (area.id, CRATE) in {(f.area_id, f.object_id) for f in found}
    assert "no free way for a ball of 0.45 m from the start" in found[0].detail


def test_a_start_that_is_walled_in_reaches_nothing(sound):
    crate = thing(20, "crate", (0.0, 6.0, 0.7), (1.4, 1.4, 1.2), LAWN)
    shut = replace(sound, objects=(*sound.objects, crate, *walls_around(0.0, 6.0)))
    found = [f for f in validate(shut) if f.kind == "unreachable"]
    assert found[0].area_id is None or len(found) == len(sound.interaction_areas)
    lid = thing(21, "building", (0.0, 6.0, 3.0), (4.0, 4.0, 6.0), LAWN)
    buried = replace(sound, objects=(*sound.objects, lid))
    starts = [f for f in validate(buried) if f.kind == "unreachable" and f.area_id is None]
    assert "start (0.0, 6.0, 0.1) has no free ball" in starts[0].detail


def test_a_crate_on_an_area_makes_it_unlandable(sound):
    area = area_on(sound, DECK)
    x, y, z = area.centroid
    crate = thing(30, "wall", (x + 0.5, y, z + 0.3), (0.4, 1.0, 0.6), DECK)
    found = [
        f for f in validate(replace(sound, objects=(*sound.objects, crate))) if f.area_id == area.id
    ]
    assert {f.kind for f in found} == {"unlandable"}
    assert "wall 30 stands on it 0.30 m from the middle" in found[0].detail


def test_a_post_beside_a_small_area_leaves_no_room_for_the_body(sound):
    area = area_on(sound, CRATE)
    x, y, _ = area.centroid
    post = thing(30, "wall", (x + 0.55, y, 1.1), (0.08, 1.0, 2.0), LAWN)
    found = details(replace(sound, objects=(*sound.objects, post)), "unlandable")
    assert any("wall 30 stands 0.51 m from the middle; valid: from 0.60 m" in d for d in found)


def test_a_roof_over_an_area_refutes_its_clearance(sound):
    area = area_on(sound, TABLE)
    x, y, z = area.centroid
    roof = thing(30, "canopy", (x, y, 2.0 + z), (5.0, 5.0, 4.0), LAWN)
    found = details(replace(sound, objects=(*sound.objects, roof)), "unlandable")
    assert any("canopy 30 hangs 3." in detail for detail in found)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"slope_rad": 0.1}, "slope_rad is 0.1000, its polygon leans by 0.0000 rad"),
        ({"slope_rad": 0.3}, "slope_rad is 0.3000; valid: at most 0.1745"),
        ({"drone_class": "large"}, "valid: from 2.6 m"),
        ({"object_id": CAR}, "car 3 has no face there at"),
        ({"object_id": None}, "the ground has no face there at"),
        ({"clearance_m": 1.2}, "clearance_m is 1.2; valid: from 1.5"),
    ],
)
def test_a_claim_that_is_changed_is_refuted(sound, changes, expected):
    found = details(with_area(sound, area_on(sound, TABLE), **changes), "unlandable")
    assert any(expected in detail for detail in found), found


def test_an_area_beside_or_above_its_face_is_refuted(sound):
    area = area_on(sound, TABLE)
    for shift in ((0.2, 0.0, 0.0), (0.0, 0.0, 0.05), (0.0, 0.0, -0.05)):
        moved = {
            "polygon": tuple(tuple(np.add(v, shift).tolist()) for v in area.polygon),
            "centroid": tuple(np.add(area.centroid, shift).tolist()),
        }
        found = details(with_area(sound, area, **moved), "unlandable")
        assert any("table 1 has no face there at" in detail for detail in found), shift


def test_a_tilted_polygon_is_refuted(sound):
    area = area_on(sound, DECK)
    x = area.centroid[0]
    tilted = tuple((u, v, w + 0.1 * (u - x)) for u, v, w in area.polygon)
    found = details(with_area(sound, area, polygon=tilted), "unlandable")
    assert any("its polygon leans by 0.09" in detail for detail in found)
    assert any("has no face there" in detail for detail in found)
    bent = ((*area.polygon[0][:2], area.polygon[0][2] + 0.3), *area.polygon[1:])
    found = details(with_area(sound, area, polygon=bent), "unlandable")
    assert any("off a plane through the centroid" in detail for detail in found)


def test_the_ground_bears_areas_at_height_zero():
    scene = replace(garden(()), start_position_enu_m=(0.0, 6.0, 0.0))
    area = InteractionArea(
        id=0,
        object_id=None,
        polygon=((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)),
        centroid=(0.0, 0.0, 0.0),
        radius=1.0,
        drone_class="small",
        slope_rad=0.0,
        clearance_m=12.0,
        surface="grass",
    )
    assert validate(replace(scene, interaction_areas=(area,))) == ()


def test_findings_of_a_corpus_scene_that_is_shaken(scene_42):
    rng = np.random.default_rng(1)
    objects = []
    for obj in scene_42.objects:
        p = tuple((np.array(obj.bbox.p) + rng.normal(0.0, 0.5, 3)).tolist())
        objects.append(replace(obj, bbox=replace(obj.bbox, p=p)))
    counts = Counter(f.kind for f in validate(replace(scene_42, objects=tuple(objects))))
    assert counts["floating"] > 30
    assert counts["unlandable"] > 30
    assert counts["overlap"] > 5


@given(primitives(), st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_vertical_lines_enter_and_leave_solids_where_they_should(primitive, seed):
    rng = np.random.default_rng(seed)
    lines = np.array(primitive.position_enu_m[:2]) + rng.uniform(-1.2, 1.2, (40, 2))
    enter, leave = spans(Solids([primitive]), 0, lines).T
    is_hit = np.isfinite(enter)
    heights = np.linspace(-3.5, 3.5, 141)
    for index, (x, y) in enumerate(lines):
        column = np.column_stack([np.full_like(heights, x), np.full_like(heights, y), heights])
        inside = holds(primitive, column)
        clearly = heights[inside & holds(primitive, column, grow_m=-0.001)]
        if not is_hit[index]:
            assert not len(clearly)
            continue
        assert np.all((clearly >= enter[index] - 1e-6) & (clearly <= leave[index] + 1e-6))
        within = (heights > enter[index] + 1e-6) & (heights < leave[index] - 1e-6)
        assert np.all(holds(primitive, column, grow_m=1e-6)[within])


def test_findings_name_the_scene(sound):
    broken = with_box(sound, CAR, (-14.0, 4.0, 0.85))
    assert {finding.scene_id for finding in validate(broken)} == {"garden"}


def test_primitives_and_distances_may_be_handed_over(sound):
    wall = replace(sound.object_by_id[CRATE], id=99)
    shut = replace(sound, objects=(*sound.objects, wall), start_position_enu_m=wall.bbox.p)
    for scene in (sound, shut):
        given_solids = scene_primitives(scene)
        field = build_distance_field(scene, primitives=given_solids, cap_m=FIELD_CAP_M)
        assert validate(scene, given_solids, field) == validate(scene)
    assert validate(shut) != ()
    given_solids = scene_primitives(sound)
    assert len(colliding(given_solids)) <= len(given_solids)


def test_a_box_with_its_middle_on_an_edge_of_another_is_not_held_by_its_corner(sound):
    table = sound.object_by_id[TABLE].bbox
    edge_m = table.p[0] + table.s[0] / 2
    z = table.p[2] + table.s[2] / 2
    floating = {}
    for beyond_m in (-0.1, 0.1):
        crate = thing(77, "box", (edge_m + beyond_m, table.p[1], z + 0.15), (0.3, 0.3, 0.3))
        found = validate(replace(sound, objects=(*sound.objects, crate)))
        floating[beyond_m] = [f for f in found if f.kind == "floating" and f.object_id == 77]
    assert floating[-0.1] == []
    assert len(floating[0.1]) == 1


def on_hill(bottom_m, size_m=(1.0, 1.0, 1.0)):
    """A crate on a slope of a tenth towards east, 10 m up, its middle where the ground is 11 m."""
    scene = relief_scene(incline(0.1, 0.0, height_m=10.0))
    box = OrientedBox((10.0, 0.0, bottom_m + size_m[2] / 2), (1.0, 0.0, 0.0, 0.0), size_m)
    crate = SceneObject(
        id=0,
        scene_id=scene.scene_id,
        parent_id=None,
        category_id=category_id("crate"),
        bbox=box,
        domain="outdoor",
    )
    return [f.kind for f in validate(replace(scene, objects=(crate,)))]


@pytest.mark.parametrize(
    ("bottom_m", "stands"),
    [(10.95, True), (10.5, True), (11.0, True), (11.03, False), (11.05, False), (12.0, False)],
)
def test_an_object_stands_on_the_relief_under_it(bottom_m, stands):
    """From 10.95 m all of it is on the ground; above 11.02 m its middle is beside what bears it."""
    assert ("floating" not in on_hill(bottom_m)) == stands


OUTLINE = "POLYGON ((-5 -4, 5 -4, 5 4, 0 4, 0 0, -5 0, -5 -4))"


def outlined(p):
    """A building of an L-shaped outline."""
    building = thing(10, "building", p, (10.0, 8.0, 6.0))
    return replace(building, attributes={"outline": OUTLINE})


def test_outlines_that_interlock_do_not_overlap_though_their_boxes_do(sound):
    first = outlined((0.0, 0.0, 3.0))
    beside = thing(11, "building", (-2.6, 2.1, 3.0), (4.8, 3.8, 6.0))
    assert not list(overlaps(replace(sound, objects=(first, beside), interaction_areas=())))
    within = thing(11, "building", (-2.6, 1.0, 3.0), (4.8, 3.8, 6.0))
    (finding,) = overlaps(replace(sound, objects=(first, within), interaction_areas=()))
    assert finding.object_id == 11


def test_an_outline_within_the_volume_is_not_outside_though_its_box_is(sound):
    turned = OrientedBox((11.0, 0.0, 3.0), quat_from_yaw(math.pi / 4), (10.0, 8.0, 6.0))
    square = "POLYGON ((-2 -2, 2 -2, 2 2, -2 2, -2 -2))"
    small = replace(outlined((0.0, 0.0, 3.0)), bbox=turned, attributes={"outline": square})
    assert not list(outside(replace(sound, objects=(small,), interaction_areas=())))
    whole = replace(small, attributes={})
    assert list(outside(replace(sound, objects=(whole,), interaction_areas=())))
