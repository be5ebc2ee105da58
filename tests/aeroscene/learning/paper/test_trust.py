"""A network is followed as far as scenes bear it out that it has not learnt from."""

import pytest
import torch

from aeroscene.learning.diffusion.config import ScheduleCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import ModelCfg, ModelCfgError
from aeroscene.learning.paper.network.trust import (
    NOISE_TO_SIGNAL,
    Trust,
    _cautious,
    fitted_trust,
    formula,
)
from aeroscene.learning.paper.training_set import flat_training_set
from tests.aeroscene.conftest import SAMPLE, cached_scene

pytestmark = pytest.mark.usefixtures("one_torch_thread")


@pytest.fixture(scope="module")
def batch():
    scenes = flat_training_set([cached_scene(number) for number in SAMPLE[:3]])
    return scenes.in_order(0, 3)


def _fitted(batch, boldness):
    """Trust in a network that knows the clean scene, and corrects `boldness` times as far."""
    schedule = Schedule(ScheduleCfg())
    variance = torch.ones(200, 10)

    def predict(x_t, time, _):
        alpha, sigma = schedule.signal_and_noise(time[0])
        is_free = (batch.weight > 0).to(x_t)
        guess = formula(x_t, time[0], variance[batch.kind], schedule)
        eps = (x_t - alpha * batch.x0 * is_free) / sigma
        return guess + boldness * (eps - guess)

    return fitted_trust(predict, variance, [batch], schedule)


@pytest.mark.parametrize(("boldness", "share"), [(0.5, 1.0), (1.0, 1.0), (2.0, 0.5), (-1.0, 0.0)])
def test_the_correction_is_followed_as_far_as_it_helps(batch, boldness, share):
    rows = _fitted(batch, boldness)
    assert len(rows) == len(NOISE_TO_SIGNAL)
    assert all(row == pytest.approx((share,) * 4, abs=0.02) for row in rows)


def test_shares_are_those_of_the_noise_and_between_two_noises_between():
    rows = [(0.0, 0.0, 0.0, 0.0)] * len(NOISE_TO_SIGNAL)
    rows[5] = (0.8, 0.4, 0.2, 0.6)
    trust = Trust(tuple(rows))
    at = torch.tensor([1.0, 1.0 / 2**0.5, 0.5, 1e4, 0.0]).reshape(1, -1, 1)
    shares = trust(torch.ones_like(at), at)[0]
    assert shares[0].tolist() == pytest.approx([0.8] * 2 + [0.4] + [0.2] * 4 + [0.6] * 3)
    assert shares[1].tolist() == pytest.approx([0.4] * 2 + [0.2] + [0.1] * 4 + [0.3] * 3)
    assert shares[2:].abs().max() < 1e-6


def test_a_share_that_batches_disagree_about_is_taken_lower():
    square = torch.ones(4, 2)
    along = torch.tensor([[0.6, 0.6], [0.6, 1.0], [0.6, 0.2], [0.6, 0.6]])
    agreed, doubtful = _cautious(along, square).tolist()
    assert agreed == pytest.approx(0.6)
    # The standard error of the mean of the four.
    assert doubtful == pytest.approx(0.6 - 0.3266 / 2, abs=1e-3)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (((1.0,) * 4,), "trust has 1 rows; valid: none, or 11"),
        (((1.5,) * 4,) * 11, "trust 1.5 is out of range"),
    ],
)
def test_a_trust_that_fits_no_network_is_refused(rows, says):
    with pytest.raises(ModelCfgError, match=says):
        ModelCfg(trust=rows)
