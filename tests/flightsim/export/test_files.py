import pytest

from flightsim.export.files import ExportError, staged


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
