from __future__ import annotations

import json

import pytest

import aeroscene.corpus.curation
import aeroscene.corpus.shipped
from aeroscene import sources
from aeroscene.scene import SceneError
from aeroscene.scene.io import scene_to_json, write_scene
from aeroscene.sources import canonical_name, load_scene
from aeroscene.validation import validate
from tests.aeroscene.layouts.samples import (
    authors_scene,
    block,
    front3d_house,
    house,
    write_json,
    write_lines,
)


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    monkeypatch.delenv("AEROSCENE_CACHE", raising=False)
    return tmp_path


def test_a_corpus_scene_is_opened_the_second_time_from_the_cache(
    cache_folder, scene_42, monkeypatch
):
    assert load_scene("corpus:42") == scene_42
    assert len(list(cache_folder.rglob("corpus-0042.json"))) == 1

    def refuse(index):
        raise AssertionError(f"curated scene {index} again")

    monkeypatch.setattr(aeroscene.corpus.curation, "curate_scene", refuse)
    assert load_scene("corpus:42") == scene_42


def test_a_number_opens_a_scene_of_the_dataset(
    cache_folder, scene_42, archive_path, archived_scenes, monkeypatch
):
    monkeypatch.setattr(sources, "NUMBERS_NAME", "corpus")
    assert load_scene("42") == scene_42
    monkeypatch.setattr(sources, "NUMBERS_NAME", "shipped")
    monkeypatch.setattr(aeroscene.corpus.shipped, "SHIPPED", archive_path)
    assert load_scene("17") == load_scene("0017") == archived_scenes[17]
    with pytest.raises(SceneError, match=r"scene 42 is not in .*; valid: 0 to 18"):
        load_scene("42")


def test_the_name_that_a_scene_has_itself_opens_it(cache_folder, scene_42):
    for name in ("42", "corpus:42"):
        scene = load_scene(name)
        assert load_scene(scene.scene_id) == scene
        assert sources.canonical_name(scene.scene_id) == name
    for name in ("field", "gen:7", "a-0042.json", "aeroscene-42", "aeroscene-0042#0"):
        assert sources.canonical_name(name) == name


def test_a_damaged_cache_is_replaced(cache_folder, scene_42):
    load_scene("corpus:42")
    (path,) = cache_folder.rglob("corpus-0042.json")
    path.write_bytes(path.read_bytes()[:1000])
    assert load_scene("corpus:42") == scene_42
    assert path.stat().st_size > 1000


def test_a_cache_that_cannot_be_written_does_no_harm(cache_folder, scene_42, monkeypatch):
    blocked = cache_folder / "file"
    blocked.write_text("")
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(blocked))
    assert load_scene("corpus:42") == scene_42


def test_a_file_is_opened_by_its_path(tmp_path, scene_42):
    path = tmp_path / "mine.json"
    write_scene(scene_42, path)
    assert load_scene(str(path)) == scene_42


@pytest.mark.parametrize(
    "spec",
    [
        *(
            "1016",
            "aeroscene-1016",
            "aeroscene-42",
            "-1",
            "4.2",
            "x",
            "",
            "٤٢",
            "+1",
            "9" * 5000,
            "a.jsonx",
            "#0",
        ),
        *(
            "corpus:1234567890",
            "corpus:",
            "gen:",
            "gen:x",
            "gen:-3",
            "gen:3 ",
            "shipped:3",
            "Gen:3",
            "Field",
            "field ",
        ),
    ],
)
def test_an_unknown_scene_gives_one_line_with_what_is_valid(spec):
    with pytest.raises(SceneError) as caught:
        load_scene(spec)
    assert str(caught.value) == (
        f"scene {spec!r} is unknown; valid: a number from 0 to 1015, corpus:N, gen:SEED, "
        "district:SEED, field, hills, FILE.json, FILE.jsonl#ID or FILE.osm#W,S,E,N, also with .gz"
    )


def test_the_field_is_open_flat_and_valid_with_a_pad_to_start_from_and_one_to_land_on():
    scene = load_scene("field")
    assert scene == load_scene("field")
    assert not validate(scene)
    (pad,) = [obj for obj in scene.objects if obj.attributes.get("is_start")]
    assert scene.start_position_enu_m == (*pad.bbox.p[:2], pad.bbox.p[2] + pad.bbox.s[2] / 2)
    assert max(obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in scene.objects) < 0.2
    (area,) = scene.landing_areas
    assert scene.object_by_id[area.object_id or 0].category == "landing_pad"
    assert area.object_id != pad.id


def test_a_file_of_ours_holds_one_scene(tmp_path, scene_42):
    path = tmp_path / "mine.json"
    write_scene(scene_42, path)
    assert load_scene(f"{path}#0") == load_scene(f"{path}#corpus-0042") == scene_42
    with pytest.raises(SceneError, match=r"has no scene '1'; valid: 'corpus-0042'"):
        load_scene(f"{path}#1")


def test_a_file_without_areas_has_those_that_its_geometry_offers(tmp_path):
    path, scene = tmp_path / "mine.json", load_scene("field")
    document = json.loads(scene_to_json(scene))
    del document["interaction_areas"]
    path.write_text(json.dumps(document))
    derived = load_scene(str(path))
    assert derived.landing_areas
    assert not validate(derived)


def test_layouts_of_other_people_are_opened_by_what_is_in_them(tmp_path):
    lines = write_lines(tmp_path / "two.jsonl.gz", house(), block())
    assert load_scene(str(lines)).scene_id == "made-up/house-1"
    assert load_scene(f"{lines}#block-1").scene_id == "made-up/block-1"
    assert load_scene(f"{lines}#1").scene_id == "made-up/block-1"
    authors = write_json(tmp_path / "a.json", authors_scene())
    assert load_scene(str(authors)).scene_id == "gen_sample_0"
    front3d = write_json(tmp_path / "b#1.json.gz", front3d_house())
    assert load_scene(str(front3d)).scene_id == "made-up-house"


def test_what_a_layout_loses_is_said(tmp_path, caplog):
    record = house()
    record["objects"][1]["category"] = "Xyzzy"
    record["objects"][2]["s"] = [0, 1, 1]
    path = write_lines(tmp_path / "a.jsonl", record)
    with pytest.raises(SceneError, match=r"object 2 \(Bed\): s is \[0, 1, 1\]; valid"):
        load_scene(str(path))
    load_scene(str(path), skip_invalid=True)
    said = [entry.getMessage() for entry in caplog.records]
    assert any("object 1: category is 'Xyzzy'" in line for line in said)
    assert any("object 2 (Bed): s is [0, 1, 1]" in line for line in said)


def test_damaged_files_are_refused_by_the_reader_they_are_for(tmp_path):
    path = tmp_path / "a.json"
    path.write_text('{"outdoor_scene": [')
    with pytest.raises(SceneError, match="line 1: JSON is cut short"):
        load_scene(str(path))
    path.write_text("")
    with pytest.raises(SceneError, match=r"a\.json"):
        load_scene(str(path))
    packed = tmp_path / "b.json.gz"
    packed.write_bytes(b"\x1f\x8b damaged")
    with pytest.raises(SceneError, match=r"b\.json\.gz"):
        load_scene(str(packed))


def test_the_corpus_goes_on_beyond_the_scenes_that_the_paper_counts(cache_folder):
    scene = load_scene("corpus:1016")
    assert (scene.scene_id, scene.seed, scene.domain) == ("corpus-1016", 1016, "indoor")
    assert load_scene("corpus:1016") == scene


def test_a_district_is_opened_by_its_seed_and_kept(monkeypatch, tmp_path):
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    made = load_scene("district:1")
    assert made.scene_id == "district-0001"
    monkeypatch.setattr("aeroscene.corpus.districts.compose.compose_district", None)
    assert load_scene("district-0001") == made
    assert canonical_name("district-0001") == "district:1"
