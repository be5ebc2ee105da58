"""The codec goes with a training and its checkpoint."""

from dataclasses import replace

import pytest

from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.tokens.codec import DEFAULT_CODEC, CodecCfg
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.data import prepared
from aeroscene.learning.training.presets import fitted, preset_sections
from aeroscene.learning.training.procedure import CHECKPOINT, Training
from tests.aeroscene.learning.training.conftest import Watcher


def test_checkpoint_says_what_its_channels_stand_for(plan, small_scenes):
    codec = CodecCfg(frame="scene", size="linear")
    model = replace(plan.sections["model"], has_borders=False)
    sections = {**plan.sections, "codec": codec, "model": model}
    data = prepared("small", small_scenes, [], codec=codec)
    plan = replace(plan, data=data, sections=sections, parts=("denoiser",))
    assert Training(plan, Watcher()).run()
    kept = read_checkpoint(plan.folder / CHECKPOINT).statistics
    assert kept.codec == codec
    assert kept.mean.tolist() == data.train.statistics.mean.tolist()


def test_checkpoint_that_names_no_codec_has_the_default():
    checkpoint = read_checkpoint(SHIPPED["default"])
    assert checkpoint.facts.configs.get("codec") in (None, vars(DEFAULT_CODEC))
    assert checkpoint.statistics.codec == DEFAULT_CODEC


def test_borders_of_another_codec_are_refused(data):
    sections = preset_sections("default") | {"codec": CodecCfg(yaw="angle")}
    with pytest.raises(TrainingError, match=r"has_borders is True beside another \[codec\]"):
        fitted(sections, data.vocabulary)
