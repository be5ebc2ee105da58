"""`aeroscene dataset` as a user meets it: real builds in a process, then every command on them."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import cv2
import numpy as np
import pytest

from aeroscene.corpus.dataset import (
    JOURNAL,
    MANIFEST,
    open_dataset,
    read_entries,
    store_scene,
    write_manifest,
)
from aeroscene.scene.io import write_scene
from tests.scenarios.in_process import in_process

SCENES = "0:3"


def start(*args):
    # A shell's background job ignores Ctrl-C, and so would its children.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(
            [sys.executable, "-m", "scenarios.cli.main", "dataset", *map(str, args)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
    finally:
        signal.signal(signal.SIGINT, before)


def dataset(*args):
    """Run the command to its end."""
    process = start(*args)
    out, err = process.communicate()
    return process.returncode, out, err


def run(capsys, *args):
    """The same in this process; status, standard output, standard error."""
    return in_process(capsys, "dataset", *args)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dataset") / "corpus"
    status, out, err = dataset("build", "--out", folder, "--scenes", SCENES, "--jobs", 2, "--json")
    assert (status, err) == (0, "")
    return folder, json.loads(out)


@pytest.fixture
def corpus(built, tmp_path):
    """The built corpus, a copy to damage."""
    shutil.copytree(built[0], tmp_path / "corpus")
    return tmp_path / "corpus"


def part(folder):
    """What is said of the three scenes in a folder."""
    return (
        f"aeroscene dataset: folder {str(folder)!r} holds 3 of the 1,016 scenes; aeroscene dataset "
        "build makes the others\n"
    )


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_build_makes_files_and_a_manifest(built):
    folder, report = built
    assert {name: report[name] for name in ("folder", "scenes", "made", "kept")} == {
        "folder": str(folder),
        "scenes": 3,
        "made": 3,
        "kept": 0,
    }
    assert sorted(contents(folder)) == [
        "corpus-0000.json.gz",
        "corpus-0001.json.gz",
        "corpus-0002.json.gz",
        "manifest.json",
    ]
    assert report["bytes"] == sum(p.stat().st_size for p in (folder / "scenes").iterdir())
    assert {e.domain for e in open_dataset(folder).entries} == {"indoor", "outdoor", "mixed"}


def test_build_gives_the_same_bytes_with_one_process_and_step_by_step(built, tmp_path, capsys):
    folder = tmp_path / "again"
    assert run(capsys, "build", "--out", folder, "--scenes", "1", "--jobs", 1)[0] == 0
    status, out, _ = run(capsys, "build", "--out", folder, "--scenes", "2,0:2", "--jobs", 1)
    assert status == 0
    assert "3 scenes" in out
    assert "1 were there" in out
    assert contents(folder) == contents(built[0])


def test_build_goes_on_beyond_the_corpus_and_keeps_the_split_by_number(corpus, capsys):
    assert run(capsys, "build", "--out", corpus, "--scenes", "1020", "--jobs", 1)[0] == 0
    entries = open_dataset(corpus).entries
    assert [e.index for e in entries] == [0, 1, 2, 1020]
    assert [e.split for e in entries] == ["test", "train", "train", "test"]
    assert entries[-1].scene_id == "corpus-1020"


def test_build_keeps_what_is_whole_and_makes_again_what_is_not(corpus, capsys):
    before = contents(corpus)
    (corpus / "scenes" / "corpus-0001.json.gz").write_bytes(b"cut")
    (corpus / "scenes" / ".corpus-0002.json.gz.abc").write_bytes(b"half")
    status, out, err = run(capsys, "build", "--out", corpus, "--scenes", SCENES, "--json")
    assert (status, err) == (0, "")
    assert (json.loads(out)["made"], json.loads(out)["kept"]) == (1, 2)
    assert contents(corpus) == before


def test_scenes_of_other_sources_are_made_again_and_said_so(corpus, capsys):
    before = contents(corpus)
    path = corpus / MANIFEST
    path.write_text(re.sub('"sources":"[0-9a-f]+"', '"sources":"0"', path.read_text()))
    status, _, err = run(capsys, "build", "--out", corpus, "--scenes", "1", "--jobs", 1)
    assert status == 0
    again, stay = err.strip().splitlines()
    assert "1 scenes" in again
    assert "other sources: they are made again" in again
    assert "2 scenes" in stay
    assert "they stay" in stay
    assert contents(corpus)["corpus-0001.json.gz"] == before["corpus-0001.json.gz"]
    assert [e.sources == "0" for e in open_dataset(corpus).entries] == [True, False, True]
    status, _, err = run(capsys, "stats", corpus, "--jobs", 1)
    assert status == 0
    assert err.startswith("aeroscene dataset: 2 of 3 scenes in ")
    assert err.splitlines()[1:] == part(corpus).splitlines()


def wait_for_a_scene(process, folder):
    while not any((folder / "scenes").glob("corpus-*")):
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)


def test_ctrl_c_ends_a_build_quietly_and_the_rest_is_made_later(tmp_path, capsys):
    folder = tmp_path / "corpus"
    process = start("build", "--out", folder, "--scenes", "0:60", "--jobs", 2)
    wait_for_a_scene(process, folder)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: the workers too
    out, err = process.communicate()
    assert process.returncode == 130
    assert out == ""
    assert err == "aeroscene dataset build: stopped; the same command goes on from here\n"
    names = {path.name for path in folder.rglob("*")}
    assert not {name for name in names if name.startswith(".") or name == JOURNAL}
    entries = read_entries(folder)
    assert len(entries) < 60
    if entries:
        listed = ",".join(str(entry.index) for entry in entries)
        _, out, _ = run(capsys, "build", "--out", folder, "--scenes", listed, "--json")
        assert (json.loads(out)["made"], json.loads(out)["kept"]) == (0, len(entries))


def test_a_build_that_was_killed_goes_on(built, tmp_path, capsys):
    folder = tmp_path / "corpus"
    process = start("build", "--out", folder, "--scenes", SCENES, "--jobs", 1)
    wait_for_a_scene(process, folder)
    process.kill()
    process.communicate()
    assert not (folder / MANIFEST).exists()
    status, _, err = run(capsys, "build", "--out", folder, "--scenes", "0:2", "--jobs", 1)
    assert (status, err) == (0, "")
    wanted = contents(built[0])
    assert all(wanted[path.name] == path.read_bytes() for path in folder.rglob("*.gz"))
    assert not {path.name for path in folder.rglob("*")} - {"scenes", *wanted}


def test_two_builds_in_one_folder_do_not_mix(corpus, capsys):
    import fcntl

    with (corpus / JOURNAL).open("ab") as journal:
        fcntl.flock(journal, fcntl.LOCK_EX)
        status, _, err = run(capsys, "build", "--out", corpus, "--scenes", SCENES)
    assert status == 2
    assert "being built by another process" in err


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["build", "--scenes", "5:2"], "scenes '5:2' is no range of scenes; valid: A:B"),
        (["build", "--scenes", "0:1000001"], "from 0 to 999999"),
        (["build", "--scenes", "one"], "scenes 'one'"),
        (["build", "--jobs", "0"], "jobs 0 is out of range; valid: 1 to 512"),
        (["build", "--jobs", "many"], "jobs 'many' is not valid; valid: a whole number"),
        (["build", "--out", "{file}"], "{file}"),
        (["stats", "{absent}"], "'{absent}' holds no dataset"),
        (["stats", "{file}"], "folder '{file}' is a file"),
        (["stats", "{corpus}", "--scenes", "2:5"], "scene 3 is not in '{corpus}'"),
        (["stats", "{corpus}", "--beside", "{absent}"], "{absent}"),
        (
            ["validate", "{corpus}", "--drops", "-1"],
            "drops -1 is out of range; valid: 0 to 1000000",
        ),
        (["validate", "{absent}"], "valid: a folder that aeroscene dataset build has made"),
        (["show", "{corpus}", "--out", "sheet.gif"], "out 'sheet.gif' is no .png file"),
        (["show", "{corpus}", "--columns", "0"], "columns 0 is out of range; valid: 1 to 50"),
        (
            ["show", "{corpus}", "--viewer", "vr"],
            "viewer 'vr' is not valid; valid: ",
        ),
        (["frobnicate"], "frobnicate"),
    ],
)
def test_bad_input_ends_with_status_2_and_one_line(built, tmp_path, capsys, args, says):
    (tmp_path / "file").write_text("x")
    places = {"corpus": built[0], "file": tmp_path / "file", "absent": tmp_path / "absent"}
    status, out, err = run(capsys, *(arg.format(**places) for arg in args))
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert line.startswith("aeroscene")
    assert says.format(**places) in line


def test_stats_prints_the_papers_table_as_one_object(built, tmp_path, capsys):
    beside = tmp_path / "blocks.jsonl"
    layout = {
        "scene_id": "a",
        "source": "test",
        "domain": "outdoor",
        "floor": [[0, 0], [9, 0], [9, 9], [0, 9]],
        "objects": [
            {"category": c, "p": [x, 2, 1], "q": [1, 0, 0, 0], "s": [1, 1, 2], "parent": None}
            for c, x in (("building", 1), ("kiosk", 5))
        ],
        "attributes": {},
    }
    beside.write_text("".join(json.dumps(layout | {"scene_id": name}) + "\n" for name in "ab"))
    status, out, err = run(capsys, "stats", built[0], "--jobs", 1, "--json", "--beside", beside)
    assert (status, err) == (0, part(built[0]))
    found = json.loads(out)
    rows = {
        "scenes": 1016,
        "objects": 160010,
        "objects_per_scene": 149,
        "coarse_per_scene": 34,
        "fine_per_scene": 112,
        "landing_areas_per_scene": 54,
        "small_areas_per_scene": 42,
        "medium_areas_per_scene": 12,
        "large_areas_per_scene": 5,
        "coarse_categories": 23,
        "fine_categories": 47,
    }
    assert {key: found[key]["paper"] for key in rows} == rows
    entries = open_dataset(built[0]).entries
    assert found["objects"]["value"] == sum(e.n_objects for e in entries)
    assert found["objects"]["test"] == {"value": entries[0].n_objects, "paper": 37654}
    assert found["domains"]["indoor"] == {"scenes": 1, "share": 0.3333}
    assert len(found["categories"]) == 70
    counted = sum(category["objects"] for category in found["categories"].values())
    assert counted == found["objects"]["value"]
    n_found = sum(category["scenes"] > 0 for category in found["categories"].values())
    assert n_found + len(found["missing_categories"]) == 70
    ours, theirs = found["diversity"]
    assert ours["name"] == "corpus"
    assert ours["entropy_bits"] > 4
    assert 0 < ours["nearest_least"] <= ours["nearest_mean"]
    assert (theirs["name"], theirs["n_layouts"], theirs["entropy_bits"]) == ("blocks", 2, 1.0)
    assert theirs["nearest_mean"] == 0.0
    assert len(found["paper_inconsistencies"]) >= 2


def test_stats_says_both_and_that_the_paper_disagrees_with_itself(built, capsys):
    status, out, _ = run(capsys, "stats", built[0], "--jobs", 1)
    assert status == 0
    assert re.search(r"Objects / scene .* 152 .* 149", out)
    assert "157 a scene, not 149" in out
    assert "add up to 59, not 54" in out


def test_validate_finds_nothing_in_a_good_corpus_and_drops_rest(built, capsys):
    args = ("validate", built[0], "--jobs", 1, "--drops", 12, "--json")
    status, out, err = run(capsys, *args)
    found = json.loads(out)
    assert (status, err) == (0, part(built[0])), found["details"]
    assert found["scenes"] == 3
    assert found["findings"] == dict.fromkeys(
        ("overlap", "floating", "outside", "unreachable", "unlandable"), 0
    )
    assert found["drops"]["count"] == 12
    assert found["drops"]["share"] == 1.0


def break_scene(corpus, index, change):
    """Put a changed scene in the corpus, listed as if it belonged there."""
    opened = open_dataset(corpus)
    scene = change(opened.read(opened.select({index}).entries[0]))
    entry = store_scene(corpus, scene)
    write_manifest(corpus, [*(e for e in opened.entries if e.index != index), entry])
    return scene


def raise_a_tree(scene):
    tree = next(obj for obj in scene.objects if obj.category in {"tree", "bush", "planter"})
    x, y, z = tree.bbox.p
    up = replace(tree, bbox=replace(tree.bbox, p=(x, y, z + 3.0)))
    kept = tuple(up if obj.id == tree.id else obj for obj in scene.objects)
    return replace(scene, objects=kept, interaction_areas=())


def test_validate_names_what_floats_and_ends_with_status_1(corpus, capsys):
    break_scene(corpus, 1, raise_a_tree)
    status, out, err = run(capsys, "validate", corpus, "--scenes", "1")
    assert (status, err) == (1, "")
    assert re.search(r"floating +│ +1 │ +1 ", out)
    assert re.search(r"floating: corpus-0001, object \d+: ", out)


def lift_areas(scene):
    areas = tuple(
        replace(
            area,
            centroid=(*area.centroid[:2], area.centroid[2] + 0.5),
            polygon=tuple((x, y, z + 0.5) for x, y, z in area.polygon),
        )
        for area in scene.interaction_areas
    )
    return replace(scene, interaction_areas=areas)


def test_drops_on_areas_in_the_air_fail(corpus, capsys):
    break_scene(corpus, 1, lift_areas)
    args = ("validate", corpus, "--scenes", "1", "--drops", 4)
    status, out, _ = run(capsys, *args)
    assert status == 1
    assert "Drops: 0 of 4 came to rest on their areas, 0.0%" in out
    assert re.search(r"drop: corpus-0001, .*: rests -0\.50 m from the area's plane", out)


def test_an_unreadable_file_is_named_and_can_be_skipped(corpus, capsys):
    path = corpus / "scenes" / "corpus-0001.json.gz"
    path.write_bytes(path.read_bytes()[:3000])
    status, out, err = run(capsys, "validate", corpus, "--jobs", 1)
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert str(path) in line
    assert run(capsys, "stats", corpus, "--jobs", 1)[0] == 2
    status, out, _ = run(capsys, "validate", corpus, "--jobs", 1, "--skip-invalid", "--json")
    found = json.loads(out)
    assert status == 0, found["details"]
    assert found["scenes"] == 2
    (invalid,) = found["invalid"]
    assert "corpus-0001.json.gz" in invalid


def test_show_draws_every_scene_of_any_folder_on_one_sheet(built, loose, tmp_path, capsys):
    sheet, other = tmp_path / "sheet.png", tmp_path / "other.png"
    size = ("--columns", 1, "--width", 160, "--jobs", 1)
    for folder, path, which in ((built[0], sheet, ("--scenes", "1:3")), (loose, other, ())):
        status, out, err = run(capsys, "show", folder, "--out", path, *which, *size)
        assert (status, err) == (0, "")
        assert out == f"{path}: 2 scenes\n"
    picture = cv2.imread(str(sheet)).astype(int)
    margin, height, caption = 10, 120, 46
    assert picture.shape[1] == 160 + 2 * margin
    step = height + caption + margin
    first, second = (picture[margin + n * step :][:height, margin:-margin] for n in (0, 1))
    assert first.std() > 20
    assert second.std() > 20
    assert np.abs(first - second).mean() > 5
    assert np.ptp(picture[margin + height :][:caption]) > 100  # something is written below
    # Files of a folder without a manifest are drawn in the order of their names.
    swapped = cv2.imread(str(other)).astype(int)
    assert np.array_equal(swapped[margin:][:height, margin:-margin], second)
    assert np.array_equal(swapped[margin + step :][:height, margin:-margin], first)


def test_a_folder_with_files_missing_says_how_many(corpus, capsys):
    (corpus / "scenes" / "corpus-0001.json.gz").unlink()
    args = ("validate", corpus, "--jobs", 1, "--skip-invalid", "--json")
    status, out, err = run(capsys, *args)
    assert (status, json.loads(out)["scenes"]) == (0, 2)
    assert "holds 2 of the 1,016 scenes (1 that its manifest lists are missing); " in err


def test_a_build_that_was_stopped_is_named(corpus, capsys):
    (corpus / JOURNAL).write_bytes(b"")
    _, _, err = run(capsys, "stats", corpus, "--jobs", 1)
    assert "holds 3 of the 1,016 scenes (its build is under way, or was stopped); " in err


@pytest.fixture
def loose(built, tmp_path):
    """Scenes 2 and 1 in a folder without a manifest, one of them packed."""
    folder = tmp_path / "loose"
    folder.mkdir()
    opened = open_dataset(built[0])
    write_scene(opened.read(opened.entries[2]), folder / "a.json")
    write_scene(opened.read(opened.entries[1]), folder / "b.json.gz")
    (folder / "notes.txt").write_text("no scene")
    return folder


def test_stats_and_validate_take_any_folder_of_scenes(loose, built, capsys):
    status, out, err = run(capsys, "stats", loose, "--jobs", 1, "--json")
    assert (status, err) == (0, "")
    entries = open_dataset(built[0]).entries
    assert json.loads(out)["objects"]["value"] == entries[1].n_objects + entries[2].n_objects
    status, out, err = run(capsys, "validate", loose, "--jobs", 1, "--scenes", "1", "--json")
    assert (status, err, json.loads(out)["scenes"]) == (0, "", 1)


def test_a_file_that_is_no_scene_is_named(loose, capsys):
    (loose / "c.json").write_text("{}")
    status, out, err = run(capsys, "show", loose)
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert str(loose / "c.json") in line


def test_show_opens_a_scene_in_the_viewer(built):
    process = start("show", built[0], "--scenes", "2", "--viewer", "web")
    line = process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate()
    assert process.returncode == 0, err
    assert line.startswith("corpus-0002 is shown at http://127.0.0.1:")
