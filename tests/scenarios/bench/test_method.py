"""`aeroscene bench method`: gates that fall where a network has learned nothing, or nonsense."""

import numpy as np
import pytest
import torch

from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.training_set import flat_training_set
from aeroscene.learning.training.checkpoint import read_checkpoint
from scenarios.bench.configs import BenchError, MethodBenchCfg
from scenarios.bench.memorisation import _Off, memorising_rows
from scenarios.bench.method import _Judged, rows
from tests.aeroscene.conftest import SAMPLE, cached_scene
from tests.scenarios.small_corpus import write_corpus

pytestmark = pytest.mark.usefixtures("one_torch_thread")


@pytest.fixture(scope="module")
def scenes():
    return [cached_scene(number) for number in SAMPLE[:3]]


def test_what_ships_is_held_against_the_formula(tmp_path):
    data = write_corpus(tmp_path / "corpus")
    cfg = MethodBenchCfg(data=data, count=4, cpu_seconds=0.0)
    table = {row.metric: row for row in rows(cfg, lambda *_: None)}
    worst = [row for metric, row in table.items() if "worst" in metric]
    assert len(worst) == 4
    assert all(row.target == 1.0 and row.value > 0 for row in worst)
    assert table["error of places by the formula's, mean"].value < 0.95
    shares = [row.value for metric, row in table.items() if metric.startswith("share of")]
    assert sum(shares) == pytest.approx(100.0)
    assert table["heading off, given the quarter turn, mean"].value < 10.0


def test_a_network_that_says_nothing_is_the_formula_and_one_that_is_wrong_is_worse(scenes):
    judged = _Judged(read_checkpoint(SHIPPED["paper"]), flat_training_set(scenes))
    judged._network.trust = None  # which would follow nonsense less far
    outward = judged._network.unet.outward
    with torch.no_grad():
        outward.weight.zero_()
        outward.bias.zero_()
        silent = judged._ratios(0.3)
        outward.bias.fill_(0.5)
        wrong = judged._ratios(0.3)
    assert list(silent.values()) == pytest.approx([1.0] * len(silent), rel=1e-3)
    assert min(wrong[name] for name in ("places", "extents")) > 1.1


def test_a_checkpoint_of_another_preset_is_refused(tmp_path):
    cfg = MethodBenchCfg(checkpoint=SHIPPED["paper"], preset="progressive", data=tmp_path)
    with pytest.raises(BenchError, match="of preset 'paper', valid with --preset progressive"):
        list(rows(cfg, lambda *_: None))


def test_draws_are_held_against_the_scene_that_they_are_most_like():
    real = [_room(0.0), _room(20.0)]
    moved = _room(20.0)
    moved.center_enu_m[:, 0] += 0.04
    moved.size_m[:] *= 1.02
    off = _Off.compare([moved], real)
    assert off.place_cm == pytest.approx(np.full(4, 4.0))
    assert off.extent_percent == pytest.approx(np.full(4, 2.0))
    assert off.missing_percent == 0.0
    lost = FlatBoxes(
        moved.category[1:], moved.center_enu_m[1:], moved.yaw_rad[1:], moved.size_m[1:]
    )
    assert _Off.compare([lost], real).missing_percent == pytest.approx(25.0)


def test_few_small_scenes_are_refused(scenes):
    with pytest.raises(BenchError, match="indoor scenes of 12 to 30 objects; valid: 8 or more"):
        list(memorising_rows("paper", scenes, 1.0))


def _room(shift_m):
    center = np.array([[0, 0, 1], [3, 0, 1], [0, 2, 1], [1, 1, 0.5]], dtype=float)
    category = np.array([1, 1, 2, 3])
    return FlatBoxes(category, center + [shift_m, 0, 0], np.zeros(4), np.ones((4, 3)))
