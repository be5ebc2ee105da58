"""Scenes of an archive are read like those of a folder; those in the package are all there."""

from __future__ import annotations

import pickle

import pytest

from aeroscene.corpus.corpus import CORPUS_SIZE, scene_domain
from aeroscene.corpus.shipped import SHIPPED, ArchiveError, open_shipped, read_shipped, scenes


def test_scenes_are_read_one_by_one_or_all_in_order(archive_path, archived_scenes):
    dataset = open_shipped(archive_path)
    assert dataset.read(dataset.entries[17]) == archived_scenes[17]
    assert list(dataset.select({1, 18}).scenes()) == [archived_scenes[1], archived_scenes[18]]


def test_splits_are_parts(archive_path):
    dataset = open_shipped(archive_path)
    assert [entry.index for entry in dataset.of_split("test").entries] == [0, 5, 10, 15]
    assert len(dataset.of_split("train").entries) == 15


def test_another_process_needs_little_to_read_them(archive_path, archived_scenes):
    dataset = open_shipped(archive_path)
    sent = pickle.dumps(dataset.select(()))
    assert len(sent) < 500
    assert pickle.loads(sent).read(dataset.entries[2]) == archived_scenes[2]


def test_a_package_without_its_archive_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(scenes, "SHIPPED", tmp_path / "scenes.aeroscenes")
    for read in (open_shipped, lambda: read_shipped(42)):
        with pytest.raises(ArchiveError, match=r"installing it again brings it back"):
            read()


def test_the_scenes_that_come_with_the_package_are_all_there_and_small():
    assert SHIPPED.stat().st_size <= 5e6
    dataset = open_shipped()
    assert [entry.index for entry in dataset.entries] == list(range(CORPUS_SIZE))
    assert len({entry.scene_id for entry in dataset.entries}) == CORPUS_SIZE
    assert all(entry.domain == scene_domain(entry.index) for entry in dataset.entries)
    for number in range(0, CORPUS_SIZE, 97):
        entry, scene = dataset.entries[number], read_shipped(number)
        assert (scene.scene_id, len(scene.objects)) == (entry.scene_id, entry.n_objects)


def test_every_scene_that_comes_with_the_package_starts_on_a_pad():
    for scene in open_shipped().scenes():
        starts = [obj for obj in scene.objects if obj.attributes.get("is_start") is True]
        assert [obj.category for obj in starts] == ["landing_pad"], scene.scene_id
