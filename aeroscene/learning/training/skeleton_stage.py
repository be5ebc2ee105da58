"""The skeleton model's place in a training."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import torch

from aeroscene.learning.skeleton.config import SkeletonError
from aeroscene.learning.skeleton.train import SkeletonProgress, train_skeleton
from aeroscene.learning.training.checkpoint import Weights
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.data import TrainingData
from aeroscene.learning.training.journal import append_line, forget_after
from aeroscene.learning.training.presets import Sections

OnProgress = Callable[[float, Mapping[str, float]], bool]
"""Called with the share that is done and losses by name; whether to go on."""

_LOG_STEPS = 10


def train_skeleton_part(
    folder: Path,
    sections: Sections,
    data: TrainingData,
    device: torch.device,
    on_progress: OnProgress,
) -> tuple[Weights, dict[str, float]] | None:
    """Train the model of skeletons; it takes minutes and begins anew where it was stopped.

    Returns:
        Weights and figures; None where it was stopped.

    Raises:
        TrainingError: If the data will not do, or the loss does not stay finite.
    """
    forget_after(folder, "skeleton", 0)
    is_stopped = False

    def on_step(progress: SkeletonProgress) -> bool:
        nonlocal is_stopped
        figures = {"total": progress.loss}
        if progress.held_out is not None:
            figures["held_out"] = progress.held_out
        if progress.step % _LOG_STEPS == 0 or "held_out" in figures:
            append_line(folder, {"stage": "skeleton", "step": progress.step} | figures)
        is_stopped = not on_progress(progress.share, figures)
        return is_stopped

    try:
        trained = train_skeleton(
            data.skeletons,
            data.vocabulary,
            np.random.default_rng([sections["training"].seed, 2]),
            sections["skeleton"],
            sections["skeleton_training"],
            device,
            on_step,
        )
    except SkeletonError as error:
        raise TrainingError(f"skeleton model: {error}") from None
    if is_stopped:
        return None
    figures = {"skeleton_steps": trained.steps, "skeleton_held_out": trained.held_out}
    return trained.model.state_dict(), figures
