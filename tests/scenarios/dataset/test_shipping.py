"""The scenes that ship are drawn until one is sound, and packed when all are there."""

import json
from dataclasses import dataclass, replace
from zipfile import ZipFile

import pytest

from aeroscene.corpus.dataset import (
    DatasetError,
    open_dataset,
    read_entries,
    store_scene,
    write_manifest,
)
from aeroscene.corpus.shipped import open_shipped
from aeroscene.scene import Scene
from scenarios.dataset import shipping
from scenarios.dataset.build import build
from scenarios.dataset.shipping import CorpusMaker, ModelMaker, pack_shipped, plan_shipped
from tests.aeroscene.conftest import cached_scene, renamed


@dataclass(frozen=True)
class PickyMaker:
    """Rejects a draw, then makes a scene with a floating tree, then a sound one."""

    name: str = "picky"
    checkpoint: str = "0123"

    def draw(self, number: int, attempt: int) -> Scene | None:
        if attempt == 0:
            return None
        scene = replace(cached_scene(7), seed=number)
        scene = renamed(scene, f"aeroscene-{number:04d}")
        return raise_a_tree(scene) if attempt == 1 else scene


@dataclass(frozen=True)
class HopelessMaker:
    name: str = "hopeless"
    checkpoint: str = ""

    def draw(self, *_) -> Scene | None:
        return raise_a_tree(cached_scene(7))


def raise_a_tree(scene):
    tree = next(obj for obj in scene.objects if obj.category == "tree")
    x, y, z = tree.bbox.p
    up = replace(tree, bbox=replace(tree.bbox, p=(x, y, z + 3.0)))
    objects = tuple(up if obj.id == tree.id else obj for obj in scene.objects)
    return replace(scene, objects=objects, interaction_areas=())


def made(folder, numbers, maker):
    """Build and give the numbers that were made."""
    plan = plan_shipped(folder, numbers, maker)
    numbers = []
    build(plan, 1, lambda entry: numbers.append(entry.index))
    return numbers


def test_a_scene_is_drawn_until_nothing_is_wrong_with_it(tmp_path):
    assert made(tmp_path, (5,), PickyMaker()) == [5]
    (entry,) = read_entries(tmp_path)
    assert (entry.index, entry.scene_id, entry.attempt) == (5, "aeroscene-0005", 2)
    assert open_dataset(tmp_path).read(entry).seed == 5


def test_a_number_that_is_never_sound_is_named_with_the_reason(tmp_path):
    with pytest.raises(
        DatasetError, match=r"scene 3: none of 20 draws .* no landing area; .* valid: a be"
    ):
        made(tmp_path, (3,), HopelessMaker())


def test_what_is_there_stays_until_something_else_makes_it(tmp_path):
    maker = PickyMaker()
    assert made(tmp_path, (5,), maker) == [5]
    assert made(tmp_path, (5, 6), maker) == [6]
    assert made(tmp_path, (5, 6), PickyMaker(checkpoint="4567")) == [5, 6]


def test_corpus_scenes_stand_in_for_a_rehearsal(tmp_path):
    made(tmp_path, (7,), CorpusMaker())
    (entry,) = read_entries(tmp_path)
    assert (entry.scene_id, entry.attempt) == ("corpus-0007", 0)


def test_weights_that_are_not_there_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="absent"):
        plan_shipped(tmp_path, (0,), ModelMaker(tmp_path / "absent", "cpu"))


def test_the_archive_is_packed_when_all_scenes_are_there(tmp_path, monkeypatch):
    monkeypatch.setattr(shipping, "CORPUS_SIZE", 3)
    folder, path, maker = tmp_path / "folder", tmp_path / "archive", PickyMaker()
    made(folder, (0, 2), maker)
    with pytest.raises(DatasetError, match="1 scenes are missing in"):
        pack_shipped(open_dataset(folder), path, maker, "cpu", lambda: None)
    made(folder, (0, 1, 2), maker)
    told = []
    size = pack_shipped(open_dataset(folder), path, maker, "cpu", lambda: told.append(1))
    assert (size, len(told)) == (path.stat().st_size, 3)
    archive = open_shipped(path)
    assert archive.read(archive.entries[1]) == open_dataset(folder).read(read_entries(folder)[1])
    with ZipFile(path) as file:
        found = json.loads(file.read("provenance.json"))
    assert (found["generator"], found["checkpoint"]) == ("picky", "0123")
    assert found["attempts"] == {"0": 2, "1": 2, "2": 2}
    assert found["code"].endswith(shipping.code_digest())
    assert found["environment"]["device"] == "cpu"


def test_scenes_of_another_checkpoint_are_not_packed(tmp_path, monkeypatch):
    monkeypatch.setattr(shipping, "CORPUS_SIZE", 1)
    entry = store_scene_in(tmp_path, cached_scene(7))
    write_manifest(tmp_path, [entry])
    with pytest.raises(DatasetError, match="made by something else; valid: all of them from one"):
        pack_shipped(open_dataset(tmp_path), tmp_path / "a", PickyMaker(), "cpu", lambda: None)


def store_scene_in(folder, scene):
    (folder / "scenes").mkdir()
    return store_scene(folder, scene, 0, "other")
