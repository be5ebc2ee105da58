"""The last stage of the paper's presets: trust in the network, fitted on held-out scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.schedule import Schedule, ScheduleCfg
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.network.layout_denoiser import LayoutDenoiser
from aeroscene.learning.paper.network.trust import fitted_trust
from aeroscene.learning.paper.training_set import FlatTrainingSet

_MOST = 96
"""Number of scenes for the fit; they take a minute or two of one core."""
_BATCH = 16


def with_trust(
    cfg: ModelCfg,
    weights: Mapping[str, Tensor],
    known: FlatStatistics,
    held_out: FlatTrainingSet,
    schedule_cfg: ScheduleCfg,
) -> ModelCfg:
    """Return a configuration with the trust that suits half of the held-out scenes.

    Every other scene is taken, the first included. The other half stays untouched for measuring.

    Args:
        cfg: Shape of the network.
        weights: Its weights.
        known: Statistics of the training scenes.
        held_out: Scenes that were not trained on.
        schedule_cfg: Noise schedule.
    """
    schedule = Schedule(schedule_cfg)
    network = LayoutDenoiser(replace(cfg, trust=()), known, schedule)
    network.load_state_dict({name: value.cpu() for name, value in weights.items()})
    network.eval()

    def predict(x_t: Tensor, time: Tensor, batch: TokenBatch) -> Tensor:
        return network(x_t, time, batch).output

    scenes = replace(held_out.with_examples(held_out.examples[::2][:_MOST]), statistics=known)
    starts = range(0, len(scenes.examples), _BATCH)
    batches = (scenes.in_order(start, _BATCH) for start in starts)
    return replace(cfg, trust=fitted_trust(predict, network.variance, batches, schedule))
