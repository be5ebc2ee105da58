from __future__ import annotations

import hashlib
import subprocess
import sys

import numpy as np
import pytest

from aeroscene.catalogue import by_name
from aeroscene.curation import curate_scene
from aeroscene.freespace import build_distance_field, reachable
from aeroscene.geometry import iou, penetration_depth
from aeroscene.scene import Scene
from aeroscene.scene_io import scene_to_json
from aeroscene.shapes import scene_primitives
from aeroscene.voxels import bounds

HUMMINGBIRD_RADIUS_M = 0.4


def test_the_same_number_gives_the_same_bytes_in_another_process(scene_42):
    program = (
        "import hashlib; from aeroscene.curation import curate_scene;"
        "from aeroscene.scene_io import scene_to_json;"
        "print(hashlib.sha256(scene_to_json(curate_scene(42))).hexdigest())"
    )
    found = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        check=True,
        text=True,
        env={"PYTHONHASHSEED": "7", "PYTHONPATH": ":".join(sys.path)},
    )
    assert found.stdout.strip() == hashlib.sha256(scene_to_json(scene_42)).hexdigest()


def test_different_numbers_give_different_places(scenes):
    def layout(scene: Scene):
        return tuple((o.category_id, o.bbox.p) for o in scene.objects if o.is_coarse)

    assert len({layout(scene) for scene in scenes}) == len(scenes)
    heights = {max(o.bbox.p[2] for o in scene.objects) for scene in scenes}
    assert len(heights) >= len(scenes) - 1
    mixes = {frozenset(o.category for o in scene.objects) for scene in scenes}
    assert len(mixes) == len(scenes)


def test_boxes_overlap_only_along_the_hierarchy(scene):
    objects = scene.objects
    p = np.array([o.bbox.p for o in objects])
    q = np.array([o.bbox.q for o in objects])
    s = np.array([o.bbox.s for o in objects])
    first, second = np.triu_indices(len(objects), 1)
    depth = penetration_depth(p[first], q[first], s[first], p[second], q[second], s[second])
    for index in np.flatnonzero(depth > 1e-3):
        a, b = objects[first[index]], objects[second[index]]
        if b.parent_id == a.id:
            continue
        assert iou(a.bbox, b.bbox) <= 0.01, (a, b)
        if a.id not in scene.ancestors(b.id):
            assert depth[index] < 0.02, (a, b)


def test_nothing_floats(scene):
    solids = [(p.object_id, *bounds(p)) for p in scene_primitives(scene) if p.collides]
    for obj in scene.objects:
        foot = obj.bbox.p[2] - obj.bbox.s[2] / 2
        corners = obj.bbox.corners()[:4, :2]
        low, high = corners.min(axis=0), corners.max(axis=0)
        is_held = foot < 1e-3 or any(
            owner != obj.id
            and bottom[2] < foot - 1e-3
            and top[2] > foot - 2e-3
            and np.all(bottom[:2] < high)
            and np.all(top[:2] > low)
            for owner, bottom, top in solids
        )
        assert is_held, obj


def test_objects_stand_inside_the_flight_volume(scene):
    low, high = np.asarray(scene.extent_min_enu_m), np.asarray(scene.extent_max_enu_m)
    for obj in scene.objects:
        assert np.all(obj.bbox.p >= low), obj
        assert np.all(obj.bbox.p <= high - (0, 0, 5)), obj
        assert obj.bbox.p[2] - obj.bbox.s[2] / 2 >= -1e-9


def test_sizes_are_real(scene):
    for obj in scene.objects:
        category = by_name()[obj.category]
        spans = (category.length_m, category.width_m, category.height_m)
        for extent, (low, high) in zip(obj.bbox.s, spans, strict=True):
            assert 0.7 * low <= extent <= 1.3 * high, obj


def test_furniture_is_indoors_and_traffic_outdoors(scene):
    for obj in scene.objects:
        ancestors = [scene.object_by_id[i].category for i in scene.ancestors(obj.id)]
        if "room" in ancestors:
            assert obj.domain == "indoor"
        if obj.category in {"car", "bus", "tree", "street_lamp", "road"}:
            assert obj.domain == "outdoor"
        if obj.category in {"sofa", "bed", "desk", "wardrobe"}:
            assert "room" in ancestors


def test_the_start_is_on_a_pad_under_open_sky_away_from_obstacles(scene):
    x, y, z = scene.start_position_enu_m
    pads = [o for o in scene.objects if o.attributes.get("is_start")]
    assert len(pads) == 1
    assert pads[0].category == "landing_pad"
    assert pads[0].bbox.p[2] + pads[0].bbox.s[2] / 2 == pytest.approx(z, abs=1e-6)
    tops = []
    for primitive in scene_primitives(scene):
        if not primitive.collides:
            continue
        low, high = bounds(primitive)
        gap = np.maximum(np.maximum(low[:2] - (x, y), (x, y) - high[:2]), 0)
        if np.hypot(*gap) < 2.0:
            tops.append(high[2])
    assert max(tops) <= z + 0.12
    assert scene.extent_max_enu_m[2] - z >= 15


def test_averages_are_those_of_the_paper(scenes):
    coarse = [sum(o.is_coarse for o in scene.objects) for scene in scenes]
    fine = [len(scene.objects) - n for scene, n in zip(scenes, coarse, strict=True)]
    assert 29 <= np.mean(coarse) <= 40
    assert 95 <= np.mean(fine) <= 130


def test_scenes_are_cheap_to_simulate(scene):
    primitives = scene_primitives(scene)
    assert sum(p.collides for p in primitives) <= 900
    assert len(primitives) <= 1400


def test_a_hummingbird_can_fly_into_rooms(scene):
    field = build_distance_field(scene)
    flood = reachable(field, scene.start_position_enu_m, HUMMINGBIRD_RADIUS_M + 0.05)
    rooms = [o for o in scene.objects if o.category == "room"]
    assert rooms
    entered = 0
    for room in rooms:
        x, y, z = room.bbox.p
        i, j, k = field.cell((x, y, z))
        entered += bool(flood[i - 4 : i + 5, j - 4 : j + 5, k - 2 : k + 3].any())
    assert entered == len(rooms)


@pytest.mark.parametrize("index", [201, 812])
def test_every_scene_has_a_start_a_furnished_building_and_areas(index):
    scene = curate_scene(index)
    categories = {o.category for o in scene.objects}
    assert {"room", "floor", "landing_pad", "road", "chair", "street_lamp"} <= categories
    assert len(scene.interaction_areas) >= 30
