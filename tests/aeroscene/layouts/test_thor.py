"""Houses of ProcTHOR and Holodeck: frames, sizes, hosts, and what breaks a rule."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from aeroscene.layouts import LayoutError, read_layout, read_layouts
from aeroscene.layouts.thor import category_of, read_asset_sizes
from aeroscene.scene.box import rotation_matrix
from aeroscene.sources import load_scene
from tests.aeroscene.layouts.samples import (
    holodeck_house,
    house,
    procthor_house,
    write_json,
    write_lines,
)


@pytest.fixture
def layout(tmp_path):
    (found,) = read_layouts(write_json(tmp_path / "house.json", procthor_house()))
    return found


def by_category(layout, category):
    return next(obj for obj in layout.objects if obj.category == category)


def front_enu(obj):
    return rotation_matrix(obj.q) @ (0.0, 1.0, 0.0)


def test_a_house_of_procthor_is_rooms_with_furniture_about_the_middle(layout):
    assert layout.scene_id == "house"
    assert [room.name for room in layout.rooms] == ["Bedroom", "LivingRoom"]
    assert set(layout.rooms[0].polygon) == {(-5, -2.5), (0, -2.5), (0, 2.5), (-5, 2.5)}
    assert by_category(layout, "Desk").p == (-4.0, 0.0, 0.4)
    assert by_category(layout, "Sofa").p == (2.5, 1.5, 0.45)


def test_unitys_turns_are_clockwise_from_above(layout):
    """At 90 degrees a model looks along x, east; at 180 south."""
    np.testing.assert_allclose(front_enu(by_category(layout, "Desk")), [1, 0, 0], atol=1e-9)
    np.testing.assert_allclose(front_enu(by_category(layout, "Sofa")), [0, -1, 0], atol=1e-9)


def test_turns_about_all_axes_agree_with_unitys_matrix(tmp_path):
    record = procthor_house()
    x, y, z = 20.0, 70.0, -35.0
    record["objects"][0]["rotation"] = {"x": x, "y": y, "z": z}
    (layout,) = read_layouts(write_json(tmp_path / "a.json", record))
    a, b, c = np.radians((x, y, z))
    about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_y = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    about_z = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
    swap = np.eye(3)[[0, 2, 1]]
    expected = swap @ about_y @ about_x @ about_z @ swap
    np.testing.assert_allclose(rotation_matrix(layout.objects[0].q), expected, atol=1e-9)


def test_heights_follow_from_where_things_stand(layout):
    desk, laptop = by_category(layout, "Desk"), by_category(layout, "Laptop")
    assert desk.s == (1.39, 0.62, 0.8)  # twice the height of its middle
    assert layout.objects[laptop.parent] is desk
    assert laptop.s[2] == pytest.approx(0.2)  # its middle is 0.1 m over the desk
    assert by_category(layout, "Painting").s == (0.81, 0.03, 0.61)  # it hangs


def test_asset_sizes_beside_the_file_are_exact(tmp_path):
    box = {"x": 1.2, "y": 0.75, "z": 0.7}
    assets = {"Desk": [{"assetId": "Desk_307_1_1", "boundingBox": box}]}
    write_json(tmp_path / "asset-database.json", assets)
    folder = tmp_path / "houses"
    folder.mkdir()
    (layout,) = read_layouts(write_json(folder / "a.json", procthor_house()))
    assert by_category(layout, "Desk").s == (1.2, 0.7, 0.75)


@pytest.mark.parametrize("content", [b"[]", b"{", b'{"Desk": [{}]}', b'{"Desk": 3}'])
def test_a_damaged_asset_database_is_none(tmp_path, content):
    (tmp_path / "asset-database.json").write_bytes(content)
    assert read_asset_sizes(tmp_path) == {}


def test_holodecks_outlines_are_sizes_and_its_ids_name_hosts(tmp_path):
    (layout,) = read_layouts(write_json(tmp_path / "a.json", holodeck_house()))
    desk, mug = layout.objects
    assert (desk.category, mug.category) == ("standing desk", "Mug")
    assert desk.s == (1.5, 1.0, 0.75)  # turned by 90 degrees, without the 10 cm
    assert mug.parent == 0
    assert mug.p[2] - mug.s[2] / 2 == pytest.approx(0.75)


@pytest.mark.parametrize(
    ("asset", "category"),
    [
        ("Dining_Table_16_1", "DiningTable"),
        ("RoboTHOR_side_table_tolkning", "SideTable"),
        ("Wall_Decor_Photo_2V", "Painting"),
        ("Tennis_Racquet_1", "TennisRacket"),
        ("made_up_3", "made_up_3"),
    ],
)
def test_assets_are_called_by_their_types(asset, category):
    assert category_of(asset, "2|0") == category


@pytest.mark.parametrize("record", [procthor_house(), holodeck_house()])
def test_a_house_opens_as_a_scene_to_fly_in(tmp_path, record):
    path = write_json(tmp_path / "house.json", record)
    scene = load_scene(str(path))
    assert {"room", "wall", "roof", "desk"} <= {obj.category for obj in scene.objects}
    assert scene.interaction_areas
    _, report = read_layout(path)
    assert not report.unmapped


def test_procthors_lines_open_by_their_number(tmp_path):
    path = write_lines(tmp_path / "train.jsonl.gz", procthor_house(), house(), holodeck_house())
    names = [layout.scene_id for layout in read_layouts(path)]
    assert names == ["house-0", "made-up/house-1", "house-2"]
    assert load_scene(f"{path}#2").scene_id == "house-2"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rooms": []}, "rooms is empty"),
        ({"rooms": [{"id": "a"}]}, r"rooms\[0\].floorPolygon is missing"),
        ({"objects": 3}, "objects is 3; valid: a list"),
        ({"objects": [{"assetId": "Bed_1"}]}, r"object objects\[0\]: position is missing"),
        (
            {"objects": [{"assetId": "Bed_1", "position": {"x": 0, "y": 1e9, "z": 0}}]},
            r"objects\[0\]: position is .* within 10000 m",
        ),
    ],
)
def test_a_fault_is_one_line_with_its_place(tmp_path, change, message):
    path = write_json(tmp_path / "a.json", procthor_house() | change)
    with pytest.raises(LayoutError, match=message):
        list(read_layouts(path))


def test_children_too_deep_are_refused(tmp_path):
    record = procthor_house()
    entry = record["objects"][0]
    nested = json.loads(json.dumps(entry))
    for _ in range(20):
        nested = {**entry, "children": [nested]}
    record["objects"] = [nested]
    with pytest.raises(LayoutError, match="too deep; valid: 8 levels"):
        list(read_layouts(write_json(tmp_path / "a.json", record)))


def test_objects_at_fault_are_left_out_where_asked(tmp_path):
    record = procthor_house()
    record["objects"].append({"assetId": "Bed_1"})
    (layout,) = read_layouts(write_json(tmp_path / "a.json", record), skip_invalid=True)
    assert len(layout.objects) == 4
    assert len(layout.invalid) == 1
