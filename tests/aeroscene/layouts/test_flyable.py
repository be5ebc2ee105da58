from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.areas.start import LEAST_RADIUS_M
from aeroscene.layouts import LayoutError
from aeroscene.layouts.flyable import make_flyable, map_layout
from aeroscene.layouts.house import build_house
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.layouts.site import FINISH_M, GROUND_M, our_box, survey
from aeroscene.scene.geometry import penetration_depth
from aeroscene.scene.io import scene_from_json, scene_to_json
from aeroscene.solids.freespace import build_distance_field, reachable
from aeroscene.solids.shapes import object_primitives
from tests.aeroscene.layouts.samples import block, box, house

unit = st.floats(-1, 1)
quaternions = (
    st.tuples(unit, unit, unit, unit)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: [v / math.hypot(*q) for v in q])
)


def fly(record):
    return make_flyable(neutral_layout(record))


def by_source(scene, name):
    return next(o for o in scene.objects if o.attributes.get("source_category") == name)


def test_a_house_has_floors_walls_a_roof_and_a_yard():
    scene, report = fly(house())
    assert scene.domain == "indoor"
    counts = Counter(obj.category for obj in scene.objects)
    assert (counts["room"], counts["roof"], counts["lawn"]) == (2, 1, 4)
    assert counts["wall"] == 7
    assert report.n_mapped == report.n_objects == 5
    assert scene_from_json(scene_to_json(scene)) == scene


def test_a_drone_gets_from_room_to_room_and_out():
    scene, _ = fly(house())
    field = build_distance_field(scene)
    free = reachable(field, scene.start_position_enu_m, 0.5)
    for place in [(-2.5, 0, 1.5), (2.5, 0, 1.5), (0, 6, 1.5), (0, 0, 5)]:
        cell = field.cell(place)
        assert cell is not None
        assert free[cell], place


@given(st.floats(1.69, 7.0), st.floats(0.0, 0.4))
def test_every_opening_is_open_whatever_the_wall(length_m, gap_m):
    record = house() | {"objects": []}
    for room, y in zip(record["attributes"]["rooms"], (0.0, 10.0 - length_m), strict=True):
        x = 0.0 if y == 0.0 else 5.0 + gap_m
        room["polygon"] = [[x, y], [x + 5, y], [x + 5, y + 10], [x, y + 10]]
    site = survey(neutral_layout(record | {"floor": [[0, 0], [10, 0], [10, 20], [0, 20]]}))
    build_house(site)
    doors = [obj for obj in site.assembly.objects if "door_m" in obj.attributes]
    assert len(doors) == 2
    for number, door in enumerate(doors):
        for wall in (door, replace(door, id=number), replace(door, id=number + 3)):
            width_m, offset_m = wall.attributes["door_m"], wall.attributes["door_offset_m"]
            assert width_m >= 1.6
            c, s = math.cos(wall.bbox.yaw_rad), math.sin(wall.bbox.yaw_rad)
            x, y, _ = wall.bbox.p
            middle = (x - s * offset_m, y + c * offset_m, FINISH_M + 1.1)
            size = (0.5, width_m - 0.02, 2.18)
            for solid in object_primitives(wall):
                if solid.collides:
                    depth = penetration_depth(
                        middle,
                        wall.bbox.q,
                        size,
                        solid.position_enu_m,
                        solid.quat_wxyz,
                        solid.size_m,
                    )
                    assert depth <= 0.001


def test_children_keep_their_parents_and_the_rest_belongs_to_its_room():
    scene, _ = fly(house())
    mug, table, bed = (by_source(scene, name) for name in ("Mug", "DiningTable", "Bed"))
    assert mug.parent_id == table.id
    assert scene.object_by_id[table.parent_id].attributes["room_type"] == "Kitchen"
    assert scene.object_by_id[bed.parent_id].attributes["room_type"] == "Bedroom"


def test_a_child_of_an_unmapped_object_goes_to_the_nearest_kept_ancestor():
    record = house()
    record["objects"][1:1] = [box("Xyzzy", (-3.5, 2, 0.8), (0.3, 0.3, 0.1), parent=0)]
    record["objects"][2]["parent"] = 1
    scene, report = fly(record)
    assert by_source(scene, "Mug").parent_id == by_source(scene, "DiningTable").id
    assert report.unmapped == {"Xyzzy": 1}
    assert report.unmapped_lines[0].startswith("scene 'made-up/house-1': object 1: category is")


def test_buildings_stand_on_grass_and_carry_roofs_to_land_on():
    scene, report = fly(block())
    assert scene.domain == "outdoor"
    assert report.by_category == {"building": 1, "garage": 1, "house": 2}
    roofs = [obj for obj in scene.objects if obj.category == "roof"]
    assert len(roofs) == 3
    landed = {area.object_id for area in scene.landing_areas}
    assert landed >= {roof.id for roof in roofs}
    tall = by_source(scene, "building")
    assert tall.bbox.p[2] - tall.bbox.s[2] / 2 == pytest.approx(GROUND_M)
    (roof,) = scene.children_by_id[tall.id]
    assert roof.bbox.p[2] + roof.bbox.s[2] / 2 == pytest.approx(5 + GROUND_M)


def test_the_start_is_free_and_on_the_ground():
    for record, ground_m in ((house(), FINISH_M), (block(), GROUND_M)):
        scene, _ = fly(record)
        x, y, z = scene.start_position_enu_m
        assert z == ground_m
        for obj in scene.objects:
            if obj.category in {"lawn", "room", "roof"}:
                continue
            outline = obj.bbox.corners()[:, :2]
            if obj.bbox.is_upright:
                c, s = math.cos(obj.bbox.yaw_rad), math.sin(obj.bbox.yaw_rad)
                dx, dy = x - obj.bbox.p[0], y - obj.bbox.p[1]
                u, v = abs(c * dx + s * dy), abs(c * dy - s * dx)
                gap = math.hypot(max(u - obj.bbox.s[0] / 2, 0), max(v - obj.bbox.s[1] / 2, 0))
                assert gap > LEAST_RADIUS_M - 0.1, (obj.category, outline)


def test_a_room_too_full_to_start_in_is_started_from_its_yard():
    record = house()
    record["objects"] = [box("Wardrobe", (0, 0, 1), (9.8, 5.8, 2))]
    scene, _ = fly(record)
    x, y, _ = scene.start_position_enu_m
    assert abs(x) > 5 or abs(y) > 3
    assert scene.landing_areas


def test_a_field_too_full_to_start_on_is_refused():
    record = block()
    record["objects"] = [box("building", (0, 0, 3), (61, 61, 6))]
    with pytest.raises(LayoutError, match="'made-up/block-1': floor has no free place to start"):
        fly(record)


def test_nothing_mapped_is_an_error_naming_scene_object_and_field():
    record = house()
    record["objects"] = [box("Xyzzy", (0, 0, 1), (1, 1, 1))]
    with pytest.raises(LayoutError) as caught:
        map_layout(neutral_layout(record))
    assert "scene 'made-up/house-1': " in str(caught.value)
    assert "object 0: category is 'Xyzzy'; valid: " in str(caught.value)


def test_a_layout_without_objects_is_an_empty_place():
    scene, report = fly(house() | {"objects": []})
    assert report.n_objects == 0
    assert scene.landing_areas


def test_what_cannot_be_used_is_dropped_with_its_reason():
    record = house()
    record["objects"] += [
        box("Chair", (40, 0, 0.5), (0.5, 0.5, 1)),
        box("Chair", (0, 0, -2), (0.5, 0.5, 1)),
        box("Chair", (0, 0, 9), (0.5, 0.5, 1)),
        box("Chair", (0, 0, 1), (900, 0.5, 1)),
    ]
    scene, report = fly(record)
    assert report.dropped == {
        "outside the ground": 1,
        "below the floor": 1,
        "above the ceiling": 1,
        "larger than the ground may be": 1,
    }
    assert sum("Chair" in str(obj.attributes) for obj in scene.objects) == 0


def test_a_large_field_is_cropped_about_its_objects():
    record = block()
    record["floor"] = [[-400, -400], [400, -400], [400, 400], [-400, 400]]
    for obj in record["objects"]:
        obj["p"][0] += 300
    scene, report = fly(record)
    assert report.n_mapped == 4
    sides = np.subtract(scene.extent_max_enu_m, scene.extent_min_enu_m)
    assert sides[0] <= 180
    assert sides[1] <= 180


def test_a_house_larger_than_can_be_searched_is_refused():
    record = house()
    record["floor"] = [[-400, -3], [400, -3], [400, 3], [-400, 3]]
    with pytest.raises(LayoutError, match=r"floor is 800\.0 m long; valid: at most 160 m"):
        fly(record)


@given(quaternions, st.tuples(*[st.floats(0.01, 5)] * 3), st.sampled_from("xy"))
def test_our_box_fills_the_same_space_as_theirs(q, s, front):
    obj = neutral_layout(
        house() | {"objects": [{"category": "Bed", "p": [1, 2, 3], "q": q, "s": list(s)}]}
    ).objects[0]
    ours = our_box(obj, front, 0.02)
    theirs = our_box(obj, "x", 0.0)
    expected = theirs.corners() + (0, 0, 0.02)
    gaps = np.linalg.norm(ours.corners()[:, None] - expected[None], axis=-1)
    assert gaps.min(axis=0).max() < 1e-3
    assert gaps.min(axis=1).max() < 1e-3
    if front == "y":
        # Their +y face and our +x face have the same middle.
        face = theirs.corners()[[2, 3, 6, 7]].mean(axis=0) + (0, 0, 0.02)
        assert np.allclose(ours.corners()[[1, 3, 5, 7]].mean(axis=0), face, atol=1e-3)


def test_a_tilted_box_is_taken_as_it_is():
    record = house()
    record["objects"].append(
        {
            "category": "BaseballBat",
            "p": [-1, 1, 0.5],
            "q": [0.8, 0.36, 0.48, 0],
            "s": [0.1, 0.1, 1],
        }
    )
    scene, _ = fly(record)
    assert not by_source(scene, "BaseballBat").bbox.is_upright
    assert scene.landing_areas


def test_lamps_that_hang_are_told_apart():
    record = house()
    record["objects"].append(box("Pendant Lamp", (-2, 0, 2.4), (0.5, 0.5, 0.6)))
    scene, _ = fly(record)
    assert by_source(scene, "Pendant Lamp").attributes["form"] == "pendant"
    assert "form" not in by_source(scene, "FloorLamp").attributes


def test_the_same_layout_gives_the_same_bytes():
    record = json.loads(json.dumps(house()))
    assert scene_to_json(fly(record)[0]) == scene_to_json(fly(house())[0])
