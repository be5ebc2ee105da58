"""The semantic prior's stage of a training, and the loss of which L_guide is a part."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import torch

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import LossCfg
from aeroscene.learning.diffusion.loss import Denoiser, GuidanceLoss, diffusion_loss
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.paper.guidance.layout import FlatReader, Layout
from aeroscene.learning.paper.guidance.objectives import Objectives
from aeroscene.learning.paper.guidance.semantic import SemanticPrior, train_semantic_prior
from aeroscene.learning.paper.training_set import FlatTrainingSet
from aeroscene.learning.training.batches.source import batch_generator
from aeroscene.learning.training.checkpoint import Weights
from aeroscene.learning.training.data import TrainingData
from aeroscene.learning.training.journal import append_line, forget_after
from aeroscene.learning.training.loop import (
    LossFunction,
    LossTerms,
    noise_generator,
)
from aeroscene.learning.training.presets import Sections

OnProgress = Callable[[float, Mapping[str, float]], bool]
"""Called with the share that is done and losses by name; False ends the stage."""

_LOG_STEPS = 10
_STREAM = 1 << 30
"""Number of the prior's first batch. The denoiser's training ends before it, so the two draw
different batches."""


class _StoppedError(Exception):
    """The observer of the stage wants it to end."""


def train_prior_part(
    folder: Path,
    sections: Sections,
    data: TrainingData,
    device: torch.device,
    on_progress: OnProgress,
) -> Weights | None:
    """Train the paper's P_sem.

    It takes a minute, so it begins anew if it was stopped.

    Args:
        folder: Folder of the training, whose log it writes.
        sections: Sections of the training.
        data: Training data of one of the paper's presets.
        device: Device that computes.
        on_progress: Called after each step; False stops it.

    Returns:
        Its weights; None if it was stopped.
    """
    # It begins anew, so its old lines go.
    forget_after(folder, "prior", 0)
    cfg = sections["training"]
    train = data.train
    assert isinstance(train, FlatTrainingSet)
    read = FlatReader(train.statistics, device)
    n_drawn = 0

    def layouts(size: int) -> Layout:
        # Each step of the prior needs a batch of its own.
        nonlocal n_drawn
        batch = train.sample_batch(size, batch_generator(cfg.seed, _STREAM + n_drawn))
        n_drawn += 1
        batch = batch.to(device)
        assert batch.x0 is not None
        return read(batch.x0, batch)

    def on_step(step: int, loss: float) -> None:
        if step % _LOG_STEPS == 0:
            append_line(folder, {"stage": "prior", "step": step + 1, "total": round(loss, 6)})
        if not on_progress((step + 1) / cfg.prior_steps, {"total": loss}):
            # An exception, because the training function has no other way to stop.
            raise _StoppedError

    generator = noise_generator(cfg.seed, _STREAM, device)
    try:
        prior = train_semantic_prior(
            layouts, sections["prior"], cfg.prior_steps, generator, on_step
        )
    except _StoppedError:
        return None
    return prior.state_dict()


def loss_function(
    sections: Sections, data: TrainingData, device: torch.device, prior: Weights | None
) -> LossFunction:
    """Return the loss that the sections describe.

    Args:
        sections: Sections of the training.
        data: Training data.
        device: Device that computes.
        prior: Weights of P_sem; without them L_guide lacks its semantic term.
    """
    cfg: LossCfg = sections["loss"]
    guide: GuidanceLoss | None = None
    if cfg.guide_weight > 0:
        known = None
        if prior is not None:
            known = SemanticPrior(sections["prior"])
            # The prior only judges: its weights are frozen below.
            known.load_state_dict(dict(prior))
            known = known.to(device).eval().requires_grad_(requires_grad=False)
        assert isinstance(data.train, FlatTrainingSet)
        statistics = data.train.statistics
        is_hollow = torch.from_numpy(statistics.holds).to(device)
        read = FlatReader(statistics, device)
        guide = Objectives(read, sections["guidance"], known, is_hollow).loss
    return partial(_loss, Schedule(sections["schedule"]), cfg, guide)


def _loss(
    schedule: Schedule,
    cfg: LossCfg,
    guide: GuidanceLoss | None,
    model: Denoiser,
    batch: TokenBatch,
    generator: torch.Generator,
) -> LossTerms:
    return vars(diffusion_loss(model, batch, schedule, cfg, generator, guide))
