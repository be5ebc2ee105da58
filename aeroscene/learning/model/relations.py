"""Attention masks from the tree of a skeleton: the tokens that each token may attend to.

Half of the heads of every attention see the wide relation, the other half the narrow one:

    attention    wide                          narrow
    coarse self  all coarse tokens             parent, children, siblings, itself
    fine self    those under one coarse token  siblings (same parent), itself
    top-down     all coarse tokens             coarse ancestors, the site among them
    bottom-up    all fine tokens               those whose nearest coarse token asks

Masks are added to the logits: 0 where attention is allowed, `MASKED` elsewhere.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.batch import TokenBatch

MASKED = -3.0e4
"""Logit of a forbidden pair. Its exponential is zero in every float type, yet it is finite in half
precision, so that a row in which nothing is allowed gives no NaN. Such a row is multiplied by zero
afterwards."""

MAX_DEPTH = 8
"""Greatest number of ancestors that are followed; the corpus has 5 levels, the skeleton 6."""


class Relations(NamedTuple):
    """Additive masks of one batch."""

    coarse_self: Float[Tensor, "batch h nc nc"]
    fine_self: Float[Tensor, "batch h nf nf"]
    top_down: Float[Tensor, "batch h nf nc"]
    bottom_up: Float[Tensor, "batch h nc nf"]
    has_fine: Float[Tensor, "batch nc d"]
    """1 in the half of a token that heads with at least one key write, 0 elsewhere."""


def nearest_coarse(parent: Int[Tensor, "batch n"], n_coarse_slots: int) -> Int[Tensor, "batch n"]:
    """Return the slot of the nearest coarse ancestor of each token; a coarse token is its own."""
    slot = torch.arange(parent.shape[1], device=parent.device).expand_as(parent)
    above = torch.where(slot < n_coarse_slots, slot, parent)
    # Pointer doubling: each gather doubles the distance, so 3 of them reach 8 ancestors.
    for _ in range(MAX_DEPTH.bit_length() - 1):
        above = above.gather(1, above)
    return above


def coarse_ancestors(
    parent: Int[Tensor, "batch n"], n_coarse_slots: int, nearest: Int[Tensor, "batch n"]
) -> Bool[Tensor, "batch nf nc"]:
    """Return which coarse tokens are above each fine token, at any distance.

    Args:
        parent: Slot of each token's parent.
        n_coarse_slots: Slots from this one on are fine.
        nearest: Result of `nearest_coarse`.
    """
    above = nearest[:, n_coarse_slots:]
    chain = torch.zeros((*above.shape, n_coarse_slots), dtype=torch.bool, device=parent.device)
    # The site is its own parent, so a chain that has arrived there stays there.
    for _ in range(MAX_DEPTH):
        chain.scatter_(2, above.unsqueeze(-1), True)
        above = parent.gather(1, above)
    return chain


def relations_of(
    batch: TokenBatch, heads: int, width: int, has_narrow_heads: bool = True
) -> Relations:
    """Return the attention masks of a batch of skeletons.

    The first half of the heads sees the wide relation. The second half sees the narrow one, or the
    wide one too. Padding is never a key, except of itself.

    Args:
        batch: Skeletons; slot 0 is the site and never padding.
        heads: Number of heads, even.
        width: Width of a token, even.
        has_narrow_heads: False gives all heads the wide relation.
    """
    split, parent, real = batch.n_coarse_slots, batch.parent, batch.mask
    nearest = nearest_coarse(parent, split)
    coarse, fine = real[:, :split], real[:, split:]
    up_coarse, up_fine = parent[:, :split], parent[:, split:]
    slot = torch.arange(split, device=parent.device)
    is_child = up_coarse.unsqueeze(2) == slot
    kin = is_child | is_child.transpose(1, 2) | _same(up_coarse)
    ancestor = coarse_ancestors(parent, split, nearest)
    own = (nearest[:, None, split:] == slot[:, None]) & fine.unsqueeze(1)
    everyone = fine.unsqueeze(1).expand_as(own)
    pairs = (
        (_to_itself(torch.ones_like(kin), coarse), _to_itself(kin, coarse)),
        (_to_itself(_same(nearest[:, split:]), fine), _to_itself(_same(up_fine), fine)),
        (coarse.unsqueeze(1).expand_as(ancestor), ancestor),
        (everyone, own),
    )
    if not has_narrow_heads:
        pairs = tuple((wide, wide) for wide, _ in pairs)
    has_fine = torch.stack([side.any(2) for side in pairs[-1]], dim=2).to(torch.float32)
    coarse_self, fine_self, top_down, bottom_up = (_mask(*pair, heads) for pair in pairs)
    spread = has_fine.repeat_interleave(width // 2, dim=2)
    return Relations(coarse_self, fine_self, top_down, bottom_up, spread)


def _same(label: Int[Tensor, "batch n"]) -> Bool[Tensor, "batch n n"]:
    return label.unsqueeze(2) == label.unsqueeze(1)


def _to_itself(
    allowed: Bool[Tensor, "batch n n"], real: Bool[Tensor, "batch n"]
) -> Bool[Tensor, "batch n n"]:
    # Every token may attend to itself, padding too: a row without any key has no softmax.
    eye = torch.eye(real.shape[1], dtype=torch.bool, device=real.device)
    return (allowed & real.unsqueeze(1)) | eye


def _mask(
    wide: Bool[Tensor, "batch q k"], narrow: Bool[Tensor, "batch q k"], heads: int
) -> Float[Tensor, "batch h q k"]:
    both = torch.stack([wide, narrow], dim=1)
    additive = torch.full(both.shape, MASKED, device=both.device).masked_fill_(both, 0.0)
    return additive.repeat_interleave(heads // 2, dim=1)
