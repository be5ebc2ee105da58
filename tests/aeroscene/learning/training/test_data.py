import gzip
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest

from aeroscene.corpus.dataset import DatasetError, store_scene, write_manifest
from aeroscene.layouts.document import LayoutError
from aeroscene.learning.paper.training_set import FlatTrainingSet
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.data import open_training_data, prepared
from aeroscene.learning.training.data_named import count_scenes
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.examples import UnencodableError
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.learning.training.conftest import ten_objects

SCENES = (7, 42, 45)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Mapped layouts are kept where the test ends."""
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corpus")
    (folder / "scenes").mkdir()
    write_manifest(folder, [store_scene(folder, cached_scene(index)) for index in SCENES])
    return folder


def layouts(path, count):
    """Rooms with a table against a wall and chairs about it."""
    lines = []
    for number in range(count):
        boxes = [("dining table", 1.6, 0.9, 0.75)] + [("chair", 0.5, 0.5, 0.9)] * (1 + number % 3)
        objects = [
            {"category": name, "p": [k - 1.5, 1.0, z / 2], "q": [1, 0, 0, 0], "s": [x, y, z]}
            for k, (name, x, y, z) in enumerate(boxes)
        ]
        floor = [[-3, -2], [3, -2], [3, 2], [-3, 2]]
        record = {"scene_id": f"room-{number}", "domain": "indoor", "floor": floor}
        lines.append(json.dumps(record | {"objects": objects}))
    path.write_bytes(gzip.compress("\n".join(lines).encode()))
    return path


def test_corpus_is_split_as_its_manifest_says(corpus):
    seen = []
    data = open_training_data(corpus, on_scene=lambda: seen.append(None))
    # Every fifth scene is of the test split: 45.
    assert data.source.n_scenes == len(data.train.examples) == 2
    assert len(data.held_out.examples) <= 1
    assert len(seen) == 3
    assert data.source.name == corpus.name


def test_digest_changes_with_the_scenes_not_with_the_folder(small_scenes):
    first = prepared("a", small_scenes, [])
    assert prepared("b", small_scenes, []).source.digest == first.source.digest
    assert prepared("a", small_scenes[:3], []).source.digest != first.source.digest


@pytest.mark.parametrize("preset", ["paper", "progressive"])
def test_papers_layouts_have_geometry_alone_as_channels(small_scenes, preset):
    data = prepared("flat", small_scenes, small_scenes[:1], preset=preset)
    assert isinstance(data.train, FlatTrainingSet)
    assert data.train.statistics.has_regions == (preset == "progressive")
    assert data.train.in_order(0, 2).x0.shape[-1] == 10
    assert len(data.held_out.examples) == 1


@pytest.mark.parametrize("preset", ["default", "paper", "progressive"])
def test_encoder_makes_the_same_examples_in_another_process(small_scenes, preset):
    known = prepared("small", small_scenes, [], preset=preset).train
    text = pickle.dumps(known.encoder)
    other = pickle.loads(text)
    for scene, example in zip(small_scenes, known.examples, strict=True):
        made = other(scene, Wish.from_scene(scene))
        if preset != "default":
            assert np.array_equal(made.center_enu_m, example.center_enu_m)
            assert np.array_equal(made.region, example.region)
        else:
            assert np.array_equal(made.example.x0, example.example.x0)
            assert np.array_equal(made.lesson.kind, example.lesson.kind)
    assert pickle.dumps(known.with_examples(known.examples * 9).encoder) == text


def test_processes_that_make_scenes_load_no_pytorch():
    modules = "aeroscene.learning.training.batches.curation, aeroscene.learning.writer.examples"
    code = f"import sys, {modules}; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_held_out_scenes_that_cannot_be_encoded_are_counted(small_scenes):
    outdoor = ten_objects(cached_scene(7))
    indoor = [ten_objects(cached_scene(index)) for index in (2, 5)]
    data = prepared("small", indoor, [indoor[0], outdoor])
    assert (len(data.held_out.examples), data.n_skipped) == (1, 1)
    with pytest.raises(UnencodableError, match=r"^kind .* is unknown"):
        data.train.encoder(outdoor, Wish.from_scene(outdoor))


def test_neutral_layouts_train_too_and_every_tenth_is_held_out(tmp_path):
    data = open_training_data(layouts(tmp_path / "rooms.jsonl.gz", 20))
    # With the mirror image of each.
    assert data.source.n_scenes == 2 * 18
    assert len(data.held_out.examples) == 2
    categories = {kind.category for kind in data.train.language.vocabulary.kinds}
    assert {"table", "chair"} <= categories
    # What is generated has as much as what was trained on: table, chairs, walls, ground.
    assert {wish.domain for wish in data.source.wishes} == {"indoor"}
    assert {wish.n_fine for wish in data.source.wishes} == {2, 3, 4}
    assert len(data.source.wishes) == count_scenes(tmp_path / "rooms.jsonl.gz") - 2


def test_wishes_of_the_corpus_are_kept_and_the_papers_are_its_budget(corpus):
    source = open_training_data(corpus).source
    assert (len(source.wishes), source.is_corpus) == (2, True)
    assert open_training_data(corpus, preset="paper").source.wishes == ()
    assert count_scenes(corpus) == 3


def test_data_that_cannot_be_trained_on_is_named(tmp_path):
    with pytest.raises(DatasetError, match="holds no dataset"):
        open_training_data(tmp_path)
    with pytest.raises(LayoutError, match=r"none\.jsonl"):
        open_training_data(tmp_path / "none.jsonl")
    with pytest.raises(TrainingError, match="has 1 scenes to train on; valid: 2 or more"):
        open_training_data(layouts(tmp_path / "one.jsonl.gz", 1))
