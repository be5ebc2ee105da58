"""Mapped layouts come back from the cache as they were, and from nowhere else."""

import json

import pytest

from aeroscene.layouts import LayoutError, scene_cache
from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.layouts.scene_cache import count_layouts, mapped_scenes
from tests.aeroscene.layouts.samples import block, house


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("AEROSCENE_CACHE", raising=False)
    return tmp_path / "cache" / "layouts"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "two.jsonl"
    path.write_text("\n".join(json.dumps(record) for record in (house(), block())))
    return path


@pytest.fixture
def mapping(monkeypatch):
    """How often something is mapped."""
    calls = []
    real = scene_cache._mapped
    monkeypatch.setattr(scene_cache, "_mapped", lambda *args: calls.append(args) or real(*args))
    return calls


def test_scenes_are_mapped_once_and_come_back_to_the_bit(file, cache, mapping):
    seen = []
    first = mapped_scenes(file, lambda: seen.append(None))
    assert first == [make_flyable(neutral_layout(each))[0] for each in (house(), block())]
    assert mapped_scenes(file, lambda: seen.append(None)) == first
    assert (len(mapping), len(seen), len(list(cache.iterdir()))) == (1, 4, 1)
    assert count_layouts(file) == 2


@pytest.mark.parametrize("damage", [lambda d: d[:-40], lambda d: d[:-1] + b"x", lambda _: b""])
def test_a_damaged_file_is_made_again(file, cache, mapping, damage):
    first = mapped_scenes(file)
    (path,) = cache.iterdir()
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert mapped_scenes(file) == first
    assert len(mapping) == 2
    assert path.read_bytes() == whole


def test_another_file_or_other_sources_are_mapped_anew(file, mapping, monkeypatch):
    mapped_scenes(file)
    text = file.read_text()
    file.write_text(text.replace("FloorLamp", "Candle"))
    mapped_scenes(file)
    assert len(mapping) == 2
    file.write_text(text)
    monkeypatch.setattr(scene_cache, "_code", lambda: b"other")
    mapped_scenes(file)
    assert len(mapping) == 3


def test_only_the_last_files_are_kept(file, cache, monkeypatch):
    monkeypatch.setattr(scene_cache, "MOST_KEPT", 2)
    for name in ("Candle", "Vase", "Chair"):
        file.write_text(json.dumps(house()).replace("FloorLamp", name))
        mapped_scenes(file)
    assert len(list(cache.iterdir())) == 2


def test_a_cache_that_is_off_or_cannot_be_written_costs_only_time(
    file, cache, mapping, monkeypatch, tmp_path
):
    monkeypatch.setenv("AEROSCENE_CACHE", "off")
    first = mapped_scenes(file)
    assert not cache.exists()
    monkeypatch.delenv("AEROSCENE_CACHE")
    (tmp_path / "blocked").write_text("a file")
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path / "blocked"))
    assert mapped_scenes(file) == first
    assert len(mapping) == 2


def test_faults_are_named_and_nothing_is_kept(file, cache):
    file.write_text(json.dumps(house()) + "\n{")
    with pytest.raises(LayoutError, match="line 2"):
        mapped_scenes(file)
    assert not cache.exists()
