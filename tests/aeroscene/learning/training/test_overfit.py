"""The whole of it on a few small scenes: a model that has seen them often gives them back."""

import numpy as np
import torch

from aeroscene.learning.diffusion.loss import LossCfg, diffusion_loss
from aeroscene.learning.diffusion.sampling import SamplerCfg, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.network import HierarchicalDenoiser
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.training.batches.source import drawn_from
from aeroscene.learning.training.config import Budget, TrainCfg
from aeroscene.learning.training.loop import DenoiserTraining, train_denoiser

CPU = torch.device("cpu")
SCHEDULE = Schedule()
# Layouts themselves: with so few of them they are learned sooner than noise or velocity.
LOSS = LossCfg(parameterisation="x0")


class AsTheyAre:
    """The scenes in order, never turned: so each has one layout to be remembered."""

    def __init__(self, known) -> None:
        self._known = known

    def sample_batch(self, size, _rng=None):
        examples = self._known.examples
        return self._known.collator.examples([examples[i % len(examples)] for i in range(size)])


def loss(model, batch, generator):
    return vars(diffusion_loss(model, batch, SCHEDULE, LOSS, generator))


def test_few_ten_object_scenes_are_reconstructed_from_noise(data):
    known = data.train
    torch.manual_seed(0)
    model = HierarchicalDenoiser(
        ModelCfg(n_kinds=data.vocabulary.n_kinds, width=32, blocks=2, heads=2)
    )
    cfg = TrainCfg(batch_size=16, learning_rate=5e-3, warmup_steps=20, average_decay=0.98)
    training = DenoiserTraining(model, cfg, CPU)
    seen = []
    train_denoiser(
        training,
        drawn_from(AsTheyAre(known), cfg.batch_size, cfg.seed),
        loss,
        Budget(steps=250),
        lambda report: seen.append(float(report.losses["total"])) is None,
        lambda: 0.0,
    )
    assert np.mean(seen[-20:]) < 0.1 * np.mean(seen[:20])
    model.load_state_dict(training.average.weights)
    batch = AsTheyAre(known).sample_batch(len(known.examples))
    decoder = TreeDecoder(data.vocabulary, known.statistics)
    noise = torch.Generator().manual_seed(1)
    cfg = SamplerCfg(n_steps=20, parameterisation=LOSS.parameterisation)
    x0 = sample(model.eval(), batch, SCHEDULE, cfg, noise, x0_range=decoder.bounds(batch))
    # In standard deviations of the channels, and in metres on sites of up to 95 m.
    assert ((x0 - batch.x0).abs() * batch.weight).max() < 0.2
    away_m = decoder.decode(x0, batch).center_enu_m - decoder.decode(batch.x0, batch).center_enu_m
    away_m = away_m.norm(dim=-1)[batch.mask]
    assert away_m.median() < 0.2
    assert away_m.max() < 3.0
