"""The paper's semantic constraint guidance, L_sem, with its learned prior.

The paper has P_sem "an MLP estimated from pairwise statistics of the training set" and leaves open
how. Here it tells pairs of neighbours of the training set from pairs whose displacement was
exchanged for another pair's: P_sem is the probability that categories and displacement belong
together, which is bounded, so that no single pair rules the sum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import logsigmoid, softplus

from aeroscene.learning.diffusion.schedule import DiffusionError
from aeroscene.learning.paper.guidance.layout import Layout, turn_back


@dataclass(frozen=True, kw_only=True)
class SemanticPriorCfg:
    """Shape of the prior and of its training."""

    n_categories: int
    width: int = 64
    category_width: int = 16
    n_neighbours: int = 8
    """Pairs are each object with its nearest so many."""
    reach_m: float = 4.0
    """Displacements are read on this scale."""
    learning_rate: float = 2e-3
    batch_size: int = 16
    """Scenes."""

    def __post_init__(self) -> None:
        for name in ("n_categories", "width", "category_width", "n_neighbours", "batch_size"):
            if getattr(self, name) < 1:
                raise DiffusionError(f"prior.{name} is {getattr(self, name)}, valid: from 1")
        for name in ("reach_m", "learning_rate"):
            if getattr(self, name) <= 0:
                raise DiffusionError(f"prior.{name} is {getattr(self, name):g}, valid: above 0")


@dataclass(frozen=True)
class NeighbourPairs:
    """Pairs of objects of a batch."""

    scene: Int[Tensor, " pairs"]
    first: Int[Tensor, " pairs"]
    """Slot in the scene."""
    second: Int[Tensor, " pairs"]
    displacement_m: Float[Tensor, "pairs 3"]
    """Way from the first to the second, in the axes of the first."""


class SemanticPrior(nn.Module):
    """P_sem(c_i, c_j, r_ij) of neighbours."""

    def __init__(self, cfg: SemanticPriorCfg) -> None:
        super().__init__()
        self.cfg = cfg
        self.embedding = nn.Linear(cfg.n_categories, cfg.category_width, bias=False)
        self.mlp = nn.Sequential(
            nn.Linear(2 * cfg.category_width + 5, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, 1),
        )

    def forward(
        self, category: Float[Tensor, "batch n categories"], pairs: NeighbourPairs
    ) -> Float[Tensor, " pairs"]:
        """Logits of P_sem for pairs, by the weights of the categories of all objects."""
        r = pairs.displacement_m / self.cfg.reach_m
        length = r.square().sum(-1, keepdim=True).clamp(min=1e-8).sqrt()
        level = r[:, :2].square().sum(-1, keepdim=True).clamp(min=1e-8).sqrt()
        # Directions stay of order one at any distance.
        r = r / (1 + length)
        features = [r, torch.log1p(length), torch.log1p(level)]
        embedded = self.embedding(category)
        known = [embedded[pairs.scene, slot] for slot in (pairs.first, pairs.second)]
        return self.mlp(torch.cat([*known, *features], dim=-1)).squeeze(-1)


def neighbour_pairs(layout: Layout, n_neighbours: int) -> NeighbourPairs:
    """Each object with its nearest others."""
    center = layout.center_enu_m
    n = layout.mask.shape[1]
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
    """Sum over neighbours of -log P_sem.

    Source: the paper's L_sem(x_t), section "Semantic Constraint Guidance". Its sum runs over all
    pairs; ours over the nearest ones, whose displacement alone says something (and which cost 5%
    as much).
    """
    pairs = neighbour_pairs(layout, prior.cfg.n_neighbours)
    unlikely = -logsigmoid(prior(layout.category, pairs))
    hits = nn.functional.one_hot(pairs.scene, len(layout.mask)).to(unlikely)
    return unlikely @ hits


def prior_loss(
    prior: SemanticPrior, layout: Layout, generator: torch.Generator
) -> Float[Tensor, ""]:
    """How badly the prior tells a layout's pairs from pairs with exchanged displacements."""
    pairs = neighbour_pairs(layout, prior.cfg.n_neighbours)
    order = torch.randperm(len(pairs.scene), generator=generator, device=generator.device)
    displacement = pairs.displacement_m[order.to(pairs.scene.device)]
    exchanged = replace(pairs, displacement_m=displacement)
    real, false = (prior(layout.category, each) for each in (pairs, exchanged))
    return (softplus(-real) + softplus(false)).mean() / 2


def train_semantic_prior(
    layouts: Callable[[int], Layout],
    cfg: SemanticPriorCfg,
    n_steps: int,
    generator: torch.Generator,
    on_step: Callable[[int, float], None] | None = None,
) -> SemanticPrior:
    """A prior that knows the layouts of a training set, of which `layouts` draws so many scenes.

    First weights and exchanges come from the generator, on the layouts' device. After each step
    `on_step` is called with its number, from 0, and its loss.
    """
    prior = SemanticPrior(cfg)
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
        loss = prior_loss(prior, layouts(cfg.batch_size), generator)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        if on_step is not None:
            on_step(step, float(loss.detach()))
    return prior.eval().requires_grad_(requires_grad=False)
