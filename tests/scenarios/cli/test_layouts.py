from __future__ import annotations

import json
from pathlib import Path

import pytest

from aeroscene.layouts import LayoutError
from aeroscene.scene.io import read_scene
from scenarios.cli.layouts import LayoutsCfg, run
from tests.aeroscene.layouts.samples import block, house, write_lines
from tests.aeroscene.maps.samples import bounds_text, town


@pytest.fixture
def broken(tmp_path):
    record = house()
    record["objects"][1]["category"] = "Xyzzy"
    record["objects"][2]["q"] = [1, 1, 1, 1]
    return write_lines(tmp_path / "broken.jsonl", record, block())


def test_the_table_says_what_becomes_of_every_object(tmp_path, capsys):
    path = write_lines(tmp_path / "fine.jsonl", house(), block())
    assert run(LayoutsCfg(file=path)) == 0
    shown = capsys.readouterr()
    assert "fine.jsonl: 2 scenes, 9 objects, 9 mapped, 0 unmapped, 0 dropped, 0" in shown.out
    assert "building 2" in shown.out
    assert "Painting 1*" in shown.out
    assert shown.err == ""


def test_without_skipping_the_first_fault_ends_it(broken):
    with pytest.raises(LayoutError, match=r"object 2 \(Bed\): q is \[1, 1, 1, 1\]"):
        run(LayoutsCfg(file=broken))


def test_skipping_names_and_counts_and_ends_with_status_1(broken, capsys):
    assert run(LayoutsCfg(file=broken, skip_invalid=True)) == 1
    shown = capsys.readouterr()
    assert "1 unmapped, 0 dropped, 1" in shown.out
    assert "invalid: scene 'made-up/house-1': object 2 (Bed): q is [1, 1, 1, 1]" in shown.err
    assert "unmapped: scene 'made-up/house-1': object 1: category is 'Xyzzy'" in shown.err


def test_json_is_one_object(broken, capsys):
    run(LayoutsCfg(file=broken, skip_invalid=True, json=True))
    report = json.loads(capsys.readouterr().out)
    assert (report["scenes"], report["objects"], report["mapped"]) == (2, 8, 7)
    assert report["unmapped"] == {"Xyzzy": 1}
    assert report["invalid"] == 1
    assert report["mapped_by_category"]["house"] == 2


def test_scenes_are_written_and_can_be_opened(broken, tmp_path, capsys):
    folder = tmp_path / "a" / "scenes"
    run(LayoutsCfg(file=broken, skip_invalid=True, out=folder, json=True))
    written = json.loads(capsys.readouterr().out)["written"]
    assert written == ["made-up-house-1.json", "made-up-block-1.json"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(written)
    assert read_scene(folder / written[0]).scene_id == "made-up/house-1"


def test_a_file_that_cannot_be_read_leaves_no_folder(tmp_path):
    (tmp_path / "cut.jsonl").write_text("hello")
    with pytest.raises(LayoutError, match="malformed"):
        run(LayoutsCfg(file=tmp_path / "cut.jsonl", out=tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_refused(broken, tmp_path):
    with pytest.raises(LayoutError, match=r"out .* cannot be written"):
        run(LayoutsCfg(file=broken, skip_invalid=True, out=broken / "x"))


def test_a_layout_of_which_nothing_maps_ends_it_or_is_counted(tmp_path, capsys):
    record = house()
    record["objects"] = [record["objects"][0] | {"category": "Xyzzy"}]
    path = write_lines(tmp_path / "a.jsonl", record)
    with pytest.raises(LayoutError, match="object 0: category is 'Xyzzy'"):
        run(LayoutsCfg(file=path))
    assert run(LayoutsCfg(file=path, skip_invalid=True)) == 1
    assert "object 0: category is 'Xyzzy'" in capsys.readouterr().err


def test_two_scenes_whose_ids_give_one_file_name_become_two_files(tmp_path, capsys):
    lines = [house() | {"scene_id": scene_id} for scene_id in ("a/b", "a b")]
    out = tmp_path / "out"
    assert run(LayoutsCfg(file=write_lines(tmp_path / "a.jsonl", *lines), out=out)) == 0
    names = {path.name: read_scene(path).scene_id for path in out.iterdir()}
    assert names == {"a-b.json": "a/b", "a-b-2.json": "a b"}


def test_a_place_on_a_map_is_reported_and_converted(tmp_path, capsys):
    path = town().write(tmp_path / "town.osm")
    name = f"{path}#{bounds_text()}"
    assert run(LayoutsCfg(file=Path(name), out=tmp_path / "out", json=True)) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["by_category"]["house"] == 1
    assert report["dropped"] == {"inside a building": 1}
    (written,) = report["written"]
    scene = read_scene(tmp_path / "out" / written)
    assert len(scene.objects) == report["objects"]
