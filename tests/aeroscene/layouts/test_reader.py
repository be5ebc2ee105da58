from __future__ import annotations

import pytest

from aeroscene.layouts import LayoutError, pick_layout, read_layout, read_layouts
from tests.aeroscene.layouts.samples import (
    authors_scene,
    block,
    front3d_house,
    house,
    write_json,
    write_lines,
)


@pytest.fixture
def lines(tmp_path):
    return write_lines(tmp_path / "two.jsonl.gz", house(), block())


@pytest.mark.parametrize(
    ("scene_id", "found"),
    [
        (None, "made-up/house-1"),
        ("made-up/block-1", "made-up/block-1"),
        ("block-1", "made-up/block-1"),
        ("0", "made-up/house-1"),
        ("1", "made-up/block-1"),
    ],
)
def test_a_scene_is_picked_by_id_by_the_end_of_it_or_by_number(lines, scene_id, found):
    assert pick_layout(lines, scene_id).scene_id == found


@pytest.mark.parametrize("scene_id", ["2", "-1", "block", ""])
def test_a_scene_that_is_not_there_is_refused_with_what_is(lines, scene_id):
    with pytest.raises(LayoutError, match=r"valid: a number from 0 to 1 or an id such as 'made-up"):
        pick_layout(lines, scene_id)


@pytest.mark.parametrize(
    ("record", "source"),
    [
        (authors_scene(), "AeroScene authors' JSON"),
        (front3d_house(), "3D-FRONT"),
        (house(), "made up for tests"),
    ],
)
def test_json_files_are_told_apart_by_their_keys(tmp_path, record, source):
    (layout,) = read_layouts(write_json(tmp_path / "a.json", record))
    assert layout.source == source


@pytest.mark.parametrize("record", [[], 7, {"objects": []}, "text"])
def test_an_unknown_form_is_refused_with_the_known_ones(tmp_path, record):
    with pytest.raises(LayoutError, match=r"unknown form .*3D-FRONT's JSON \(furniture, scene\)"):
        list(read_layouts(write_json(tmp_path / "a.json", record)))


def test_errors_name_the_file_first(tmp_path):
    record = house()
    record["objects"][0]["category"] = "Xyzzy"
    record["objects"] = record["objects"][:1]
    path = write_lines(tmp_path / "a.jsonl", record)
    with pytest.raises(LayoutError) as caught:
        read_layout(path)
    assert str(caught.value).startswith(f"layout file {str(path)!r}: scene 'made-up/house-1': ")


def test_a_fault_matters_only_in_the_scene_that_is_asked_for(tmp_path):
    broken = house()
    del broken["objects"][0]["q"]
    path = write_lines(tmp_path / "a.jsonl", broken, block())
    assert pick_layout(path, "block-1").scene_id == pick_layout(path, "1").scene_id
    for scene_id in (None, "0", "house-1", "xyzzy"):
        with pytest.raises(LayoutError, match=r"line 1: scene 'made-up/house-1': object 0"):
            pick_layout(path, scene_id)
    assert pick_layout(path, "0", skip_invalid=True).scene_id == "made-up/house-1"


def test_skipping_a_whole_file_leaves_a_fault(tmp_path):
    path = tmp_path / "a.json"
    path.write_text('{"outdoor_scene": [')
    faults: list[str] = []
    assert list(read_layouts(path, skip_invalid=True, faults=faults)) == []
    assert "cut short" in faults[0]
    with pytest.raises(LayoutError, match="cut short"):
        pick_layout(path, skip_invalid=True)
