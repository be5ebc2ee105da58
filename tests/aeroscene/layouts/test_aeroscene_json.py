from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aeroscene.layouts import LayoutError, read_layout
from aeroscene.layouts.aeroscene_json import aeroscene_layout
from aeroscene.layouts.mapping import match
from aeroscene.scene.box import rotation_matrix
from tests.aeroscene.layouts.samples import authors_scene, write_json


def test_buildings_and_their_contents_are_read():
    layout = aeroscene_layout(authors_scene())
    assert layout.scene_id == "gen_sample_0"
    assert [obj.parent for obj in layout.objects] == [None, None, 1, 1]
    categories = [match(obj).category for obj in layout.objects]
    assert categories == ["warehouse", "building", "table", "box"]
    assert layout.attributes["mesh_floor"] == "island_2"


def test_objects_stand_with_the_middle_of_their_bottom_at_their_translation():
    building = aeroscene_layout(authors_scene()).objects[1]
    assert building.p[:2] == (-15, 0)
    assert building.p[2] == pytest.approx(building.s[2] / 2)


def test_scale_multiplies_a_nominal_size_and_a_shared_scale_is_a_unit():
    plain = aeroscene_layout(authors_scene())
    scaled = authors_scene()
    for thing in scaled["outdoor_scene"]:
        thing["scale"] = [0.01 * v for v in thing["scale"]]
    sizes = [obj.s for obj in aeroscene_layout(scaled).objects[:2]]
    assert sizes[0] == pytest.approx(plain.objects[0].s, rel=0.2)
    tall, low = authors_scene(), authors_scene()
    tall["outdoor_scene"][0]["scale"] = 2
    a, b = aeroscene_layout(tall).objects[0].s, aeroscene_layout(low).objects[0].s
    assert a == pytest.approx([2 * v for v in b])


def test_angles_are_degrees_about_x_then_y_then_z():
    record = authors_scene()
    record["outdoor_scene"][0]["rotation"] = [10, 20, 90]
    quat = aeroscene_layout(record).objects[0].q
    expected = Rotation.from_euler("xyz", [10, 20, 90], degrees=True).as_matrix()
    assert np.allclose(rotation_matrix(quat), expected)


def test_a_file_of_small_angles_is_in_radians():
    record = authors_scene()
    record["outdoor_scene"][0]["rotation"] = [0, 0, math.pi / 2]
    record["outdoor_scene"][1]["rotation"] = [0, 0, 0]
    quat = aeroscene_layout(record).objects[0].q
    assert quat == pytest.approx((math.sqrt(0.5), 0, 0, math.sqrt(0.5)))


def test_four_numbers_are_a_quaternion_and_none_is_no_turn():
    record = authors_scene()
    record["outdoor_scene"][0]["rotation"] = [0, 0, 0, 1]
    record["outdoor_scene"][1]["rotation"] = None
    first, second, *_ = aeroscene_layout(record).objects
    assert first.q == (0, 0, 0, 1)
    assert second.q == (1, 0, 0, 0)


def test_towns_in_centimetres_are_read_in_metres():
    record = authors_scene()
    for thing in record["outdoor_scene"]:
        thing["translation"] = [100 * v for v in thing["translation"]]
        for child in thing["indoor"] or []:
            child["translation"] = [100 * v for v in child["translation"]]
    record["outdoor_scene"][0]["translation"][0] = 2000.0
    moved = aeroscene_layout(record).objects
    for ours, plain in zip(moved, aeroscene_layout(authors_scene()).objects, strict=True):
        assert ours.p == pytest.approx(plain.p, abs=1e-3)


def test_contents_are_read_in_the_building_or_in_the_world_whichever_holds_them():
    local = authors_scene()
    world = copy.deepcopy(local)
    turn = Rotation.from_euler("z", 30, degrees=True)
    for child in world["outdoor_scene"][1]["indoor"]:
        child["translation"] = (turn.apply(child["translation"]) + (-15, 0, 0)).tolist()
        child["rotation"] = [0, 0, 30]
    first, second = aeroscene_layout(local).objects, aeroscene_layout(world).objects
    for a, b in zip(first, second, strict=True):
        assert a.p == pytest.approx(b.p, abs=1e-3)
        assert a.q == pytest.approx(b.q, abs=1e-6)


def test_a_furnished_building_can_be_entered(tmp_path):
    scene, report = read_layout(write_json(tmp_path / "gen_sample_0.json", authors_scene()))
    assert scene.domain == "mixed"
    assert report.n_mapped == 4
    (building,) = [obj for obj in scene.objects if obj.attributes.get("is_enterable")]
    contents = [obj for obj in scene.children_by_id[building.id] if obj.category != "roof"]
    assert {obj.domain for obj in contents} == {"indoor"}
    assert len(contents) == 2
    assert scene.landing_areas


BAD = {
    "translation": ([1, 2], "translation is [1, 2]; valid: 3 finite numbers"),
    "rotation": ([1, 2], "rotation is [1, 2]; valid: three angles or a quaternion"),
    "scale": ([1, 0, 1], "scale is [1, 0, 1]; valid: three numbers above 0"),
    "indoor": ("none", "indoor is 'none'; valid: a list"),
}


@pytest.mark.parametrize("field", BAD)
def test_a_bad_field_is_named_or_skipped_and_counted(field):
    value, fault = BAD[field]
    record = authors_scene()
    record["outdoor_scene"][0][field] = value
    with pytest.raises(LayoutError) as caught:
        aeroscene_layout(record)
    place = "scene 'gen_sample_0': object outdoor_scene[0] (warehouse_02): "
    assert str(caught.value).startswith(place + fault)
    layout = aeroscene_layout(record, skip_invalid=True)
    assert len(layout.invalid) == 1
    assert len(layout.objects) == 3


def test_faults_of_contents_are_named_with_their_building():
    record = authors_scene()
    record["outdoor_scene"][1]["indoor"][1]["rotation"] = [1, 1, 1, 1]
    with pytest.raises(
        LayoutError, match=r"object outdoor_scene\[1\].indoor\[1\] \(object\): rotat"
    ):
        aeroscene_layout(record)
    del record["outdoor_scene"][0]["name"]
    layout = aeroscene_layout(record, skip_invalid=True)
    assert len(layout.invalid) == 2


def test_a_scene_without_objects_is_refused():
    with pytest.raises(LayoutError, match="outdoor_scene has no object"):
        aeroscene_layout({"id": "x", "outdoor_scene": []})
    with pytest.raises(LayoutError, match="outdoor_scene is None; valid: a list"):
        aeroscene_layout({"id": "x", "outdoor_scene": None})
