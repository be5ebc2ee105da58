"""The ablation at work on a small corpus and a small network, and what it refuses."""

import json
from dataclasses import replace
from functools import partial

import ablate
import msgspec
import pytest
from ablation.measure import Model, SceneOutcome, measure
from ablation.rows import SAMPLED, TRAINED, TrainedRow
from ablation.store import Outcome, outcome_key, read_outcome, write_outcome
from ablation.table import line, markdown_table, plain
from ablation.train import Trainer

from aeroscene.corpus.dataset import open_dataset, store_scene, write_manifest
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.presets import preset_sections
from aeroscene.learning.training.settings import changed
from tests.aeroscene.conftest import cached_scene, renamed

SMALL = {"width": 16, "blocks": 2, "heads": 2}
ROW = TrainedRow(
    name="small",
    what="a small network",
    changes={
        "model": SMALL,
        "training": {"batch_size": 2, "warmup_steps": 1},
    },
)

pytestmark = pytest.mark.usefixtures("one_torch_thread")


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """Two scenes to train on and one of the test split."""
    folder = tmp_path_factory.mktemp("data") / "corpus"
    (folder / "scenes").mkdir(parents=True)
    # One whose kinds the others have.
    test = renamed(replace(cached_scene(42), seed=45), "corpus-0045")
    scenes = (cached_scene(7), cached_scene(42), test)
    write_manifest(folder, [store_scene(folder, scene) for scene in scenes])
    return folder


@pytest.fixture(scope="module")
def trainer(corpus, tmp_path_factory):
    out = tmp_path_factory.mktemp("rows")
    return Trainer(data=corpus, out=out, steps=3, precision="single")


@pytest.fixture(scope="module")
def checkpoint(trainer):
    return trainer.train(ROW)


def outcome(*n_valid, moved_m=1.0):
    scenes = [
        SceneOutcome(
            n_objects=100,
            n_free=n,
            n_supported=100,
            n_valid=n,
            moved_m=moved_m,
            n_dropped=1,
            cpu_s=0.5,
        )
        for n in n_valid
    ]
    return Outcome(key="", scenes=scenes)


def test_every_row_differs_from_the_default_and_is_held_against_another():
    names = [row.name for row in (*TRAINED, *SAMPLED)]
    assert len(set(names)) == len(names)
    default = preset_sections("default")
    for row in TRAINED[1:]:
        sections = changed(default, row.changes)
        assert any(sections[name] != default[name] for name in default), row.name
    assert {row.against for row in (*TRAINED, *SAMPLED)} == {"default", "shipped"}


def test_trained_row_is_found_again_and_another_is_refused(trainer, checkpoint):
    found = trainer.found(ROW)
    assert found is not None
    assert found.facts.digest == checkpoint.facts.digest
    assert trainer.found(replace(ROW, name="absent")) is None
    assert replace(trainer, steps=4).found(ROW) is None
    other = replace(ROW, changes={"model": SMALL})
    with pytest.raises(TrainingError, match=r"holds another training \(\[training\] differs\)"):
        trainer.found(other)


def test_rows_are_measured_on_the_same_noise(corpus, checkpoint):
    model = Model.of(checkpoint)
    cases = model.cases(open_dataset(corpus), 2)
    assert [case.number for case in cases] == [45]
    seen = []
    denoising = model.denoising(n_steps=2)
    first, again, other = (
        measure(denoising, cases, noise, partial(seen.append, noise)) for noise in (0, 0, 1)
    )
    without_time = [msgspec.structs.replace(each[0], cpu_s=0.0) for each in (first, again, other)]
    assert without_time[0] == without_time[1] != without_time[2]
    assert seen == [0, 0, 1]
    assert first[0].n_objects > 100
    assert model.step_cpu_s(cases) > 0


def test_gain_is_paired_over_the_scenes():
    row = next(row for row in SAMPLED if row.name == "ddim_20")
    found = line(row, outcome(50, 70), outcome(60, 84))
    assert found.figures["gain"] == pytest.approx(-12.0)
    assert found.figures["gain_noise"] == pytest.approx(2.0)
    assert found.figures["dropped"] == pytest.approx(1.0)
    base = line(replace(row, name="shipped"), outcome(60, 84), None)
    assert "gain" not in base.figures
    text = markdown_table([base, found])
    assert "| `ddim_20` | DDIM, 20 steps | 60.0 | -12.0 ± 2.0 | 60.0 | 100.0 | 1.00 |" in text
    assert plain([found])[0]["gain"] == pytest.approx(-12.0)


def test_what_was_measured_of_something_else_is_measured_again(tmp_path):
    key = outcome_key("weights", [], "settings")
    write_outcome(tmp_path / "a" / "row.json", Outcome(key=key, step_cpu_s=0.25))
    assert read_outcome(tmp_path / "a" / "row.json", key) == Outcome(key=key, step_cpu_s=0.25)
    assert read_outcome(tmp_path / "a" / "row.json", outcome_key("others", [], "settings")) is None
    assert read_outcome(tmp_path / "none.json", key) is None


def test_rows_are_written_down(corpus, tmp_path, capsys):
    cfg = ablate.AblateCfg(
        data=corpus, out=tmp_path, scenes=2, rows=("ddim_50", "no_fourier"), train=False, json=True
    )
    ablate.main(cfg)
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "ablation.json").read_text())
    trained, sampled = printed.values()
    assert trained == []
    assert [row["row"] for row in sampled] == ["shipped", "ddim_50"]
    assert min(row["scene_cpu_s"] for row in sampled) > 0
    assert (tmp_path / "ablation.md").read_text().count("\n|") == 4


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"rows": ("ddim_7",)}, r"rows is 'ddim_7', valid: default, "),
        ({"scenes": 1}, r"scenes is 1, valid: 2 or more"),
        ({"steps": 0}, r"steps is 0, valid: 1 or more"),
    ],
)
def test_bad_input_is_refused_before_anything_is_read(fields, message, tmp_path):
    with pytest.raises(TrainingError, match=message):
        ablate.main(ablate.AblateCfg(data=tmp_path, out=tmp_path / "out", **fields))
