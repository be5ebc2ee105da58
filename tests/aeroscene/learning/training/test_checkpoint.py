import re
import shutil

import msgspec
import numpy as np
import pytest
import torch
from safetensors.torch import load_file, safe_open, save_file
from torch import nn

from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.training.checkpoint import read_checkpoint, write_checkpoint
from aeroscene.learning.training.checkpoint_facts import (
    CheckpointError,
    CheckpointFacts,
    DataSource,
    category_names,
)
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.language import Language


@pytest.fixture
def network():
    torch.manual_seed(0)
    return nn.Sequential(nn.Linear(3, 5), nn.BatchNorm1d(5))


@pytest.fixture
def facts(data):
    return CheckpointFacts(
        preset="default",
        configs={"model": {"width": 128}},
        vocabulary=data.train.kinds_json,
        categories=category_names(),
        data=DataSource(
            name="corpus",
            digest="0123",
            n_scenes=812,
            wishes=(Wish("outdoor", 30, 90, 50, "park"),),
        ),
        code="0.1.0+abc",
        training={"steps": 7},
    )


@pytest.fixture
def path(facts, network, data, tmp_path):
    path = tmp_path / "model.safetensors"
    write_checkpoint(path, facts, {"denoiser": network.state_dict()}, data.train.known)
    return path


def with_facts(path, **changes):
    """Rewrite what a checkpoint says of itself, its weights untouched."""
    with safe_open(path, framework="pt") as file:
        head = msgspec.json.decode(file.metadata()["aeroscene"])
    text = msgspec.json.encode(head | changes).decode()
    save_file(load_file(path), path, metadata={"aeroscene": text})


def refusal(path):
    with pytest.raises(CheckpointError) as caught:
        read_checkpoint(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    return message


def test_everything_comes_back_weights_to_half_precision(path, network, facts, data):
    checkpoint = read_checkpoint(path)
    assert msgspec.structs.replace(checkpoint.facts, digest="") == facts
    for name, value in network.state_dict().items():
        kept = checkpoint.parts["denoiser"][name]
        assert kept.dtype == value.dtype
        torch.testing.assert_close(kept, value, rtol=1e-3, atol=1e-4)
    mine, kept = data.train.known, checkpoint.known
    assert isinstance(kept, Language)
    assert kept.vocabulary == mine.vocabulary
    for kind in mine.vocabulary.kinds:
        assert kept.statistics.references.of(kind) == mine.statistics.references.of(kind)
    for name in ("mean", "spread", "low", "high", "is_free", "has"):
        own, other = getattr(mine.statistics, name), getattr(kept.statistics, name)
        np.testing.assert_allclose(other, own, rtol=1e-6)
    for name in ("class_of", "most", "always", "bears_fine", "most_children"):
        np.testing.assert_array_equal(getattr(kept.syntax, name), getattr(mine.syntax, name))


def test_single_precision_is_kept_exactly_where_asked_for(path, facts, network, data):
    half_bytes = path.stat().st_size
    parts = {"denoiser": network.state_dict()}
    write_checkpoint(path, facts, parts, data.train.known, is_half=False)
    assert path.stat().st_size > half_bytes
    kept = read_checkpoint(path).parts["denoiser"]
    assert all(torch.equal(kept[name], value) for name, value in parts["denoiser"].items())


def test_equal_training_gives_equal_bytes(path, facts, network, data, tmp_path):
    other = tmp_path / "other.safetensors"
    write_checkpoint(other, facts, {"denoiser": network.state_dict()}, data.train.known)
    assert other.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.999])
def test_truncated_file_is_refused(path, share):
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    assert "is truncated or no checkpoint" in refusal(path)


def test_file_that_is_not_there_or_a_folder_is_refused(tmp_path):
    assert "cannot be read (no such file or directory)" in refusal(tmp_path / "none.safetensors")
    assert "cannot be read (is a directory)" in refusal(tmp_path)


def test_weights_of_another_program_are_refused(tmp_path):
    path = tmp_path / "other.safetensors"
    save_file({"layer.weight": torch.zeros(3)}, path)
    assert "holds weights of another program" in refusal(path)


def test_flipped_bit_in_a_weight_is_noticed(path):
    data = bytearray(path.read_bytes())
    data[-3] ^= 0x40
    path.write_bytes(bytes(data))
    assert "its weights are not those that were written" in refusal(path)


def test_other_version_names_the_one_that_made_it(path):
    with_facts(path, version=7, code="3.2.1+fff")
    message = refusal(path)
    assert "is of version 7; valid: 2" in message
    assert "3.2.1+fff" in message


@pytest.mark.parametrize("preset", ["paper", "progressive"])
def test_older_files_are_refused_and_what_ships_of_the_papers_is_read(path, preset):
    with_facts(path, version=1, code="0.9.0+abc")
    assert "is of version 1; valid: 2" in refusal(path)
    with_facts(path, version=2, preset=preset)
    assert "is of version 2; valid: 4" in refusal(path)
    found = read_checkpoint(SHIPPED[preset])
    assert isinstance(found.known, FlatStatistics)
    assert found.known.has_regions == (preset == "progressive")
    assert set(found.parts) == {"contents", "prior", "denoiser"}


@pytest.mark.parametrize(
    "looks",
    ["[", "{}", '{"bed": [{"domain": "indoor", "attributes": {}, "count": 0}]}', '{"kinds": [3]}'],
)
def test_looks_that_are_none_are_refused(tmp_path, looks):
    path = tmp_path / "paper.safetensors"
    shutil.copy(SHIPPED["paper"], path)
    with_facts(path, vocabulary=looks)
    assert "or the looks of its categories; valid: the file as" in refusal(path)


def test_other_categories_are_refused_and_one_is_named(path):
    with_facts(path, categories=("building", "dragon"))
    assert "2 other categories (it has 'dragon'); valid: the 70" in refusal(path)
    with_facts(path, categories=tuple(reversed(category_names())))
    assert "70 other categories (they are others, or in another order)" in refusal(path)


def test_missing_field_is_named(path):
    with_facts(path, data={"name": "corpus"})
    assert re.search(r"is damaged \(.*digest", refusal(path))


def test_part_that_is_missing_or_does_not_fit_is_named(path):
    checkpoint = read_checkpoint(path)
    with pytest.raises(CheckpointError, match="has no writer, only denoiser; valid: a training"):
        checkpoint.load_into(nn.Linear(3, 5), "writer")
    with pytest.raises(CheckpointError, match="denoiser does not fit the configuration"):
        checkpoint.load_into(nn.Linear(3, 5), "denoiser")


def test_failed_write_leaves_the_old_file(path, facts, network, data):
    before = path.read_bytes()
    parts = {"denoiser": dict(network.state_dict()) | {"strange": "no tensor"}}
    with pytest.raises(AttributeError):
        write_checkpoint(path, facts, parts, data.train.known)
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]
