from __future__ import annotations

import gzip
import json
import math
import os
from pathlib import Path

import pytest

from aeroscene.layouts import LayoutError, read_neutral
from aeroscene.scene import SceneError
from aeroscene.scene.polygon import signed_area
from tests.aeroscene.layouts.samples import block, house, write_lines

BAD_OBJECTS = {
    "zero extent": ({"s": [1.0, 0.0, 1.0]}, "s is [1.0, 0.0, 1.0]"),
    "negative extent": ({"s": [1.0, -2.0, 1.0]}, "s is [1.0, -2.0, 1.0]"),
    "nan extent": ({"s": [1.0, math.nan, 1.0]}, "s is [1.0, nan, 1.0]"),
    "huge extent": ({"s": [1.0, 1e9, 1.0]}, "s is [1.0, 1000000000.0, 1.0]"),
    "infinite position": ({"p": [math.inf, 0, 0]}, "p is [inf, 0, 0]"),
    "position beyond the earth": ({"p": [0, 1e30, 0]}, "p is [0, 1e+30, 0]"),
    "number too long for a float": ({"p": [10**400, 0, 0]}, "p is [1000"),
    "two coordinates": ({"p": [0, 0]}, "p is [0, 0]"),
    "text for a number": ({"p": ["0", 0, 0]}, "p is ['0', 0, 0]"),
    "truth for a number": ({"p": [True, 0, 0]}, "p is [True, 0, 0]"),
    "no unit quaternion": ({"q": [1.0, 0.1, 0, 0]}, "q is [1.0, 0.1, 0, 0]"),
    "no quaternion": ({"q": None}, "q is None"),
    "parent not there": ({"parent": 99}, "parent is 99"),
    "parent after it": ({"parent": 3}, "parent is 3"),
    "parent of itself": ({"parent": 1}, "parent is 1"),
    "parent before the first": ({"parent": -1}, "parent is -1"),
    "parent no index": ({"parent": "0"}, "parent is '0'"),
    "category no text": ({"category": 7}, "category is 7"),
    "category empty": ({"category": ""}, "category is ''"),
}


def broken_house(change: dict) -> dict:
    record = house()
    record["objects"][1] |= change
    return record


def test_plain_and_gzip_files_give_the_same_layouts(tmp_path):
    plain = list(read_neutral(write_lines(tmp_path / "a.jsonl", house(), block())))
    packed = list(read_neutral(write_lines(tmp_path / "a.jsonl.gz", house(), block())))
    assert plain == packed
    assert [layout.scene_id for layout in plain] == ["made-up/house-1", "made-up/block-1"]
    first, second = plain
    assert (first.front, second.front) == ("y", "x")
    assert [room.name for room in first.rooms] == ["Kitchen", "Bedroom"]
    assert first.objects[1].parent == 0


def test_a_rounded_quaternion_is_renormalised(tmp_path):
    (layout,) = read_neutral(
        write_lines(tmp_path / "a.jsonl", broken_house({"q": [0.7071, 0, 0, 0.7069]}))
    )
    assert math.hypot(*layout.objects[1].q) == pytest.approx(1.0, abs=1e-12)


def test_a_clockwise_floor_is_turned_round(tmp_path):
    record = block()
    record["floor"].reverse()
    (layout,) = read_neutral(write_lines(tmp_path / "a.jsonl", record))
    assert signed_area(layout.floor) == 60 * 60


@pytest.mark.parametrize("name", BAD_OBJECTS)
def test_a_bad_object_is_named_by_line_scene_object_and_field(tmp_path, name):
    change, fault = BAD_OBJECTS[name]
    path = write_lines(tmp_path / "a.jsonl", block(), broken_house(change))
    with pytest.raises(LayoutError) as caught:
        list(read_neutral(path))
    message = str(caught.value)
    assert message.startswith(
        f"layout file {str(path)!r} line 2: scene 'made-up/house-1': object 1"
    )
    assert fault in message
    assert "; valid: " in message
    assert "\n" not in message
    assert isinstance(caught.value, SceneError)


@pytest.mark.parametrize("key", ["category", "p", "q", "s"])
def test_a_missing_key_of_an_object_is_named(tmp_path, key):
    record = house()
    del record["objects"][1][key]
    with pytest.raises(LayoutError, match=rf"'made-up/house-1': object 1.*{key} is missing; valid"):
        list(read_neutral(write_lines(tmp_path / "a.jsonl", record)))


@pytest.mark.parametrize(
    ("key", "value", "fault"),
    [
        ("domain", "underwater", "domain is 'underwater'; valid: indoor, outdoor"),
        ("floor", [[0, 0], [1, 0]], "at least 3 corners"),
        ("floor", [[0, 0], [1, 1], [1, 0], [0, 1]], "does not cross itself"),
        ("floor", [[0, 0], [1, 0], [2, 0]], "holds an area"),
        ("floor", [[0, 0], [1, "x"], [2, 0]], "floor[1] is [1, 'x']"),
        ("objects", {}, "objects is {}; valid: a list"),
        (
            "attributes",
            {"rooms": [{"room_type": "Bath"}]},
            "attributes.rooms[0].polygon is missing",
        ),
    ],
)
def test_a_bad_field_of_a_scene_is_named(tmp_path, key, value, fault):
    with pytest.raises(LayoutError) as caught:
        list(read_neutral(write_lines(tmp_path / "a.jsonl", house() | {key: value})))
    assert "scene 'made-up/house-1': " in str(caught.value)
    assert fault in str(caught.value)


def test_json_cut_short_is_named_by_its_line(tmp_path):
    path = write_lines(tmp_path / "a.jsonl", block(), house())
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(LayoutError, match=r"line 2: JSON is cut short \(.* at column \d+\); valid"):
        list(read_neutral(path))


def test_deep_nesting_and_endless_numbers_are_refused(tmp_path):
    for text in ("[" * 100_000, '{"scene_id": ' + "9" * 5000 + "}"):
        path = tmp_path / "a.jsonl"
        path.write_text(text)
        with pytest.raises(LayoutError, match="layout file"):
            list(read_neutral(path))


def test_what_is_no_text_is_refused(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_bytes(json.dumps(block()).encode() + b"\n\xff\xfe{}\n")
    with pytest.raises(LayoutError, match="line 2: byte 0 is no UTF-8"):
        list(read_neutral(path))
    path.write_bytes(b" \n")
    with pytest.raises(LayoutError, match="is empty"):
        list(read_neutral(path))
    with pytest.raises(LayoutError, match="cannot be read"):
        list(read_neutral(tmp_path / "none.jsonl"))


def test_truncated_gzip_is_refused(tmp_path):
    path = tmp_path / "a.jsonl.gz"
    path.write_bytes(gzip.compress(json.dumps(block()).encode())[:-20])
    with pytest.raises(LayoutError, match="gzip is damaged or cut short"):
        list(read_neutral(path))


def test_a_scene_id_used_twice_is_refused(tmp_path):
    with pytest.raises(
        LayoutError, match="line 2: scene 'made-up/house-1': scene_id is used twice"
    ):
        list(read_neutral(write_lines(tmp_path / "a.jsonl", house(), house())))


def test_skipping_goes_on_names_and_counts(tmp_path):
    bad = broken_house({"q": [1, 1, 0, 0]}) | {"scene_id": "made-up/house-2"}
    path = write_lines(tmp_path / "a.jsonl", house(), bad, house(), {"domain": "indoor"}, block())
    faults: list[str] = []
    layouts = list(read_neutral(path, skip_invalid=True, faults=faults))
    assert [layout.scene_id for layout in layouts] == [
        "made-up/house-1",
        "made-up/house-2",
        "made-up/block-1",
    ]
    assert [len(layout.invalid) for layout in layouts] == [0, 1, 0]
    assert layouts[1].invalid[0].startswith("object 1 (Mug): q is ")
    assert len(layouts[1].objects) == len(bad["objects"]) - 1
    assert len(faults) == 2
    assert "line 3: scene 'made-up/house-1'" in faults[0]
    assert "line 4: scene_id is missing" in faults[1]


def test_children_of_a_skipped_object_go_to_its_nearest_kept_ancestor(tmp_path):
    record = house()
    record["objects"][1]["s"] = [0, 0, 0]
    record["objects"][2]["parent"] = 1
    record["objects"][3]["parent"] = 2
    (layout,) = read_neutral(write_lines(tmp_path / "a.jsonl", record), skip_invalid=True)
    assert [obj.category for obj in layout.objects] == [
        "DiningTable",
        "Bed",
        "Painting",
        "FloorLamp",
    ]
    assert [obj.parent for obj in layout.objects] == [None, 0, 1, None]


@pytest.mark.skipif("AEROSCENE_LAYOUTS" not in os.environ, reason="needs real layouts")
def test_real_layouts_are_read_without_a_fault():
    paths = sorted(Path(os.environ["AEROSCENE_LAYOUTS"]).glob("*.jsonl.gz"))
    assert paths
    for path in paths:
        assert all(layout.objects for layout in read_neutral(path))
