import re
from pathlib import Path

import pytest

from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.presets import (
    preset_sections,
    sections_from_plain,
    sections_to_plain,
)
from aeroscene.learning.training.settings import read_settings

SECTIONS = preset_sections("default")


def settings(tmp_path, text):
    path = tmp_path / "model.toml"
    path.write_text(text)
    return read_settings(path, SECTIONS)


@pytest.mark.parametrize("preset", ["default", "paper", "progressive"])
def test_presets_come_back_from_a_checkpoints_plain_form(preset):
    sections = preset_sections(preset)
    assert sections_from_plain(sections_to_plain(sections)) == sections


def test_paper_preset_is_the_papers():
    sections = preset_sections("paper")
    training, loss, model = sections["training"], sections["loss"], sections["model"]
    assert (training.optimiser, training.learning_rate, training.batch_size) == ("adam", 1e-3, 64)
    assert (training.schedule, loss.parameterisation) == ("cosine", "eps")
    assert (model.denoiser, model.routing) == ("unet", "learned")
    assert (model.coarse_branch, model.fine_branch) == ("cnn", "radius_gnn")


def test_file_changes_what_it_names_and_nothing_else(tmp_path):
    changed = settings(tmp_path, "[training]\nbatch_size = 8\n[model]\nwidth = 64\n")
    assert changed["training"].batch_size == 8
    assert changed["training"].learning_rate == SECTIONS["training"].learning_rate
    assert changed["model"].width == 64
    assert changed["loss"] == SECTIONS["loss"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[trainign]\nsteps = 1", r"section \[trainign\] is unknown; valid: model, schedule"),
        ("[training]\nbatches = 1", r"training.batches is unknown; valid: batch_size"),
        ("[training]\nbatch_size = 0", "batch_size 0 is out of range; valid: 1 to 2147483647"),
        ("[training]\nbatch_size = 'many'", "batch_size: Expected `int`, got `str`"),
        (
            "[training]\nlearning_rate = nan",
            "learning_rate nan is out of range; valid: above 0, at most 1",
        ),
        (
            "[training]\nlearning_rate = 7",
            "learning_rate 7.0 is out of range; valid: above 0, at most 1",
        ),
        ("[training]\naverage_decay = 1.0", "average_decay is 1.0; valid: 0 to below 1"),
        ("[training]\noptimiser = 'sgd'", "optimiser: Invalid enum value 'sgd'"),
        ("[schedule]\nn_steps = 0", "n_steps 0 is out of range; valid: 2 to"),
        ("[model]\nwidth = -1", "width -1 is out of range; valid:"),
        ("[writer]\nlayers = 99", "layers 99 is out of range; valid: 1 to 16"),
        ("training = 3", r"training is 3; valid: a section \[training\]"),
        ("[training", "is no TOML"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, text, message):
    with pytest.raises(TrainingError, match=message) as caught:
        settings(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "model.toml" in str(caught.value)


def test_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(TrainingError, match=r"No such file or directory; valid: a file"):
        read_settings(tmp_path / "none.toml", SECTIONS)


def test_unknown_preset_is_refused():
    with pytest.raises(TrainingError, match="preset is 'fast'; valid: default, paper"):
        preset_sections("fast")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda plain: plain.pop("model"), r"section \[model\] is missing"),
        (lambda plain: plain.update(magic={}), r"section \[magic\] is unknown"),
        (lambda plain: plain["model"].update(width=3), "width"),
    ],
)
def test_configuration_of_a_checkpoint_is_checked(change, message):
    plain = sections_to_plain(SECTIONS)
    change(plain)
    with pytest.raises(TrainingError, match=message):
        sections_from_plain(plain)


def test_documented_example_is_read(tmp_path):
    page = Path(__file__).parents[4] / "docs" / "training.md"
    (example,) = re.findall(r"```toml\n(.*?)```", page.read_text(), re.DOTALL)
    changed = settings(tmp_path, example)
    assert changed["training"].precision == "mixed"
    assert changed["model"].blocks == 4
    assert changed["writer_training"].learning_rate == 1e-3
