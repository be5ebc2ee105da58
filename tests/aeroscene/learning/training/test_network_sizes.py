"""Sizes of networks by their sections alone, against the networks that ship."""

from dataclasses import replace

import msgspec
import pytest
from safetensors.torch import load_file, safe_open, save_file

from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointError
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.network_sizes import least_numbers, require_trainable
from aeroscene.learning.training.presets import preset_sections, read_sections

SECTION = {"denoiser": "model", "writer": "writer", "contents": "contents", "prior": "prior"}


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_networks_that_ship_have_these_numbers_at_least_and_few_more(preset):
    checkpoint = read_checkpoint(SHIPPED[preset])
    sections = read_sections(SHIPPED[preset])
    for part, weights in checkpoint.parts.items():
        # The table of kinds is as large as the vocabulary.
        numbers = sum(v.numel() for k, v in weights.items() if not k.endswith("embedding.own"))
        assert numbers / 3 < least_numbers(part, sections[SECTION[part]]) < numbers


def test_checkpoint_that_describes_more_than_its_weights_is_refused_by_its_head(tmp_path):
    path = tmp_path / "c.safetensors"
    with safe_open(SHIPPED["default"], framework="pt") as file:
        facts = msgspec.json.decode(file.metadata()["aeroscene"])
    facts["configs"]["model"] |= {"width": 4096, "blocks": 64, "ffn_ratio": 16}
    text = msgspec.json.encode(facts).decode()
    save_file(load_file(SHIPPED["default"]), path, metadata={"aeroscene": text})
    with pytest.raises(CheckpointError, match=r"2,594,854 numbers of the denoiser; valid: 118,111"):
        read_sections(path)


def test_training_of_a_network_beyond_any_machine_is_refused():
    sections = preset_sections("default")
    require_trainable(sections)
    sections["model"] = replace(sections["model"], width=4096, blocks=64)
    with pytest.raises(TrainingError, match=r"\[model\] describes a network of 27,917,287,424"):
        require_trainable(sections)
