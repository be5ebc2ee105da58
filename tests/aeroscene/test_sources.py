from __future__ import annotations

import pytest

import aeroscene.curation
from aeroscene import sources
from aeroscene.scene import SceneError
from aeroscene.scene_io import write_scene
from aeroscene.sources import open_scene


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    sources._cache_folder.cache_clear()
    yield tmp_path
    sources._cache_folder.cache_clear()


def test_a_number_opens_a_corpus_scene_and_the_second_time_from_the_cache(
    cache_folder, scene_42, monkeypatch
):
    assert open_scene("42") == scene_42
    assert len(list(cache_folder.rglob("corpus-0042.json"))) == 1

    def refuse(index):
        raise AssertionError(f"curated scene {index} again")

    monkeypatch.setattr(aeroscene.curation, "curate_scene", refuse)
    assert open_scene("42") == scene_42


def test_a_damaged_cache_is_replaced(cache_folder, scene_42):
    open_scene("42")
    (path,) = cache_folder.rglob("corpus-0042.json")
    path.write_bytes(path.read_bytes()[:1000])
    assert open_scene("42") == scene_42
    assert path.stat().st_size > 1000


def test_a_cache_that_cannot_be_written_does_no_harm(cache_folder, scene_42, monkeypatch):
    blocked = cache_folder / "file"
    blocked.write_text("")
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(blocked))
    sources._cache_folder.cache_clear()
    assert open_scene("42") == scene_42


def test_a_file_is_opened_by_its_path(tmp_path, scene_42):
    path = tmp_path / "mine.json"
    write_scene(scene_42, path)
    assert open_scene(str(path)) == scene_42


@pytest.mark.parametrize("spec", ["1016", "-1", "4.2", "x", "", "gen:3", "٤٢", "+1", "9" * 5000])
def test_an_unknown_scene_gives_one_line_with_what_is_valid(spec):
    with pytest.raises(SceneError) as caught:
        open_scene(spec)
    assert str(caught.value) == (
        f"scene {spec!r} is unknown, valid: a number from 0 to 1015 or the path of a .json file"
    )
