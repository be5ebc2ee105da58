import errno
from dataclasses import replace

import pytest

from aeroscene.corpus.field import field_scene
from flightsim.export.files import ExportError, staged
from flightsim.export.glb import write_glb
from flightsim.export.mjcf import write_mjcf
from flightsim.export.usd import write_usd
from flightsim.world import build_world


def test_what_fails_half_way_leaves_the_folder_as_it_was(tmp_path):
    (tmp_path / "kept.txt").write_text("before")

    def write():
        with staged(tmp_path) as stage:
            (stage / "kept.txt").write_text("after")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write()
    assert [path.name for path in tmp_path.iterdir()] == ["kept.txt"]
    assert (tmp_path / "kept.txt").read_text() == "before"


def test_what_succeeds_replaces_and_adds(tmp_path):
    (tmp_path / "kept.txt").write_text("before")
    with staged(tmp_path) as stage:
        (stage / "kept.txt").write_text("after")
        (stage / "textures").mkdir()
        (stage / "textures" / "wood.png").write_bytes(b"png")
    assert (tmp_path / "kept.txt").read_text() == "after"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["kept.txt", "textures", "wood.png"]


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match=r"file/out.*cannot be written"):
        staged(tmp_path / "file" / "out").__enter__()


@pytest.mark.parametrize("write", [write_glb, write_mjcf, write_usd])
@pytest.mark.parametrize("scene_id", ["../../x", "{folder}/x", "a/b", "x" * 200])
def test_the_id_of_a_scene_never_decides_where_an_export_lies(write, scene_id, tmp_path):
    out = tmp_path / "far" / "out"
    plain = field_scene()
    scene_id = scene_id.format(folder=tmp_path)
    objects = tuple(replace(each, scene_id=scene_id) for each in plain.objects)
    scene = replace(plain, scene_id=scene_id, objects=objects)
    path = write(build_world(scene), out)
    assert path.parent == out
    assert path.is_file()
    written = {each for each in tmp_path.rglob("*") if each.is_file()}
    assert all(out in each.parents for each in written)


def test_a_disk_that_fills_up_on_the_way_is_one_line_and_leaves_nothing(tmp_path):
    def write():
        with staged(tmp_path / "out") as stage:
            (stage / "half.glb").write_bytes(b"half")
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(ExportError, match=r"cannot be written \(no space left on device\); valid"):
        write()
    assert list((tmp_path / "out").iterdir()) == []
