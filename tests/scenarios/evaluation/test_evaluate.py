"""`aeroscene evaluate` as a user meets it: tables, resuming, and what it refuses."""

import contextlib
import io
import json
from dataclasses import replace

import numpy as np
import pytest
import torch
from msgspec import structs

from aeroscene.corpus.dataset import store_scene, write_manifest
from aeroscene.landform import level
from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.learning.baselines.presets import without
from aeroscene.learning.generation import loading
from aeroscene.learning.generation.denoising import Denoising
from aeroscene.learning.generation.loading import DEFAULT_SAMPLER
from aeroscene.learning.program import DecodingCfg
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.training.presets import preset_sections, read_sections
from aeroscene.learning.training.settings import changed, section_with
from aeroscene.learning.writer.language import Language
from aeroscene.metrics.appearance.frechet import LEAST_PICTURES
from aeroscene.scene.io import read_scene
from scenarios.cli.main import main
from scenarios.evaluation.choices import SAMPLED, TRAINED
from scenarios.evaluation.renders import PIXELS, Camera
from tests.aeroscene.conftest import cached_scene, renamed
from tests.aeroscene.layouts.samples import house
from tests.aeroscene.learning.training.conftest import ten_objects
from tests.thorough import THOROUGH

pytestmark = pytest.mark.timeout(600)
"""Pictures of forty scenes: fifteen seconds of a core, which others may want too."""

NUMBERS = (7, 42, 45, 49)
N_EACH = LEAST_PICTURES


@pytest.fixture(autouse=True)
def as_before():
    """The command sets torch's threads for its process, which is this one here."""
    threads = torch.get_num_threads()
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """Eight small scenes of each split, in turn."""
    folder = tmp_path_factory.mktemp("corpus")
    (folder / "scenes").mkdir()
    entries = []
    for number in range(2 * N_EACH):
        scene = ten_objects(cached_scene(NUMBERS[number // 2 % len(NUMBERS)]))
        named = renamed(scene, f"corpus-{number:04d}")
        entry = store_scene(folder, named, number)
        entries.append(structs.replace(entry, split="train" if number % 2 else "test"))
    write_manifest(folder, entries)
    return folder


def evaluate(corpus, out, *args):
    """Run the command; what it prints as JSON."""
    sizes = "--steps 1 --width 16 --levels 1 --denoising-steps 2"
    asked = f"--path {corpus} --out {out} --scenes {N_EACH} {sizes} --json"
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        assert main(["evaluate", *asked.split(), *args]) == 0
    return json.loads(said.getvalue())


METHODS = ("--methods", "ground_truth", "diffuscene")


@pytest.fixture(scope="module")
def made(corpus, tmp_path_factory):
    """A table of real scenes, and those of a method that has hardly learned."""
    out = tmp_path_factory.mktemp("evaluation")
    return out, evaluate(corpus, out, *METHODS)


def by_cell(table):
    return {(row["method"], row["metric"]): row for row in table["rows"]}


def test_the_table_has_rows_with_intervals_and_real_scenes_are_best(made):
    out, table = made
    cells = by_cell(table)
    for row in table["rows"]:
        assert set(row) == {"method", "metric", "value", "interval_95", "n"}
        if row["value"] is not None and row["interval_95"] is not None:
            low, high = row["interval_95"]
            assert low - 1e-3 <= row["value"] <= high + 1e-3
    for metric in ("FD-EffNetL0", "KID-EffNetL0", "SP", "OP"):
        assert cells["diffuscene", metric]["value"] > cells["ground_truth", metric]["value"]
    assert cells["ground_truth", "CR"]["n"] == N_EACH
    assert cells["diffuscene", "failed"]["value"] == 0
    names = {path.rsplit("/", 1)[1] for path in table["files"]}
    assert names == {"synthesis.json", "synthesis.md", "synthesis.png", "synthesis-scenes.png"}
    assert all((out / name).stat().st_size > 100 for name in names)
    assert json.loads((out / "synthesis.json").read_text())["rows"][0]["method"] == "ground_truth"


def test_a_trained_method_is_in_the_table_with_its_budget(made):
    out, table = made
    cells = by_cell(table)
    assert cells["diffuscene", "training_steps"]["value"] == 1
    # After a single step everything is still to come.
    assert cells["diffuscene", "training_best_at"]["value"] == 100
    assert table["leads"] == {}
    assert cells["diffuscene", "training_tflop"]["value"] > 0
    assert (out / "methods" / "diffuscene" / "training" / "log.jsonl").exists()


def test_what_is_done_is_not_done_again_and_what_is_missing_is(corpus, made):
    out, table = made
    scenes = out / "methods" / "diffuscene" / "scenes"
    kept = {path.name: path.stat().st_mtime_ns for path in scenes.iterdir()}
    lost = read_scene(scenes / "0003.sampled.json.gz")
    for path in scenes.glob("0003*"):
        path.unlink()
    again = evaluate(corpus, out, *METHODS)
    assert read_scene(scenes / "0003.sampled.json.gz") == lost
    after = {path.name: path.stat().st_mtime_ns for path in scenes.iterdir()}
    changed = {name for name, time in after.items() if kept.get(name) != time}
    assert changed
    assert all(name.startswith("0003") for name in changed)

    def quality(rows):
        return [row for row in rows if row["metric"] not in {"sample_cpu_s", "sample_mb"}]

    assert quality(again["rows"]) == quality(table["rows"])


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--scenes", "7"), "scenes 7 is out of range; valid: 8 to 1000000"),
        (("--methods", "gan"), "'gan' is no row of table synthesis; valid: ground_truth, random"),
        (("--data", "front3d", "--path", "no.jsonl.gz"), "no.jsonl.gz"),
        (("--demo", "9"), "demo is 9; valid: 0 to --scenes"),
        (("--width", "17"), "width is 17; valid: a multiple of 16"),
        (("--cpu-minutes", "0"), "cpu-minutes 0.0 is out of range; valid: above 0 minutes"),
        (("--inception", "none.pt"), "valid: inception-2015-12-05.pt"),
        (("--seed", "1"), "holds a table of other data, seed, budget or sizes"),
    ],
)
def test_bad_input_is_refused_in_one_line(capsys, corpus, made, args, says):
    with pytest.raises(SystemExit) as stop:
        evaluate(corpus, made[0], *METHODS, *args)
    assert stop.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line


def test_layouts_without_a_file_are_refused(capsys, tmp_path):
    with pytest.raises(SystemExit) as stop:
        main(["evaluate", "--data", "front3d", "--out", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert "data front3d has no path; valid: --path FILE" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_too_few_scenes_of_a_split_are_refused_with_the_number_that_would_do(capsys, tmp_path):
    folder = tmp_path / "corpus"
    (folder / "scenes").mkdir(parents=True)
    scene = renamed(ten_objects(cached_scene(7)), "corpus-0001")
    write_manifest(folder, [store_scene(folder, scene, 1)])
    with pytest.raises(SystemExit):
        main(["evaluate", "--path", str(folder), "--out", str(tmp_path / "out")])
    assert "has 1 scenes of the train split; valid: 8 or more" in capsys.readouterr().err


def test_pictures_are_the_same_every_time_and_show_what_changes():
    scene = ten_objects(cached_scene(42))
    camera = Camera.from_scenes([scene])
    first = camera.pictures(scene)
    assert [picture.shape for picture in first] == [(PIXELS, PIXELS, 3)] * 2
    for one, other in zip(first, camera.pictures(scene), strict=True):
        assert (one == other).all()
    moved = replace(
        scene,
        objects=tuple(
            replace(obj, bbox=replace(obj.bbox, p=(obj.bbox.p[0] + 2.0, *obj.bbox.p[1:])))
            for obj in scene.objects
        ),
        interaction_areas=(),
    )
    assert all(
        np.abs(one.astype(int) - other).mean() > 0.5
        for one, other in zip(first, camera.pictures(moved), strict=True)
    )


def test_the_land_of_a_site_is_in_no_picture():
    raised = cached_scene(31)
    assert raised.relief is not None
    camera = Camera.from_scenes([raised])
    pairs = zip(camera.pictures(raised), camera.pictures(level(raised)), strict=True)
    assert all((one == other).all() for one, other in pairs)


def test_a_larger_scene_looks_larger():
    scene = ten_objects(cached_scene(42))
    camera = Camera.from_scenes([scene])
    wide = Camera({domain: 2 * reach_m for domain, reach_m in camera.reach_m.items()})
    near, far = camera.pictures(scene)[0], wide.pictures(scene)[0]
    corner = PIXELS // 4
    middle = far[corner:-corner, corner:-corner].astype(float)
    halved = near.astype(float).reshape(PIXELS // 2, 2, PIXELS // 2, 2, 3).mean(axis=(1, 3))
    assert np.abs(middle - halved).mean() < 12


def test_rooms_fill_the_picture_and_not_the_yard_about_them():
    scene, _ = make_flyable(neutral_layout(house()))
    (reach_m,) = Camera.from_scenes([scene]).reach_m.values()
    # Half of the ten metres of the two rooms; the yard reaches six farther.
    assert reach_m == pytest.approx(5.0)
    assert scene.extent_max_enu_m[0] > 10.0


@pytest.mark.parametrize(
    ("table", "name", "n_blocks", "has_relations"),
    [
        ("ablation", "ours_without_relations", 4, False),
        # Every choice is a change of what ships, which a test below proves without training.
        pytest.param("choices", "ours_blocks_2", 2, True, marks=THOROUGH),
    ],
)
def test_ours_is_trained_on_programs_that_say_less_and_otherwise(
    corpus, tmp_path, table, name, n_blocks, has_relations
):
    cells = by_cell(evaluate(corpus, tmp_path, "--table", table, "--methods", name))
    # One of each part.
    assert cells[name, "training_steps"]["value"] == 2
    path = tmp_path / "methods" / name / "training" / "checkpoint.safetensors"
    assert read_sections(path)["model"].blocks == n_blocks
    language = read_checkpoint(path).known
    assert isinstance(language, Language)
    encoding = language.encoding
    assert (encoding.has_partitions, encoding.has_relations) == (True, has_relations)


def test_every_choice_is_a_change_of_what_ships():
    default = preset_sections("default")
    for name, (_, changes) in TRAINED.items():
        assert changed(default, changes) != default, name
    for name, (_, fields) in SAMPLED.items():
        assert section_with(DEFAULT_SAMPLER, fields, "sampler") != DEFAULT_SAMPLER, name


def test_a_choice_of_sampling_takes_the_weights_that_ship(monkeypatch):
    samplers = []
    monkeypatch.setattr(
        loading, "Denoising", lambda *args: samplers.append(args[3]) or Denoising(*args)
    )
    without(None, "default", {"sampler": SAMPLED["ddim_5"][1]}, DecodingCfg(), None)
    assert [(each.kind, each.n_steps) for each in samplers] == [("ddim", 5)]


def test_layouts_with_unknown_things_are_refused_by_scene_and_object(capsys, tmp_path):
    box = {"p": [0.5, 0.5, 0.5], "q": [1.0, 0.0, 0.0, 0.0], "s": [1.0, 1.0, 1.0], "parent": None}
    layout = {
        "scene_id": "odd",
        "source": "test",
        "domain": "indoor",
        "floor": [[2, 2], [-2, 2], [-2, -2], [2, -2]],
        "objects": [{"category": "Zeppelin", **box}],
        "attributes": {},
    }
    path = tmp_path / "rooms.jsonl"
    path.write_text(json.dumps(layout) + "\n")
    with pytest.raises(SystemExit) as stop:
        main(["evaluate", "--data", "front3d", "--path", str(path), "--out", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert "scene 'odd': object 0: category is 'Zeppelin'; valid: " in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
