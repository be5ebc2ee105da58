"""Programs as padded tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from jaxtyping import Int

from aeroscene.learning.batch import MOST_SIBLINGS, TokenBatch, scaled_wish
from aeroscene.learning.program.program import N_HOSTS, N_MEMBERS
from aeroscene.learning.program.skeleton import Skeleton
from aeroscene.learning.program.statistics import ProgramExample, ProgramStatistics
from aeroscene.learning.wishes import Wish
from aeroscene.scene import DOMAINS

_MOST = np.array([N_MEMBERS, N_HOSTS]) - 1
"""Largest member and rank of a host; greater ones count as these."""


def program_batch(
    examples: Sequence[ProgramExample], wishes: Sequence[Wish], statistics: ProgramStatistics
) -> TokenBatch:
    """Pack programs into a batch, with their channels.

    Args:
        examples: Standardised programs.
        wishes: Contents that each scene is conditioned on.
        statistics: Statistics of the training scenes, which weigh the channels.
    """
    skeletons = [example.skeleton for example in examples]
    importance = statistics.importance
    n_coarse = max(skeleton.n_coarse for skeleton in skeletons)
    n = n_coarse + max(len(skeleton) - skeleton.n_coarse for skeleton in skeletons)
    whole = np.zeros((5, len(examples), n), dtype=np.int64)
    extra = np.zeros((len(examples), n, 3), dtype=np.int64)
    mask = np.zeros((len(examples), n), dtype=bool)
    x0, weight = np.zeros((2, len(examples), n, statistics.mean.shape[1]), dtype=np.float32)
    for row, example in enumerate(examples):
        skeleton = example.skeleton
        slot = slots_of(skeleton, n_coarse)
        whole[:, row, slot] = np.stack(
            [
                skeleton.kind_id,
                # Parents are places in the program; the batch has them as slots.
                slot[skeleton.parent],
                skeleton.depth,
                skeleton.ordinal.clip(max=MOST_SIBLINGS),
                skeleton.twin.clip(max=MOST_SIBLINGS),
            ]
        )
        # Tables of the networks are finite; rarer numbers share the last row.
        numbers = np.stack([example.member, example.host], axis=1).clip(0, _MOST)
        extra[row, slot] = np.column_stack([numbers, example.shape])
        mask[row, slot] = True
        x0[row, slot] = example.x0
        # Padding keeps the weight 0, so the loss ignores it.
        weight[row, slot] = importance[skeleton.kind_id]
    kind, parent, depth, ordinal, twin = torch.from_numpy(whole)
    wish = np.array([scaled_wish(wish) for wish in wishes], dtype=np.float32)
    return TokenBatch(
        kind=kind,
        parent=parent,
        depth=depth,
        ordinal=ordinal,
        twin=twin,
        mask=torch.from_numpy(mask),
        domain=torch.tensor([DOMAINS.index(skeleton.domain) for skeleton in skeletons]),
        wish=torch.from_numpy(wish),
        n_coarse_slots=n_coarse,
        x0=torch.from_numpy(x0),
        weight=torch.from_numpy(weight),
        extra=torch.from_numpy(extra),
    )


def slots_of(skeleton: Skeleton, n_coarse_slots: int) -> Int[np.ndarray, " n"]:
    """Return the slots that the tokens of a program have in a batch.

    Args:
        skeleton: Tree of the program.
        n_coarse_slots: Slots of coarse tokens in the batch, of which the program may fill a part.
    """
    fine = n_coarse_slots + np.arange(len(skeleton) - skeleton.n_coarse)
    return np.concatenate([np.arange(skeleton.n_coarse), fine])


def channels_in(
    batch_x0: torch.Tensor, example: ProgramExample, row: int, n_coarse_slots: int
) -> ProgramExample:
    """Return an example with the channels of a row of a batch.

    Args:
        batch_x0: Channels of the whole batch, on any device.
        example: Program of the row.
        row: Number of the row.
        n_coarse_slots: Slots of coarse tokens in the batch.
    """
    own = batch_x0[row].double().cpu().numpy()
    return replace(example, x0=own[slots_of(example.skeleton, n_coarse_slots)])
