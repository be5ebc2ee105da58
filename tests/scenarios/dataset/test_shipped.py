"""`aeroscene dataset` on scenes that ship: an archive in the place of the package's own."""

import json
import re

import pytest

from aeroscene.corpus import shipped
from aeroscene.corpus.shipped import Provenance, write_archive
from aeroscene.scene.io import read_scene
from tests.aeroscene.conftest import cached_scene, renamed
from tests.scenarios.in_process import in_process


@pytest.fixture(scope="module")
def members():
    """Scenes of three domains under new names."""
    return [
        renamed(cached_scene(index), f"aeroscene-{i:04d}") for i, index in enumerate((42, 7, 311))
    ]


@pytest.fixture(scope="module")
def archive(tmp_path_factory, members):
    path = tmp_path_factory.mktemp("shipped") / "scenes.zip"
    provenance = Provenance(
        generator="curation", checkpoint="", code="0", environment={}, attempts={}
    )
    write_archive(path, members, provenance)
    return path


@pytest.fixture(autouse=True)
def package(archive, tmp_path, monkeypatch):
    """The package has that archive; nothing is in the folder where the user is."""
    monkeypatch.setattr(shipped, "SHIPPED", archive)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(capsys, *args):
    return in_process(capsys, "dataset", *args)


@pytest.mark.parametrize("data", [[], ["shipped"]])
def test_stats_count_the_shipped_scenes(capsys, members, data):
    status, out, err = run(capsys, "stats", *data, "--jobs", 1, "--json")
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert found["objects"]["value"] == sum(len(scene.objects) for scene in members)
    assert found["diversity"][0]["name"] == "shipped scenes"


def test_stats_say_what_they_are_of(capsys):
    _, out, _ = run(capsys, "stats", "--jobs", 1)
    assert "The shipped scenes beside the paper's dataset" in out
    assert "Most alike in the shipped scenes: aeroscene-000" in out


def test_a_folder_called_corpus_goes_before_them(capsys, package):
    (package / "corpus").mkdir()
    status, _, err = run(capsys, "stats", "--jobs", 1)
    assert status == 2
    assert "'corpus' holds no dataset" in err
    assert run(capsys, "stats", "shipped", "--scenes", "0", "--jobs", 1)[0] == 0


def test_validate_checks_them_in_other_processes_too(capsys):
    status, out, err = run(capsys, "validate", "--jobs", 2, "--drops", 3, "--json")
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert (found["scenes"], sum(found["findings"].values())) == (3, 0)
    assert found["drops"]["share"] == 1.0


def test_show_draws_them(capsys, package):
    args = ("--width", 80, "--jobs", 1, "--scenes", "2")
    status, out, err = run(capsys, "show", *args)
    assert (status, out, err) == (0, "sheet.png: 1 scenes\n", "")
    assert (package / "sheet.png").stat().st_size > 1000


def test_scenes_are_unpacked_as_files_that_open_again(capsys, members, package):
    status, out, err = run(capsys, "unpack", "--out", "mine", "--jobs", 1)
    assert (status, err) == (0, "")
    assert re.fullmatch(r"mine: 3 scenes, 0\.\d MB\n", out)
    names = sorted(path.name for path in (package / "mine").iterdir())
    assert names == [f"aeroscene-{i:04d}.json" for i in range(3)]
    assert [read_scene(package / "mine" / name) for name in names] == members


def test_unpacking_some_compressed_reports_one_object(capsys, members, package):
    args = ("--out", "some", "--scenes", "1:3", "--gzip", "--jobs", 1, "--json")
    status, out, _ = run(capsys, "unpack", *args)
    assert status == 0
    files = sorted((package / "some").iterdir())
    assert [path.name for path in files] == ["aeroscene-0001.json.gz", "aeroscene-0002.json.gz"]
    n_bytes = sum(path.stat().st_size for path in files)
    assert json.loads(out) == {"folder": "some", "scenes": 2, "bytes": n_bytes}
    assert read_scene(files[0]) == members[1]


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["stats", "--scenes", "3"], "scene 3 is not in '{archive}'"),
        (["unpack", "--scenes", "2:4"], "valid: 0 to 2"),
        (["unpack", "--out", "{archive}"], "{archive}"),
        (["unpack", "--jobs", "0"], "jobs 0 is out of range"),
        (["unpack", "--scenes", "x"], "scenes 'x'"),
    ],
)
def test_bad_input_ends_with_status_2_and_one_line(archive, capsys, args, says):
    status, out, err = run(capsys, *(arg.format(archive=archive) for arg in args))
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert line.startswith("aeroscene dataset")
    assert says.format(archive=archive) in line


@pytest.mark.parametrize("command", ["stats", "validate", "show", "unpack"])
def test_a_damaged_archive_gives_one_line(archive, package, capsys, monkeypatch, command):
    damaged = package / "damaged"
    damaged.write_bytes(archive.read_bytes()[:-100])
    monkeypatch.setattr(shipped, "SHIPPED", damaged)
    status, out, err = run(capsys, command, "--jobs", 1)
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert f"archive '{damaged}' is damaged (cut short or changed); valid:" in line


def test_an_archive_that_is_not_there_gives_one_line(package, capsys, monkeypatch):
    monkeypatch.setattr(shipped, "SHIPPED", package / "absent")
    status, _, err = run(capsys, "stats")
    assert status == 2
    assert err.count("\n") == 1
    assert "cannot be read (no such file or directory)" in err
