import hashlib
import json
import struct
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.corpus.shipped import ArchiveError, open_archive, write_archive
from aeroscene.scene import SceneError
from aeroscene.scene.io import scene_to_json
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.corpus.shipped.scenes import renamed


def read_all(path):
    archive = open_archive(path)
    archive.summaries()
    return [archive.read(number) for number in range(len(archive))]


def test_every_scene_comes_back_byte_for_byte_in_any_order(archive_path, archived_scenes):
    archive = open_archive(archive_path)
    assert len(archive) == len(archived_scenes)
    for number in (18, 0, 17, 3, 15, 16):
        expected = scene_to_json(archived_scenes[number])
        assert scene_to_json(archive.read(number)) == expected


def test_the_header_says_in_plain_text_what_made_the_scenes(archive_path, provenance):
    assert open_archive(archive_path).provenance == provenance
    assert b'"checkpoint":""' in archive_path.read_bytes()[:2000]
    assert b'"attempts":{"3":2}' in archive_path.read_bytes()[:2000]


def test_summaries_say_what_is_in_each_scene(archive_path, archived_scenes):
    summaries = open_archive(archive_path).summaries()
    assert [summary.index for summary in summaries] == list(range(len(archived_scenes)))
    for summary, scene in zip(summaries, archived_scenes, strict=True):
        assert (summary.scene_id, summary.domain) == (scene.scene_id, scene.domain)
        assert summary.n_objects == len(scene.objects)
        assert summary.n_coarse == sum(obj.is_coarse for obj in scene.objects)
        assert summary.n_landing == len(scene.landing_areas)
        assert summary.n_perching == len(scene.perching_areas)
        assert summary.split == ("test" if summary.index % 5 == 0 else "train")


def test_equal_scenes_make_equal_files(tmp_path, provenance):
    scenes = [cached_scene(42)]
    paths = tmp_path / "a", tmp_path / "b"
    for path in paths:
        write_archive(path, scenes, provenance)
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize("number", [-1, 19, 1016])
def test_a_number_that_is_none_of_the_archives_is_named(archive_path, number):
    with pytest.raises(ArchiveError, match=rf"scene {number} is not in .*, valid: 0 to 18"):
        open_archive(archive_path).read(number)


@pytest.fixture(scope="session")
def small_archive(tmp_path_factory, provenance):
    scene = cached_scene(42)
    bare = replace(scene, objects=scene.objects[:4], interaction_areas=())
    path = tmp_path_factory.mktemp("small") / "small"
    write_archive(path, [renamed(bare, f"s-{i}") for i in range(17)], provenance)
    return path


@settings(max_examples=200)
@given(st.data())
def test_whichever_byte_is_changed_the_damage_is_noticed(small_archive, tmp_path_factory, data):
    content = bytearray(small_archive.read_bytes())
    place = data.draw(st.integers(0, len(content) - 1))
    content[place] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.mktemp("damaged") / "archive"
    path.write_bytes(content)
    with pytest.raises(ArchiveError, match=r"is damaged|version") as caught:
        read_all(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.05, 0.5, 0.999])
def test_a_file_that_is_cut_short_is_damaged(archive_path, tmp_path, share):
    content = archive_path.read_bytes()
    path = tmp_path / "cut"
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(
        ArchiveError, match=r"'.*cut' is damaged \(.*cut short.*\), valid: the file that comes with"
    ):
        read_all(path)


def test_another_version_is_named(archive_path, tmp_path):

    header = json.dumps({"format": "aeroscene-archive", "version": 9, "unheard": 1}).encode()
    magic = archive_path.read_bytes()[:8]
    path = tmp_path / "new"
    path.write_bytes(
        magic + struct.pack("<I32s", len(header), hashlib.sha256(header).digest()) + header
    )
    with pytest.raises(ArchiveError, match=r"version 9, valid: 'aeroscene-archive' version 1"):
        open_archive(path)


def test_an_archive_that_is_not_there_says_how_to_get_it(tmp_path):
    with pytest.raises(SceneError, match=r"no such file or directory\), valid: the file .* again"):
        open_archive(tmp_path / "absent")
    with pytest.raises(SceneError, match="is a directory"):
        open_archive(tmp_path)
