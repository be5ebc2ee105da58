"""`aeroscene images` as a user meets it: whole builds, stopped ones, and what is refused."""

import fcntl
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from scipy.spatial import cKDTree

from aeroscene.sources import load_scene
from scenarios.cli import images
from scenarios.images.build import JOURNAL, MANIFEST, read_manifest
from scenarios.images.place import ROOM_M, Place
from scenarios.images.poses import Flight, draw_free
from scenarios.images.request import ImagesError, ImagesRequest, parse_fov, parse_sizes
from tests.scenarios.in_process import in_process

REQUEST = ("--scenes", "field", "--count", 6, "--size", "64x48,48x64", "--frames-per-light", 2)


def run(capsys, out, *args):
    return in_process(capsys, "images", *REQUEST, "--out", out, *args)


def start(out, *args):
    # A shell's background job ignores Ctrl-C, and so would its children.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    words = ["images", *REQUEST, "--out", out, *args]
    try:
        return subprocess.Popen(
            [sys.executable, "-m", "scenarios.cli.main", *map(str, words)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
    finally:
        signal.signal(signal.SIGINT, before)


def wait_for_a_shard(process, folder):
    journal = folder / JOURNAL
    while not (journal.exists() and b"\n" in journal.read_bytes().lstrip(b"\n")):
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A whole set, made by two processes."""
    folder = tmp_path_factory.mktemp("built") / "set"
    process = start(folder, "--jobs", 2, "--json")
    out, err = process.communicate()
    assert process.returncode == 0, err
    assert err == ""
    return folder, json.loads(out)


def test_a_set_has_shards_a_coco_file_and_a_manifest(built):
    folder, said = built
    assert said == {
        "folder": str(folder),
        "frames": 6,
        "made": 6,
        "kept": 0,
        "shards": 3,
        "bytes": sum(path.stat().st_size for path in folder.glob("shards/*")),
        "seconds": said["seconds"],
    }
    names = sorted(contents(folder))
    jpegs = [f"coco/images/{frame // 2:06d}/{frame:07d}.jpg" for frame in range(6)]
    tars = [f"shards/images-{number:06d}.tar" for number in range(3)]
    assert names == ["coco/annotations.json", *jpegs, MANIFEST, *tars]


def test_shards_differ_in_light_and_size(built):
    annotations = json.loads((built[0] / "coco/annotations.json").read_bytes())
    assert len({(row["light"], row["season"]) for row in annotations["images"]}) == 3
    assert {(row["width"], row["height"]) for row in annotations["images"]} == {(64, 48), (48, 64)}


def test_one_process_makes_the_same_bytes(built, tmp_path, capsys):
    status, out, err = run(capsys, tmp_path / "set", "--jobs", 1)
    assert (status, err) == (0, "")
    assert "6 frames in 3 shards" in out
    assert contents(tmp_path / "set") == contents(built[0])


def test_another_seed_makes_other_images(built, tmp_path, capsys):
    args = ("--jobs", 1, "--seed", 1, "--count", 1)
    status, _, _ = run(capsys, tmp_path / "set", *args)
    assert status == 0
    name = "coco/images/000000/0000000.jpg"
    assert contents(tmp_path / "set")[name] != contents(built[0])[name]


def test_a_set_that_was_killed_goes_on(built, tmp_path, capsys):
    folder = tmp_path / "set"
    process = start(folder, "--jobs", 1)
    wait_for_a_shard(process, folder)
    process.kill()
    process.communicate()
    # As a process leaves them that is killed while it writes.
    (folder / "shards" / ".images-000001.tar.abc").write_bytes(b"half")
    (folder / "coco" / "images" / ".000001.abc").mkdir()
    status, out, err = run(capsys, folder, "--jobs", 1, "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["kept"] >= 2
    assert contents(folder) == contents(built[0])
    assert not list(folder.rglob(".*"))


def test_ctrl_c_leaves_whole_shards_only(built, tmp_path, capsys):
    folder = tmp_path / "set"
    process = start(folder, "--jobs", 2)
    wait_for_a_shard(process, folder)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: the workers too
    out, err = process.communicate()
    if process.returncode == 0:
        pytest.skip("it was done before the signal came")
    assert (process.returncode, out) == (130, "")
    assert err == "aeroscene images: stopped; the same command goes on from here\n"
    manifest = read_manifest(folder)
    listed = {entry.file for entry in manifest.shards}
    assert {f"shards/{path.name}" for path in folder.glob("shards/*")} == listed
    assert len(list(folder.glob("coco/images/*"))) == len(listed)
    assert not [path for path in folder.rglob("*") if path.name.startswith(".")]
    assert not (folder / JOURNAL).exists()
    wanted = contents(built[0])
    assert all(wanted[name] == (folder / name).read_bytes() for name in listed)


def test_what_is_damaged_is_made_again(built, tmp_path, capsys):
    folder = tmp_path / "set"
    shutil.copytree(built[0], folder)
    with (folder / "shards/images-000001.tar").open("r+b") as file:
        file.seek(700)
        file.write(b"x")
    (folder / "coco/images/000002/0000005.jpg").unlink()
    status, out, _ = run(capsys, folder, "--jobs", 1, "--json")
    assert (status, json.loads(out)["made"], json.loads(out)["kept"]) == (0, 4, 2)
    assert contents(folder) == contents(built[0])


def test_shards_of_other_sources_are_made_again_and_said_so(built, tmp_path, capsys):
    folder = tmp_path / "set"
    shutil.copytree(built[0], folder)
    manifest = json.loads((folder / MANIFEST).read_bytes())
    manifest["shards"][0]["sources"] = "0" * 16
    (folder / MANIFEST).write_text(json.dumps(manifest))
    status, _, err = run(capsys, folder, "--jobs", 1)
    assert status == 0
    assert err == (
        f"aeroscene images: 1 shards in {folder} were made by other sources: they are made again\n"
    )
    assert contents(folder) == contents(built[0])


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--seed", 7), "holds images with seed 0, not 7; valid: the same options, or another"),
        (("--light", "night"), 'holds images with light "random", not "night"; valid: '),
        (("--fov", "90"), "holds images with fov_deg [60.0,100.0], not [90.0,90.0]; valid: "),
    ],
)
def test_two_sets_do_not_mix_in_a_folder(built, capsys, args, says):
    before = contents(built[0])
    status, out, err = run(capsys, built[0], *args)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert says in err
    assert contents(built[0]) == before


def test_a_folder_of_other_files_is_left_alone(tmp_path, capsys):
    (tmp_path / "mine.txt").touch()
    status, _, err = run(capsys, tmp_path)
    assert (status, err.count("\n")) == (2, 1)
    assert "holds other files; valid: a folder that is new" in err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_two_builds_in_one_folder_do_not_mix(built, capsys):
    with (built[0] / JOURNAL).open("ab") as journal:
        fcntl.flock(journal, fcntl.LOCK_EX)
        status, _, err = run(capsys, built[0])
    (built[0] / JOURNAL).unlink()
    assert status == 2
    assert "being built by another process" in err


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["--size", "640"], "size '640' is not valid; valid: WIDTHxHEIGHT, such as 640x480"),
        (["--size", "31x64"], "size '31x64' is not valid"),
        (["--size", "4096x4096"], "has 16,777,216 pixels; valid: at most 8,294,400"),
        (["--size", "640x480,²x64"], "size '²x64' is not valid"),
        (["--count", "1000000", "--size", "1920x1080"], "valid: at most 1e+12, 482253 frames"),
        (["--frames-per-light", "30", "--size", "3840x2160"], "valid: at most 24 frames of that"),
        (["--fov", "100:60"], "fov '100:60' is not valid; valid: degrees from left to right"),
        (["--fov", "nan"], "fov 'nan' is not valid"),
        (["--fov", "151"], "fov '151' is not valid"),
        (["--light", "sunny"], "light: 'sunny' is unknown; valid: "),
        (["--traffic", "cats=1"], "traffic 'cats=1': 'cats=1' is not valid"),
        (["--scenes", "0:1017"], "scenes '0:1017' has no scene 1016; valid: 0:1016"),
        (["--scenes", "9:3"], "scenes '9:3' is no range of scenes"),
        (["--scenes", ""], "scenes '' is no range of scenes"),
        (["--scenes", "0,fiel"], "scene 'fiel' is unknown; valid: "),
    ],
)
def test_bad_input_is_one_line_before_the_simulator_is_loaded(
    tmp_path, capsys, monkeypatch, args, says
):
    def loaded(*_):
        raise AssertionError("the work has begun")

    monkeypatch.setattr(images, "_build", loaded)
    out = tmp_path / "set"
    status, said, err = in_process(capsys, "images", "--out", out, *args)
    assert (status, said, err.count("\n")) == (2, "", 1)
    assert err.startswith("aeroscene images: error: ")
    assert says in err
    assert not out.exists()


def test_a_refusal_does_not_load_mujoco(tmp_path):
    code = (
        "import sys; from scenarios.cli.main import main\n"
        "try: main(sys.argv[1:])\n"
        "except SystemExit as stop: print(stop.code, 'mujoco' in sys.modules)"
    )
    words = ["images", "--out", str(tmp_path / "set"), "--light", "sunny"]
    done = subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, check=True
    )
    assert done.stdout == "2 False\n"


def test_frames_are_divided_evenly_over_scenes_and_lights():
    request = ImagesRequest(scenes=("0", "1", "2"), count=50, frames_per_light=10)
    shards = list(request.shards())
    assert [shard.number for shard in shards] == list(range(len(shards)))
    assert [frame for shard in shards for frame in shard.frames] == list(range(50))
    by_scene = {
        scene: sum(shard.n_frames for shard in shards if shard.scene == scene)
        for scene in request.scenes
    }
    assert by_scene == {"0": 17, "1": 17, "2": 16}
    assert max(shard.n_frames for shard in shards) == 10


@pytest.mark.parametrize("draw", ["free", "flights"])
def test_cameras_have_room_at_both_poses(draw):
    place = Place(load_scene("42"))
    rng = np.random.default_rng(4)
    flight = Flight(place, rng) if draw == "flights" else None
    heights, pitches = [], []
    for _ in range(40):
        pair = flight.draw(0.1, rng) if flight else draw_free(place, 0.1, rng)
        ends = np.array([pair.now.position_enu_m, pair.next.position_enu_m])
        assert place.is_free(ends).all()
        assert np.linalg.norm(ends[1] - ends[0]) < 1.0
        heights.append(place.height_m(ends[0]))
        turn = pair.now.rotation_enu_from_optical
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        pitches.append(np.degrees(np.arcsin(-turn[2, 2])))
        roll_deg = np.degrees(np.arcsin(np.clip(turn[2, 0], -1, 1)))
        assert abs(roll_deg) < 10.1
    assert min(heights) > 0.4
    if draw == "free":
        assert min(heights) < 2.0 < 10.0 < max(heights)
        assert min(pitches) < 10.0 < 75.0 < max(pitches)


def test_free_points_are_away_from_solids():
    scene = load_scene("42")
    place, rng = Place(scene), np.random.default_rng(0)
    points = np.array([place.draw(rng) for _ in range(100)])
    # Corners of boxes are on or outside of solids: none may be nearer than the room less a cell.
    corners = np.concatenate([obj.bbox.corners() for obj in scene.objects if not obj.is_coarse])
    nearest_m, _ = cKDTree(corners).query(points)
    assert nearest_m.min() > ROOM_M - 0.25


@pytest.mark.parametrize("text", ["640x480", "32x4096,100x100"])
def test_sizes_are_read(text):
    assert [f"{width}x{height}" for width, height in parse_sizes(text)] == text.split(",")


def test_a_field_of_view_is_one_number_or_a_range():
    assert parse_fov("90") == (90.0, 90.0)
    assert parse_fov("60:100") == (60.0, 100.0)
    with pytest.raises(ImagesError):
        parse_fov("60:")
