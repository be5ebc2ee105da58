"""A model goes on in another language: what both have stays, what is new is as the nearest."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
import torch

from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.paper.contents.model import ContentsModel
from aeroscene.learning.training.carried import _nearest, carried, read_begun
from aeroscene.learning.training.checkpoint import read_checkpoint, write_checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointError
from aeroscene.learning.training.data import prepared
from aeroscene.learning.training.fitted import fitted
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.presets import preset_sections
from aeroscene.learning.training.procedure import CHECKPOINT, Training
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import new_writer
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.learning.training.conftest import Watcher, small_sections, ten_objects


@pytest.fixture(scope="module")
def other(small_scenes):
    """The same scenes and two more."""
    more = [ten_objects(cached_scene(index)) for index in (3, 8)]
    return prepared("other", [*small_scenes, *more], [])


@pytest.fixture
def checkpoint(plan):
    Training(plan, Watcher()).run()
    return plan.folder / CHECKPOINT


def test_weights_carried_to_their_own_language_are_the_same(data):
    language = data.train.known
    weights = new_writer(small_sections(data)["writer"], language).state_dict()
    found = carried("writer", weights, language.vocabulary, language.vocabulary)
    assert found.keys() == weights.keys()
    for name, value in weights.items():
        torch.testing.assert_close(found[name], value)


def test_kinds_of_both_languages_keep_their_vectors_and_new_ones_have_the_nearest(data, other):
    old, new = data.train.known.vocabulary, other.train.known.vocabulary
    torch.manual_seed(1)
    weights = new_writer(small_sections(data)["writer"], data.train.known).state_dict()
    own = carried("writer", weights, old, new)["embedding.own"]
    assert len(own) == len(new.kinds) + 1 > len(old.kinds) + 1
    for number, kind in enumerate(new.kinds):
        row = own[number]
        if kind in old.number:
            torch.testing.assert_close(row, weights["embedding.own"][old.number[kind]])
        elif (nearest := _nearest(old, kind)) >= 0:
            torch.testing.assert_close(row, weights["embedding.own"][nearest])


def test_kinds_that_one_stood_for_share_its_chance(data, other):
    old, new = data.train.known.vocabulary, other.train.known.vocabulary
    weights = new_writer(small_sections(data)["writer"], data.train.known).state_dict()
    bias = carried("writer", weights | {"bias": torch.zeros(len(old.kinds))}, old, new)["bias"]
    known = [(i, row) for i, kind in enumerate(new.kinds) if (row := _nearest(old, kind)) >= 0]
    assert len(known) > len(old.kinds)
    chance = np.zeros(len(old.kinds))
    for number, row in known:
        chance[row] += np.exp(float(bias[number]))
    assert chance[chance > 0] == pytest.approx(1.0, abs=1e-5)


def test_a_training_begun_with_a_model_begins_where_that_one_ended(plan, checkpoint, tmp_path):
    begun = read_begun(checkpoint).parts_for(plan.data.train.known, plan.sections)
    again = Training(replace(plan, folder=tmp_path / "again", begun=begun), Watcher())
    for part in ("writer", "denoiser"):
        weights = again._begun(part).model.state_dict()
        for name, value in begun[part].items():
            torch.testing.assert_close(weights[name], value)


def test_a_model_of_other_scenes_is_taken_by_networks_of_the_same_size(checkpoint, other, data):
    sections = fitted(small_sections(data), other.train.known)
    parts = read_begun(checkpoint).parts_for(other.train.known, sections)
    new_writer(sections["writer"], other.train.known).load_state_dict(dict(parts["writer"]))


def test_the_model_that_ships_is_begun_with_by_the_usual_networks(data):
    """Which of their activations a training leaves out is its own affair."""
    known = data.train.known
    sections = fitted(preset_sections("default"), known)
    parts = read_begun(SHIPPED["default"]).parts_for(known, sections)
    new_writer(sections["writer"], known).load_state_dict(dict(parts["writer"]))
    assert set(parts) == {"writer", "denoiser"}


@pytest.fixture
def earlier(checkpoint, data, tmp_path):
    """The same model as an earlier catalogue had it, with barrels in the place of one category."""
    known = data.train.known
    units = [kind.category for kind in known.vocabulary.kinds if kind.node == "unit"]
    name = max(set(units), key=units.count)
    found = read_checkpoint(checkpoint)
    text = known.to_json().replace(f'"{name}"', '"barrel"').replace(f'"{name} ', '"barrel ')
    facts = msgspec.structs.replace(
        found.facts,
        vocabulary=text,
        categories=tuple("barrel" if each == name else each for each in found.facts.categories),
    )
    path = tmp_path / "earlier.safetensors"
    old = Language.restored(text, known.to_arrays())
    write_checkpoint(path, facts, found.parts, old, is_half=False)
    return name, path


def test_a_model_of_an_earlier_catalogue_is_begun_with_but_neither_drawn_from_nor_kept(earlier):
    _, path = earlier
    for read in (read_checkpoint, lambda path: read_begun(path, any_catalogue=False)):
        with pytest.raises(
            CheckpointError, match=r"other categories \(it has 'barrel'\); valid: the 70"
        ):
            read(path)
    assert read_begun(path).path == path


def test_categories_of_an_earlier_catalogue_are_matched_by_name_and_others_begin_afresh(
    earlier, plan, checkpoint
):
    name, path = earlier
    known = plan.data.train.known
    parts = read_begun(path).parts_for(known, plan.sections)
    same = read_begun(checkpoint).parts_for(known, plan.sections)
    new_writer(plan.sections["writer"], known).load_state_dict(dict(parts["writer"]))
    n = len(known.vocabulary.kinds)
    for part in ("writer", "denoiser"):
        mean = same[part]["embedding.own"][:n].mean(0)
        for number, kind in enumerate(known.vocabulary.kinds):
            row = parts[part]["embedding.own"][number]
            if kind.node == "unit" and kind.category == name:
                torch.testing.assert_close(row, mean, atol=2e-3, rtol=0)
            elif kind.category != name:
                torch.testing.assert_close(row, same[part]["embedding.own"][number])


def test_networks_of_another_size_are_refused_in_a_line(data):
    with pytest.raises(CheckpointError, match=r"network of other sizes than \[\w+\]; valid: "):
        read_begun(SHIPPED["default"]).parts_for(data.train.known, small_sections(data))


def test_the_papers_model_is_refused_in_a_line(data):
    with pytest.raises(CheckpointError, match="is of preset 'paper'; valid: 'default'"):
        read_begun(SHIPPED["paper"]).parts_for(data.train.known, small_sections(data))
    with pytest.raises(CheckpointError, match="is of preset 'default'; valid: 'paper' or 'prog"):
        read_begun(SHIPPED["default"], "progressive")


@pytest.mark.parametrize(
    ("shipped", "preset"), [("paper", "progressive"), ("progressive", "paper")]
)
def test_the_papers_presets_begin_with_each_others_weights(shipped, preset):
    found = read_checkpoint(SHIPPED[shipped])
    sections = preset_sections(preset)
    begun = read_begun(SHIPPED[shipped], preset).parts_for(found.known, sections)
    assert set(begun) == {"contents", "denoiser"}
    denoiser = new_denoiser(sections["model"], found.known, Schedule(sections["schedule"]))
    before = {name: value.clone() for name, value in denoiser.state_dict().items()}
    denoiser.load_state_dict(dict(begun["denoiser"]))
    assert any(not torch.equal(v, before[name]) for name, v in denoiser.state_dict().items())
    ContentsModel(sections["contents"]).load_state_dict(dict(begun["contents"]))
    wider = {**sections, "model": replace(sections["model"], width=2 * sections["model"].width)}
    with pytest.raises(CheckpointError, match=r"other sizes than \[model\]"):
        read_begun(SHIPPED[shipped], preset).parts_for(found.known, wider)
