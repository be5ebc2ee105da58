"""Training loss: negative log-likelihood of skeletons under the model, in nats."""

from __future__ import annotations

import torch
from jaxtyping import Float, Int
from torch import Tensor

from aeroscene.learning.skeleton.growth import FOCUS
from aeroscene.learning.skeleton.model import SkeletonModel
from aeroscene.learning.skeleton.sequence import IGNORE, Lesson, Steps
from aeroscene.learning.skeleton.stage import Stage


def skeleton_loss(model: SkeletonModel, lesson: Lesson) -> Float[Tensor, ""]:
    """Negative log likelihood of a batch of skeletons, nats an object."""
    surprise = skeleton_surprise(model, lesson)
    return torch.stack(list(surprise.values())).sum() / lesson.n_objects


def skeleton_surprise(model: SkeletonModel, lesson: Lesson) -> dict[str, Float[Tensor, ""]]:
    """Negative log likelihood of a batch, nats in all, by what is said."""
    table = model.embedding()
    wish = lesson.wish
    steps = lesson.coarse_steps
    known, _ = model.coarse(steps.view, wish[:, None].expand(-1, steps.kind.shape[1], -1), table)
    depth, kind = _placing(model.coarse, known, steps, table)
    memory = model.read_coarse(lesson.coarse, table)
    start = model.start_logits(memory, lesson.coarse, wish, table)
    steps = lesson.fine_steps
    context = model.fine_context(memory, wish, steps.view[FOCUS])
    known, _ = model.fine(steps.view, context, table)
    fine_depth, fine_kind = _placing(model.fine, known, steps, table)
    plans = steps.quota != IGNORE
    return {
        "coarse_depth": depth,
        "coarse_kind": kind,
        "start": _surprise(start, lesson.start),
        "quota": _surprise(model.quota(known[plans]), steps.quota[plans]),
        "fine_depth": fine_depth,
        "fine_kind": fine_kind,
    }


def _placing(
    stage: Stage, known: Float[Tensor, "b t h"], steps: Steps, table: Float[Tensor, "k w"]
) -> tuple[Float[Tensor, ""], Float[Tensor, ""]]:
    places = steps.kind != IGNORE
    depth, kind = steps.depth[places], steps.kind[places]
    known = known[places]
    siblings = [part[places] for part in steps.siblings]
    return (
        _surprise(stage.depth_logits(known), depth - 1),
        _surprise(stage.kind_logits(known, depth, siblings, table), kind),
    )


def _surprise(logits: Float[Tensor, "n choices"], target: Int[Tensor, " n"]) -> Float[Tensor, ""]:
    return torch.nn.functional.cross_entropy(logits, target, ignore_index=IGNORE, reduction="sum")
