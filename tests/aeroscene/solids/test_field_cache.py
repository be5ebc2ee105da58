"""Distance fields that are kept: the same to the bit, and never a wrong one."""

import dataclasses
import os

import numpy as np
import pytest

from aeroscene.solids import field_cache
from aeroscene.solids.field_cache import cached_distance_field, forget
from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.shapes import scene_primitives


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A cache of the test's own, and a process that remembers nothing."""
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    monkeypatch.delenv("AEROSCENE_CACHE", raising=False)
    forget()
    yield tmp_path / "fields"
    forget()


def kept(scene, resolution_m=0.5):
    return cached_distance_field(scene, resolution_m, scene_primitives(scene))


def assert_same(field, other):
    assert field.origin_enu_m == other.origin_enu_m
    assert field.distance_m.dtype == other.distance_m.dtype
    np.testing.assert_array_equal(field.distance_m, other.distance_m)


@pytest.mark.parametrize("resolution_m", [0.5, 0.3])
def test_what_is_read_back_is_what_was_built(scene_42, folder, resolution_m):
    built = build_distance_field(scene_42, resolution_m)
    assert_same(kept(scene_42, resolution_m), built)
    assert len(list(folder.iterdir())) == 1
    forget()
    assert_same(kept(scene_42, resolution_m), built)


def test_within_the_process_it_is_the_same_object(scene_42, folder):
    first = kept(scene_42)
    for path in folder.iterdir():
        path.unlink()
    assert kept(scene_42) is first


def test_another_scene_or_resolution_has_a_field_of_its_own(scene_42, folder):
    kept(scene_42)
    kept(scene_42, 0.4)
    fewer = dataclasses.replace(scene_42, objects=scene_42.objects[:-1], interaction_areas=())
    kept(fewer)
    x, y, z = scene_42.extent_max_enu_m
    kept(dataclasses.replace(scene_42, extent_max_enu_m=(x, y, z + 1.0)))
    assert len(list(folder.iterdir())) == 4


@pytest.mark.parametrize("damage", ["cut", "changed", "foreign", "empty"])
def test_a_damaged_file_is_built_anew(scene_42, folder, damage):
    built = kept(scene_42)
    (path,) = folder.iterdir()
    data = path.read_bytes()
    middle = len(data) // 2
    path.write_bytes(
        {
            "cut": data[:middle],
            "changed": data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :],
            "foreign": b"something else altogether",
            "empty": b"",
        }[damage]
    )
    forget()
    assert_same(kept(scene_42), built)
    assert path.read_bytes() == data


def test_it_can_be_turned_off(scene_42, folder, monkeypatch):
    monkeypatch.setenv("AEROSCENE_CACHE", "off")
    assert_same(kept(scene_42), build_distance_field(scene_42, 0.5))
    assert not folder.exists()


def test_the_oldest_go_when_there_are_too_many(scene_42, folder, monkeypatch):
    kept(scene_42)
    (old,) = folder.iterdir()
    os.utime(old, (1.0, 1.0))
    monkeypatch.setattr(field_cache, "BUDGET_BYTES", old.stat().st_size + 10)
    kept(scene_42, 0.6)
    assert not old.exists()
    assert len(list(folder.iterdir())) == 1


def test_a_folder_that_cannot_be_written_costs_nothing_but_time(scene_42, tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(blocked))
    assert_same(kept(scene_42), build_distance_field(scene_42, 0.5))
