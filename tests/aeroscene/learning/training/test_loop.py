from dataclasses import dataclass

import pytest
import torch
from torch import nn

from aeroscene.learning.diffusion.config import LossCfg
from aeroscene.learning.diffusion.loss import diffusion_loss
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.training.batches.source import batch_generator, drawn_from
from aeroscene.learning.training.config import Budget, TrainCfg, TrainingError
from aeroscene.learning.training.loop import (
    PartTraining,
    noise_generator,
    train_steps,
)
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.paper_preset import PAPER_TRAINING
from tests.aeroscene.learning.training.conftest import small_sections

CPU = torch.device("cpu")


def new_training(data, cfg):
    torch.manual_seed(0)
    return PartTraining(
        new_denoiser(small_sections(data)["model"], data.train.language, Schedule()), cfg, CPU
    )


def loss(model, batch, generator):
    return vars(diffusion_loss(model, batch, Schedule(), LossCfg(), generator))


def batches(training, data):
    return drawn_from(data.train, training.cfg.batch_size, training.cfg.seed)


@dataclass
class Clock:
    now_s: float = 0.0
    tick_s: float = 1.0

    def __call__(self) -> float:
        self.now_s += self.tick_s
        return self.now_s


def test_minutes_end_a_training_by_the_clock(data):
    training = new_training(data, TrainCfg(batch_size=2))
    shares = []
    budget = Budget(seconds=5.0)
    on_step = lambda report: shares.append(report.share) is None  # noqa: E731
    train_steps(training, batches(training, data), loss, budget, on_step, Clock())
    assert training.step == 5
    assert training.seconds == 5.0
    assert shares == sorted(shares)


def test_steps_and_minutes_end_with_what_is_first(data):
    training = new_training(data, TrainCfg(batch_size=2))
    budget = Budget(steps=3, seconds=100.0)
    train_steps(training, batches(training, data), loss, budget, lambda _: True, Clock())
    assert training.step == 3


@pytest.mark.parametrize("budget", [{}, {"steps": 0}, {"seconds": 0.0}, {"seconds": -1.0}])
def test_training_without_an_end_is_refused(budget):
    with pytest.raises(TrainingError, match="valid:"):
        Budget(**budget)


def test_paper_trains_with_plain_adam_and_keeps_the_average(data):
    training = new_training(data, PAPER_TRAINING)
    assert type(training.optimiser) is torch.optim.Adam
    assert training.optimiser.defaults["lr"] == 1e-3
    assert training.optimiser.defaults["weight_decay"] == 0
    train_steps(training, batches(training, data), loss, Budget(steps=2), lambda _: True, Clock())
    assert training.cfg.average_decay == 0.999
    assert training.average.weights.keys() == training.model.state_dict().keys()


def test_gradient_longer_than_the_limit_is_cut(data):
    cfg = TrainCfg(batch_size=2, clip_norm=1e-3)
    training = new_training(data, cfg)
    training.advance(batches(training, data), loss, Budget(steps=1))
    gradients = [p.grad for p in training.model.parameters() if p.grad is not None]
    norm = torch.stack([g.norm() for g in gradients]).norm()
    torch.testing.assert_close(float(norm), 1e-3, rtol=1e-3, atol=0)


def test_loss_that_is_not_finite_ends_in_one_line_and_changes_no_weight(data):
    training = new_training(data, TrainCfg(batch_size=2))
    before = {k: v.clone() for k, v in training.model.state_dict().items()}

    def broken(model, batch, generator):
        terms = loss(model, batch, generator)
        return terms | {"total": terms["total"] * torch.nan}

    with pytest.raises(TrainingError, match=r"gradient is nan in step 1 .*lower learning_rate"):
        training.advance(batches(training, data), broken, Budget(steps=1))
    after = training.model.state_dict()
    assert all(torch.equal(after[name], value) for name, value in before.items())


def test_every_step_has_batch_and_noise_of_its_own():
    draws = {tuple(batch_generator(0, step).integers(1000, size=4)) for step in range(50)}
    assert len(draws) == 50
    noise = {float(torch.randn(1, generator=noise_generator(0, k, CPU))) for k in range(50)}
    assert len(noise) == 50
    assert float(torch.randn(1, generator=noise_generator(1, 0, CPU))) not in noise


def test_mixed_precision_trains_on_the_processor_too(data):
    training = new_training(data, TrainCfg(batch_size=2, precision="mixed"))
    report = training.advance(batches(training, data), loss, Budget(steps=1))
    assert torch.isfinite(report.losses["total"])
    assert all(p.dtype == torch.float32 for p in training.model.parameters())


def test_model_is_its_own_from_the_start(data):
    training = new_training(data, TrainCfg(batch_size=2))
    kept = training.average.weights
    assert all(isinstance(value, torch.Tensor) for value in kept.values())
    assert isinstance(training.model, nn.Module)
    training.advance(batches(training, data), loss, Budget(steps=1))
    name = next(n for n, p in training.model.named_parameters() if p.grad is not None)
    assert kept[name].data_ptr() != training.model.state_dict()[name].data_ptr()
