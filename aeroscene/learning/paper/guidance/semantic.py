"""The paper's semantic constraint guidance, L_sem, with its learned prior.

The paper has P_sem "an MLP estimated from pairwise statistics of the training set" and leaves open
how. Here it is a density. For two categories an MLP gives a mixture of Gaussians over the
displacement from one object to its neighbour, in the axes of the first. The slope of a density
points to where the second object belongs. A classifier of real against exchanged pairs has no such
slope: guided by it, scenes became less plausible.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from aeroscene.learning.paper.guidance.config import SemanticPriorCfg
from aeroscene.learning.paper.guidance.layout import Layout, turn_back

_N_NUMBERS = 7
"""Numbers of a Gaussian: its share, and middle and spread along three axes."""
_LOG_SPREAD = (math.log(0.05), math.log(30.0))
"""Logarithms of the least and greatest spread, m."""
_HALF_LOG_TWO_PI = math.log(2 * math.pi) / 2


@dataclass(frozen=True)
class NeighbourPairs:
    """Pairs of objects of a batch."""

    scene: Int[Tensor, " pairs"]
    """Row of the pair's scene in the batch."""
    first: Int[Tensor, " pairs"]
    """Slot of the first object in its scene."""
    second: Int[Tensor, " pairs"]
    displacement_m: Float[Tensor, "pairs 3"]
    """Displacement from the first to the second, in the axes of the first."""


class SemanticPrior(nn.Module):
    """P_sem(c_i, c_j, r_ij) of neighbours, a density over r_ij in 1/m^3."""

    def __init__(self, cfg: SemanticPriorCfg) -> None:
        super().__init__()
        self.cfg = cfg
        self.embedding = nn.Embedding(1 + cfg.n_categories, cfg.category_width)
        self.mlp = nn.Sequential(
            nn.Linear(2 * cfg.category_width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.n_parts * _N_NUMBERS),
        )

    def forward(
        self, category: Int[Tensor, "batch n"], pairs: NeighbourPairs
    ) -> Float[Tensor, " pairs"]:
        """Logarithm of P_sem of each pair.

        Args:
            category: Categories of all objects of the batch.
            pairs: Pairs of these objects.
        """
        embedded = self.embedding(category)
        known = [embedded[pairs.scene, slot] for slot in (pairs.first, pairs.second)]
        found = self.mlp(torch.cat(known, dim=-1)).unflatten(-1, (self.cfg.n_parts, _N_NUMBERS))
        share, middle, log_spread = found.split([1, 3, 3], dim=-1)
        # A sigmoid keeps spreads in range: a Gaussian on one point would have an endless density.
        log_spread = _LOG_SPREAD[0] + (_LOG_SPREAD[1] - _LOG_SPREAD[0]) * log_spread.sigmoid()
        off = (pairs.displacement_m.unsqueeze(1) - self.cfg.reach_m * middle) / log_spread.exp()
        log_part = -(off.square() / 2 + log_spread + _HALF_LOG_TWO_PI).sum(-1)
        return (share.squeeze(-1).log_softmax(-1) + log_part).logsumexp(-1)


def neighbour_pairs(layout: Layout, n_neighbours: int) -> NeighbourPairs:
    """Pair each object with its nearest others.

    Args:
        layout: Objects of a batch.
        n_neighbours: Greatest number of neighbours of an object.
    """
    center = layout.center_enu_m
    n = layout.mask.shape[1]
    # Choosing neighbours has no slope; the displacement below has one.
    apart = (center[:, :, None] - center[:, None]).detach().square().sum(-1)
    taken = ~layout.mask[:, None] | torch.eye(n, dtype=torch.bool, device=center.device)
    apart = apart.masked_fill(taken, torch.inf)
    near = apart.topk(min(n_neighbours, n), dim=-1, largest=False)
    is_pair = layout.mask[..., None] & near.values.isfinite()
    scene, first, place = is_pair.nonzero(as_tuple=True)
    second = near.indices[scene, first, place]
    displacement = turn_back(
        center[scene, second] - center[scene, first], layout.heading[scene, first]
    )
    return NeighbourPairs(scene, first, second, displacement)


def semantic_loss(layout: Layout, prior: SemanticPrior) -> Float[Tensor, " batch"]:
    """Sum over neighbours of -log P_sem, one value for each scene.

    Source: the paper's L_sem(x_t), section "Semantic Constraint Guidance". The paper's sum runs
    over all pairs. Ours runs over the nearest ones, because only their displacement is informative,
    and at 5% of the cost.
    """
    pairs = neighbour_pairs(layout, prior.cfg.n_neighbours)
    unlikely = -prior(layout.category, pairs)
    hits = nn.functional.one_hot(pairs.scene, len(layout.mask)).to(unlikely)
    return unlikely @ hits


def prior_loss(prior: SemanticPrior, layout: Layout) -> Float[Tensor, ""]:
    """Mean negative log-likelihood of a layout's pairs, nats a pair."""
    return -prior(layout.category, neighbour_pairs(layout, prior.cfg.n_neighbours)).mean()


def train_semantic_prior(
    layouts: Callable[[int], Layout],
    cfg: SemanticPriorCfg,
    n_steps: int,
    generator: torch.Generator,
    on_step: Callable[[int, float], None] | None = None,
) -> SemanticPrior:
    """Train a prior on the layouts of a training set.

    Args:
        layouts: Draws a batch of so many scenes.
        cfg: Shape of the prior and of its training.
        n_steps: Training steps.
        generator: Source of the first weights, on the layouts' device.
        on_step: Called after each step with its number, from 0, and its loss.

    Returns:
        The prior with frozen weights.
    """
    prior = SemanticPrior(cfg)
    # PyTorch would draw first weights from its global generator; these come from ours.
    for parameter in prior.parameters():
        if parameter.ndim > 1:
            bound = parameter.shape[1] ** -0.5
            noise = torch.rand(parameter.shape, generator=generator, device=generator.device)
            parameter.data = (2 * noise - 1) * bound
        else:
            nn.init.zeros_(parameter)
    prior = prior.to(generator.device)
    optimiser = torch.optim.Adam(prior.parameters(), lr=cfg.learning_rate)
    for step in range(n_steps):
        loss = prior_loss(prior, layouts(cfg.batch_size))
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        if on_step is not None:
            on_step(step, float(loss.detach()))
    return prior.eval().requires_grad_(requires_grad=False)
