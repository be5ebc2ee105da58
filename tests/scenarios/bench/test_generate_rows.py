"""`aeroscene bench generate` from seeds to rows, with the model that ships."""

import pytest

from aeroscene.corpus.dataset import DatasetError
from aeroscene.learning.generation.request import Request
from scenarios.bench import generate
from scenarios.bench.configs import GenerateBenchCfg
from scenarios.bench.generate import rows
from tests.scenarios.small_corpus import write_corpus

pytestmark = pytest.mark.usefixtures("one_torch_thread")


def config(data, count):
    return GenerateBenchCfg(
        count=count, seed=0, checkpoint=None, preset="default", device="cpu", data=data
    )


@pytest.fixture
def small_scenes(monkeypatch):
    """Scenes of 40 objects, of which the stages of one are timed."""
    monkeypatch.setattr(generate, "_N_TIMED", 1)
    monkeypatch.setattr(generate, "_N_IN_MEMORY", 1)
    monkeypatch.setattr(
        generate, "_request", lambda seed, number: Request(seed=seed + number, n_objects=40)
    )


@pytest.mark.usefixtures("small_scenes")
def test_two_scenes_are_timed_stage_by_stage_and_judged(tmp_path):
    said = []
    corpus = write_corpus(tmp_path / "corpus")
    table = {row.metric: row for row in rows(config(corpus, 2), lambda *words: said.append(words))}
    stages = ("program", "sampling", "feasibility, areas and validation")
    seconds = [table[f"its {stage}, median"].value for stage in stages]
    assert min(seconds) > 0
    assert table["one scene, p95"].value >= table["one scene, median"].value > 0
    assert table["one scene, median"].target == 2.0
    assert 25 < table["its objects, mean"].value < 80
    assert 0.1 < table["peak memory"].value < 8
    assert table["objects valid, before"].target == 85.0
    assert table["objects valid, before"].value > 30
    assert table["objects valid, test split"].value > 99
    assert table["draws sound, after"].value + table["draws rejected"].value == 100
    assert table["displacement, median"].value < 0.5
    # Two scenes are no set to compare; the corpus beside them is.
    assert table["collision rate, all pairs, test split"].value > 0
    assert not any("rate, all pairs, after" in metric for metric in table)
    assert 25 < table["objects / scene, mean"].value < 80
    shares = [share for _, share in said]
    assert shares == sorted(shares)
    assert all(0.0 <= share <= 1.0 for share in shares)


def test_a_corpus_with_too_few_scenes_of_a_split_is_refused_before_the_work(tmp_path):
    said = []
    corpus = write_corpus(tmp_path / "corpus", n_test=4)
    with pytest.raises(DatasetError, match="4 scenes of the test split; valid: 5 or more"):
        next(iter(rows(config(corpus, 2), lambda *words: said.append(words))))
    assert said == []
