"""The stream: the same batches whoever makes them, a pool that moves, nothing left behind."""

import multiprocessing
import re
from collections import deque
from dataclasses import fields, replace

import pytest
import torch

from aeroscene.corpus.curation import curate_layout, curate_scene, most_landing_areas
from aeroscene.landform import level
from aeroscene.learning.training.batches.curation import (
    fresh_example,
    numbers_after,
    scene_file,
)
from aeroscene.learning.training.batches.opened import Supply, open_batches
from aeroscene.learning.training.batches.source import StoppedError
from aeroscene.learning.training.batches.stream import StreamedBatches
from aeroscene.learning.training.config import TrainCfg, TrainingError
from aeroscene.learning.training.data import prepared
from aeroscene.learning.training.journal import read_log
from aeroscene.scene.io import write_scene
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.learning.training.batches.encoder import OneKind
from tests.aeroscene.learning.training.conftest import ten_objects

FIRST = (7, 42, 49, 311)
LAST = 311
CFG = TrainCfg(batch_size=4, scene_uses=4)
"""Each step takes one scene more."""


@pytest.fixture(scope="module")
def known():
    return prepared("small", [ten_objects(cached_scene(index)) for index in FIRST], []).train


@pytest.fixture
def folder(tmp_path):
    """A training's folder in which the scenes lie already, so that none takes half a second."""
    path = scene_file(tmp_path, 312)
    path.parent.mkdir()
    scene = ten_objects(cached_scene(7))
    for number in range(312, 420):
        write_scene(replace(scene, seed=number), scene_file(tmp_path, number))
    return tmp_path


@pytest.fixture
def opened(known, folder):
    """Makes streams that end with the test."""
    streams = []

    def new(step=0, n_workers=1, refused=(), **more):
        encode = OneKind(known.examples[0], refused)
        stream = StreamedBatches(known, encode, LAST, CFG, folder, step, n_workers, **more)
        streams.append(stream)
        return stream

    yield new
    for stream in streams:
        stream.__exit__(None, None, None)


def numbers(stream):
    return [each.number for each in stream._pool]


def same(left, right):
    pairs = ((getattr(left, f.name), getattr(right, f.name)) for f in fields(left))
    return all(
        torch.equal(a.nan_to_num(-1), b.nan_to_num(-1)) if isinstance(a, torch.Tensor) else a == b
        for a, b in pairs
    )


def test_training_never_sees_a_number_of_the_test_split():
    stream = numbers_after(1015)
    found = [next(stream) for _ in range(400)]
    assert found[:5] == [1016, 1017, 1018, 1019, 1021]
    assert all(number % 5 for number in found)


def test_pool_moves_by_batch_over_uses_each_step(opened):
    stream = opened()
    assert numbers(stream) == [-1] * 4
    stream(0)
    assert numbers(stream) == [-1] * 4
    stream(1)
    assert numbers(stream) == [-1, -1, -1, 312]
    stream(6)
    assert numbers(stream) == [314, 316, 317, 318]


@pytest.mark.parametrize("begin", [2, 9])
def test_batches_depend_on_seed_and_step_alone(opened, begin):
    """Whether resumed, and with however many workers."""
    resumed = opened(step=begin, n_workers=2)
    batches = {step: resumed(step) for step in range(begin, begin + 3)}
    whole = opened()
    for step in range(begin + 3):
        batch = whole(step)
        assert step < begin or same(batch, batches[step])
    assert numbers(whole) == numbers(resumed)
    assert not same(batches[begin], batches[begin + 1])


def test_scene_of_an_unknown_kind_is_left_out_counted_and_named_once(opened, folder):
    stream = opened(refused=(313,))
    for step in range(4):
        batch = stream(step)
    assert numbers(stream) == [-1, 312, 313, 314]
    seen = {round(float(w)) for w in (batch.wish[:, 2] * 12 + 56)}
    assert 313 not in seen
    resumed = opened(step=4, refused=(313,))
    resumed(4)
    lines = [line for line in read_log(folder) if "reason" in line]
    assert [(line["step"], line["skipped"]) for line in lines] == [(3, 313)]
    assert "hovercraft" in lines[0]["reason"]
    assert stream.figures(4)["skipped"] == resumed.figures(5)["skipped"] == 1


def test_what_was_skipped_after_the_last_save_is_said_again_not_twice(opened, folder):
    stream = opened(refused=(313, 314))
    for step in range(4):
        stream(step)
    resumed = opened(step=3, refused=(313, 314))
    resumed(3)
    lines = [line["skipped"] for line in read_log(folder) if "reason" in line]
    assert lines == [313, 314]
    assert resumed.figures(4)["skipped"] == 2


def test_stream_of_other_kinds_ends_the_training_in_a_line(opened):
    stream = opened(refused=range(400))
    with pytest.raises(TrainingError, match=r"has 1 scenes of known kinds among 4 \(kind hoverc"):
        deque(map(stream, range(9)))


def test_files_of_scenes_that_have_left_the_pool_go(opened, folder):
    stream = opened()
    for step in range(8):
        stream(step)
    assert not scene_file(folder, 312).exists()
    assert not scene_file(folder, 314).exists()
    assert all(scene_file(folder, number).exists() for number in numbers(stream))


def test_log_says_how_often_scenes_are_used(opened, folder):
    stream = opened()
    for step in range(8):
        stream(step)
    figures = stream.figures(8)
    assert figures["scenes"] == 4 + 7
    assert figures["uses"] == pytest.approx(8 * 4 / 11, abs=0.01)
    first = next(read_log(folder))
    assert first == {"stage": "stream", "step": 0, "scene_uses": 4, "pool": 4}


def test_wish_to_stop_is_heard_while_it_waits_for_scenes(opened):
    stream = opened(wants_stop=lambda: True)
    stream(0)
    with pytest.raises(StoppedError):
        stream(1)


def test_scene_from_its_file_is_the_one_that_was_made(tmp_path):
    """What a resume reads back is what was trained on, to the last bit."""
    number = next(numbers_after(311))
    encode = prepared("one", [curate_scene(number)] * 2, []).train.encoder
    made = fresh_example(encode, tmp_path, number)
    assert scene_file(tmp_path, number).exists()
    read = fresh_example(encode, tmp_path, number)
    assert (made.example.example.x0 == read.example.example.x0).all()
    assert (made.example.lesson.kind == read.example.lesson.kind).all()


def test_scene_of_the_stream_is_that_of_its_number_on_flat_ground_without_areas():
    scene = curate_scene(13)
    assert scene.relief is not None
    assert curate_layout(13) == level(scene)
    assert 0 < len(scene.landing_areas) <= most_landing_areas(13)


def test_scene_of_a_new_kind_is_skipped_with_its_reason(known, tmp_path):
    path = scene_file(tmp_path, 313)
    path.parent.mkdir()
    write_scene(cached_scene(45), path)
    fresh = fresh_example(known.encoder, tmp_path, 313)
    assert fresh.example is None
    assert re.fullmatch(r"kind \w+( \w+)? is unknown", fresh.reason)


def test_workers_end_with_the_batches(known, tmp_path):
    data = prepared("small", [ten_objects(cached_scene(index)) for index in FIRST], [])
    data = replace(data, last_number=LAST)
    cpu = torch.device("cpu")
    supply = Supply(
        scenes=data.train,
        encode=data.train.encoder,
        last_number=data.last_number,
        folder=tmp_path,
        n_workers=2,
        stage="denoiser",
        is_last=True,
    )
    with open_batches(supply, CFG, cpu, 0, lambda: False) as batches:
        batches.batches(0)
        assert len(multiprocessing.active_children()) == 2
    assert multiprocessing.active_children() == []
