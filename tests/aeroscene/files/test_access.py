import gzip
import os
import tracemalloc

import pytest

from aeroscene.files import UnpackError, read_bounded, replacing
from aeroscene.layouts import text_file
from aeroscene.scene import SceneError, io
from aeroscene.sources import load_scene


def test_a_file_is_replaced_when_all_of_it_is_written(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")
    with replacing(path) as file:
        file.write(b"new")
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_what_goes_wrong_leaves_everything_as_it_was(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")

    def stop_halfway():
        with replacing(path) as file:
            file.write(b"ne")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stop_halfway()
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_gzip_is_unpacked_whatever_its_name(tmp_path):
    path = tmp_path / "packed.json"
    path.write_bytes(gzip.compress(b"content"))
    assert read_bounded(path, 100) == b"content"
    path.write_bytes(gzip.compress(b"content")[:-9])
    with pytest.raises(UnpackError, match="damaged or cut short"):
        read_bounded(path, 100)


@pytest.mark.parametrize("name", ["bomb.json", "bomb.json.gz", "bomb.jsonl"])
@pytest.mark.parametrize("is_packed", [True, False])
def test_a_file_that_holds_too_much_is_refused_in_one_line(tmp_path, monkeypatch, name, is_packed):
    for module, bound in (
        (io, "MOST_JSON_BYTES"),
        (text_file, "MOST_BYTES"),
        (text_file, "MOST_LINES_BYTES"),
    ):
        monkeypatch.setattr(module, bound, 1 << 20)
    path = tmp_path / name
    content = bytes((1 << 20) + 1)
    path.write_bytes(gzip.compress(content) if is_packed else content)
    with pytest.raises(
        SceneError, match=r"bomb\.json.*: holds more than 1 MiB; valid: at most"
    ) as e:
        load_scene(str(path))
    assert "\n" not in str(e.value)


def _peak_bytes(work):
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_what_unpacks_to_too_much_takes_no_more_memory_than_is_allowed(tmp_path):
    path = tmp_path / "bomb.json"
    path.write_bytes(gzip.compress(bytes(1 << 20)) * 65)

    def refuse():
        with pytest.raises(UnpackError, match="holds more than 2 MiB"):
            read_bounded(path, 2 << 20)

    assert _peak_bytes(refuse) < 4 << 20


def test_what_is_unpacked_is_kept_once(tmp_path):
    path = tmp_path / "large.json"
    path.write_bytes(gzip.compress(bytes(1 << 20)) * 32)
    assert _peak_bytes(lambda: read_bounded(path, 32 << 20)) < 40 << 20


@pytest.mark.parametrize("name", ["pipe.json", "pipe.json.gz", "pipe.jsonl"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, name):
    path = tmp_path / name
    os.mkfifo(path)
    with pytest.raises(
        SceneError, match=r"pipe\.json.*cannot be read \(no regular file\); valid: a"
    ):
        load_scene(str(path))
