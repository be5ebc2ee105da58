"""The whole of it on a few small scenes: a model that has seen them often gives them back."""

import numpy as np
import torch

from aeroscene.learning.diffusion.config import LossCfg, SamplerCfg
from aeroscene.learning.diffusion.loss import diffusion_loss
from aeroscene.learning.diffusion.sampling import sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.training.config import Budget, TrainCfg
from aeroscene.learning.training.loop import PartTraining, train_steps
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.writer_stage import writer_loss
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.learning.writer.draw import draw_program
from aeroscene.learning.writer.model import new_writer
from aeroscene.learning.writer.stepwise import StepwiseWriter

CPU = torch.device("cpu")
SCHEDULE = Schedule()
# Layouts themselves: with so few of them they are learned sooner than noise or velocity.
LOSS = LossCfg(parameterisation="x0")


def loss(model, batch, generator):
    return vars(diffusion_loss(model, batch, SCHEDULE, LOSS, generator))


def trained(model, cfg, batches, loss, n_steps):
    training = PartTraining(model, cfg, CPU)
    seen = []
    train_steps(
        training,
        batches,
        loss,
        Budget(steps=n_steps),
        lambda report: seen.append(float(report.losses["total"])) is None,
        lambda: 0.0,
    )
    model.load_state_dict(training.average.weights)
    return model.eval(), seen


def test_channels_of_few_programs_are_reconstructed_from_noise(data):
    known = data.train
    torch.manual_seed(0)
    sections = ModelCfg(n_kinds=len(known.language.vocabulary.kinds), width=32, blocks=2, heads=2)
    cfg = TrainCfg(batch_size=16, learning_rate=5e-3, warmup_steps=20, average_decay=0.98)
    n = len(known.examples)
    whole = known.in_order(0, n)
    model, seen = trained(
        new_denoiser(sections, known.language, SCHEDULE), cfg, lambda _: whole, loss, 250
    )
    assert np.mean(seen[-20:]) < 0.1 * np.mean(seen[:20])
    statistics = known.language.statistics
    low, high = (
        torch.tensor(each, dtype=torch.float32)[whole.kind]
        for each in (statistics.low, statistics.high)
    )
    noise = torch.Generator().manual_seed(1)
    cfg = SamplerCfg(n_steps=20, parameterisation=LOSS.parameterisation)
    x0 = sample(model, whole, SCHEDULE, cfg, noise, x0_range=(low, high))
    # In standard deviations of the channels.
    assert ((x0 - whole.x0).abs() * (whole.weight > 0)).mean() < 0.05


def test_a_writer_learns_few_programs_by_heart(data):
    lessons, language = data.train.lessons, data.train.language
    torch.manual_seed(0)
    writer = new_writer(WriterCfg(width=32, kind_width=16, layers=1, dropout=0.0), language)
    whole = lessons.in_order(0, len(lessons.examples))
    cfg = TrainCfg(learning_rate=1e-2, warmup_steps=5, average_decay=0.9)
    writer, seen = trained(writer, cfg, lambda _: whole, writer_loss, 120)
    assert seen[-1] < 0.1 * seen[0]
    known = {tuple(each.example.skeleton.kind_id.tolist()) for each in lessons.examples}
    wish = lessons.examples[0].wish
    drawn = [
        draw_program(
            StepwiseWriter(writer), language.syntax, wish, np.random.default_rng(seed)
        ).kinds
        for seed in range(6)
    ]
    assert sum(tuple(kinds) in known for kinds in drawn) >= 4
