"""Scenes of an archive are read like those of a folder; those in the package are all there."""

from __future__ import annotations

import os
import pickle
from contextlib import suppress
from dataclasses import replace
from zipfile import ZipFile, ZipInfo

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.corpus import shipped
from aeroscene.corpus.corpus import CORPUS_SIZE, scene_domain
from aeroscene.corpus.shipped import (
    SHIPPED,
    ArchiveError,
    open_shipped,
    read_shipped,
    write_archive,
)
from aeroscene.files.bounds import MOST_JSON_BYTES
from aeroscene.scene.io import read_scene, scene_to_json
from tests.aeroscene.conftest import cached_scene, renamed
from tests.thorough import IS_THOROUGH


def test_every_scene_comes_back_byte_for_byte_in_any_order(archive_path, archived_scenes):
    dataset = open_shipped(archive_path)
    for number in (18, 0, 17, 3, 15, 16):
        found = dataset.read(dataset.entries[number])
        assert scene_to_json(found) == scene_to_json(archived_scenes[number])
    assert list(dataset.select({1, 18}).scenes()) == [archived_scenes[1], archived_scenes[18]]


def test_summaries_say_what_is_in_each_scene(archive_path, archived_scenes):
    summaries = open_shipped(archive_path).entries
    assert [summary.index for summary in summaries] == list(range(len(archived_scenes)))
    for summary, scene in zip(summaries, archived_scenes, strict=True):
        assert (summary.scene_id, summary.domain) == (scene.scene_id, scene.domain)
        assert summary.n_objects == len(scene.objects)
        assert summary.n_coarse == sum(obj.is_coarse for obj in scene.objects)
        assert summary.n_landing == len(scene.landing_areas)
        assert summary.n_perching == len(scene.perching_areas)


def test_splits_are_parts(archive_path):
    dataset = open_shipped(archive_path)
    assert [entry.index for entry in dataset.of_split("test").entries] == [0, 5, 10, 15]
    assert len(dataset.of_split("train").entries) == 15


def test_any_zip_program_unpacks_scene_files(archive_path, archived_scenes, tmp_path):
    with ZipFile(archive_path) as archive:
        path = archive.extract("scenes/0017.json", tmp_path)
    assert read_scene(path) == archived_scenes[17]


def test_equal_scenes_make_equal_files(tmp_path, provenance):
    paths = tmp_path / "a", tmp_path / "b"
    for path in paths:
        write_archive(path, [cached_scene(42)], provenance)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_another_process_needs_little_to_read_them(archive_path, archived_scenes):
    dataset = open_shipped(archive_path)
    sent = pickle.dumps(dataset.select(()))
    assert len(sent) < 500
    assert pickle.loads(sent).read(dataset.entries[2]) == archived_scenes[2]


def test_a_forked_process_opens_the_file_itself(archive_path):
    open_shipped(archive_path)
    child = os.fork()
    if child == 0:
        os._exit(shipped._opened.cache_info().currsize)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.parametrize("number", [-1, 19, 1016])
def test_a_number_that_is_none_of_the_archives_is_named(archive_path, number, monkeypatch):
    monkeypatch.setattr(shipped, "SHIPPED", archive_path)
    with pytest.raises(ArchiveError, match=rf"scene {number} is not in .*; valid: 0 to 18"):
        read_shipped(number)


@pytest.fixture(scope="session")
def small_archive(tmp_path_factory, provenance):
    scene = cached_scene(42)
    bare = replace(scene, objects=scene.objects[:4], interaction_areas=())
    path = tmp_path_factory.mktemp("small") / "small"
    write_archive(path, [renamed(bare, f"s-{i}") for i in range(3)], provenance)
    return path


def read_all(path):
    return list(open_shipped(path).scenes())


@settings(max_examples=300 if IS_THOROUGH else 100)
@given(st.data())
def test_a_changed_byte_never_gives_another_scene(small_archive, tmp_path_factory, data):
    content = bytearray(small_archive.read_bytes())
    place = data.draw(st.integers(0, len(content) - 1))
    content[place] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.mktemp("damaged") / "archive"
    path.write_bytes(content)
    with suppress(ArchiveError):
        assert read_all(path) == read_all(small_archive)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.05, 0.5, 0.999])
def test_a_file_that_is_cut_short_is_damaged(archive_path, tmp_path, share):
    content = archive_path.read_bytes()
    path = tmp_path / "cut"
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(
        ArchiveError, match=r"'.*cut' is damaged \(cut short .*\); valid: the file that comes with"
    ):
        read_all(path)


def test_a_scene_that_would_fill_the_memory_is_not_unpacked(tmp_path):
    path = tmp_path / "large"
    with ZipFile(path, "w") as archive:
        archive.writestr(ZipInfo("summaries.json"), b" " * (MOST_JSON_BYTES + 1))
    with pytest.raises(ArchiveError, match="is damaged"):
        open_shipped(path)


@pytest.mark.parametrize("name", ["", "absent"])
def test_an_archive_that_is_not_there_says_how_to_get_it(tmp_path, monkeypatch, name):
    monkeypatch.setattr(shipped, "SHIPPED", tmp_path / name)
    for read in (open_shipped, lambda: read_shipped(42)):
        with pytest.raises(
            ArchiveError, match=r"(no such file or|is a) directory\); .* installing it again"
        ):
            read()


def test_the_scenes_that_come_with_the_package_are_all_there_and_small():
    assert SHIPPED.stat().st_size <= 12e6
    dataset = open_shipped()
    assert [entry.index for entry in dataset.entries] == list(range(CORPUS_SIZE))
    assert len({entry.scene_id for entry in dataset.entries}) == CORPUS_SIZE
    assert all(entry.domain == scene_domain(entry.index) for entry in dataset.entries)
    for number in range(0, CORPUS_SIZE, 97):
        entry, scene = dataset.entries[number], read_shipped(number)
        assert (scene.scene_id, len(scene.objects)) == (entry.scene_id, entry.n_objects)


def test_every_scene_that_comes_with_the_package_starts_on_a_pad():
    dataset = open_shipped()
    # All of them take eight CPU seconds to read.
    for entry in dataset.entries[:: 1 if IS_THOROUGH else 7]:
        scene = dataset.read(entry)
        starts = [obj for obj in scene.objects if obj.attributes.get("is_start") is True]
        assert [obj.category for obj in starts] == ["landing_pad"], scene.scene_id
