"""The paper's network: embed, route, extract, fuse, and condition a UNet on the result."""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.encoding import TimeEmbedding
from aeroscene.learning.paper.channels import POSITION, SCALE, FlatStatistics
from aeroscene.learning.paper.guidance.layout import FlatReader, Layout
from aeroscene.learning.paper.network.attention import (
    CrossScaleProgressiveAttention,
    ScaleAttention,
)
from aeroscene.learning.paper.network.coarse import CoarseCnn
from aeroscene.learning.paper.network.embedding import LayoutEmbedding, Seen
from aeroscene.learning.paper.network.fine import FineGnn
from aeroscene.learning.paper.network.nearness import NearnessBias
from aeroscene.learning.paper.network.routing import LearnedRouting, Routes, given_routes
from aeroscene.learning.paper.network.trust import Trust
from aeroscene.learning.paper.network.unet import Condition, TokenUnet

# A constant channel without noise would divide by zero.
_LEAST_TOTAL = 1e-6
_HEIGHT_M = 6.0
"""Distance from the grid's middle to its outermost voxels along the vertical."""


class Levels(NamedTuple):
    """Signal and noise of each token; given tokens have no noise."""

    alpha: Float[Tensor, "batch n 1"]
    sigma: Float[Tensor, "batch n 1"]
    variance: Float[Tensor, "batch n c"]
    """v, variance of the clean channels of the token's category."""

    @property
    def total(self) -> Float[Tensor, "batch n c"]:
        """Variance of x_t, alpha_bar v + sigma^2."""
        return (self.alpha**2 * self.variance + self.sigma**2).clamp(min=_LEAST_TOTAL)


class LayoutDenoiser(nn.Module):
    """Sections 3.2 to 3.4 of the paper in their order, each part a module of its own.

    The UNet does not predict eps from nothing. The best prediction that looks at no other object is
    a formula,

        eps = sigma / V x_t + alpha sqrt(v / V) F(x_t, t) with V = alpha_bar v + sigma^2

    where v is the variance of a channel and F is zero. The UNet's output is F. It is zero at first,
    so that no training ends worse than the formula on scenes that it learns from. On other scenes
    it can, so `Trust` limits how far F is followed there. Source: the preconditioning of Karras et
    al. 2022, "Elucidating the Design Space of Diffusion-Based Generative Models", section 5, for
    eps. The paper's equations for eps stay as they are.
    """

    variance: Tensor

    def __init__(self, cfg: ModelCfg, statistics: FlatStatistics, schedule: Schedule) -> None:
        super().__init__()
        self.cfg, self._schedule = cfg, schedule
        self._read = FlatReader(statistics)
        variance = torch.as_tensor(statistics.variance, dtype=torch.float32)
        self.register_buffer("variance", variance, persistent=False)
        width, levels = cfg.width, cfg.unet_widths
        self.embedding = LayoutEmbedding(cfg, has_regions=bool(statistics.has_regions))
        self.routing = LearnedRouting(width) if cfg.routing == "learned" else None
        self.coarse = _coarse_branch(cfg)
        self.fine = _fine_branch(cfg)
        self.attention = CrossScaleProgressiveAttention(width, cfg.heads, cfg.blocks)
        self.time = TimeEmbedding(width)
        self.nearness = NearnessBias(cfg.heads)
        self.trust = Trust(cfg.trust) if cfg.trust else None
        self.unet = TokenUnet(2 * width, cfg.channels, width, levels, cfg.heads)

    def forward(
        self,
        x_t: Float[Tensor, "batch n c"],
        t: Float[Tensor, " batch"],
        batch: TokenBatch,
    ) -> Prediction:
        """Predict the noise in a batch of layouts; given objects are read from the batch.

        Args:
            x_t: Noisy channels.
            t: Time of each scene, 0 clean to 1 noise.
            batch: Categories, turns, frames and given objects.
        """
        levels, time = self._levels(x_t, t, batch)
        if batch.given is not None and batch.x0 is not None:
            x_t = torch.where(batch.given.unsqueeze(-1), batch.x0.to(x_t), x_t)
        total = levels.total
        # Grid, graph and embedding find boxes in the formula's clean layout, since
        # noisy channels have none.
        seen = self._seen(x_t, levels, batch)
        boxes = seen.boxes
        feature, token, place = self.embedding(seen, time, batch)
        routes = given_routes(batch) if self.routing is None else self.routing(feature, batch.mask)
        fused = self.attention(self._extract(token, boxes, routes, batch), routes)
        condition = Condition(
            nn.functional.silu(time + self.embedding.domain(batch.domain).unsqueeze(1)),
            fused + place,
            batch.mask.unsqueeze(1),
            self.nearness(boxes, batch),
        )
        learned = self.unet(torch.cat([token, fused], dim=-1), condition)
        # Scales F so that its target has unit variance at every noise.
        gain = levels.alpha * (levels.variance / total).sqrt()
        if self.trust is not None:
            gain = gain * self.trust(levels.alpha, levels.sigma)
        output = levels.sigma / total * x_t + gain * learned
        return Prediction(output * batch.mask.unsqueeze(-1), routes.tokenizability)

    def _seen(self, x_t: Tensor, levels: Levels, batch: TokenBatch) -> Seen:
        total = levels.total
        clean = levels.alpha * levels.variance / total * x_t
        doubt = levels.sigma * (levels.variance / total).sqrt()
        boxes = self._read(clean, batch)
        half_m = boxes.size_m * doubt[..., SCALE] * self._read.spread_of(batch)[..., SCALE] / 2
        doubt_m = (doubt[..., POSITION] * self._read.metres_of(batch)).square() + half_m.square()
        # Frames and boxes are turned about the vertical, so east and north share their doubt.
        level_m = doubt_m[..., :2].mean(-1, keepdim=True).expand_as(doubt_m[..., :2])
        faces_m = torch.cat([level_m, doubt_m[..., 2:]], dim=-1).sqrt().repeat(1, 1, 2)
        return Seen(x_t / total.sqrt(), clean, doubt, boxes, faces_m)

    def _levels(
        self, x_t: Tensor, t: Tensor, batch: TokenBatch
    ) -> tuple[Levels, Float[Tensor, "batch n d"]]:
        """Return the noise of each token, and the embedding of its time."""
        clean = torch.zeros_like(batch.mask) if batch.given is None else batch.given
        alpha, sigma = (each.to(x_t)[:, None] for each in self._schedule.signal_and_noise(t))
        levels = Levels(
            torch.where(clean, 1.0, alpha).unsqueeze(-1),
            torch.where(clean, 0.0, sigma).unsqueeze(-1),
            self.variance[batch.kind],
        )
        noisy, quiet = self.time(t).unsqueeze(1), self.time(torch.zeros_like(t)).unsqueeze(1)
        return levels, torch.where(clean.unsqueeze(-1), quiet, noisy)

    def _extract(
        self,
        token: Float[Tensor, "batch n d"],
        boxes: Layout,
        routes: Routes,
        batch: TokenBatch,
    ) -> Float[Tensor, "batch n d"]:
        # F_coarse at coarse tokens, F_fine at fine ones, zero at padding. Both branches see all
        # tokens, so that the gate learns what the other branch would have said of each.
        sides = (
            (self.coarse, routes.is_coarse, routes.coarse_weight),
            (self.fine, routes.is_fine, routes.fine_weight),
        )
        found = torch.zeros_like(token)
        for branch, is_member, weight in sides:
            found = found + weight * branch(token, is_member, _where(branch, boxes, batch))
        return found


def _where(branch: nn.Module, boxes: Layout, batch: TokenBatch) -> Tensor:
    """Return a branch's coordinates of tokens: parents, metres, or shares of the site."""
    if isinstance(branch, ScaleAttention):
        return batch.parent
    if isinstance(branch, FineGnn):
        return boxes.center_enu_m
    assert batch.frame is not None
    # Slot 0 is coarse if there is any, and coarse objects have the site's frame.
    site = torch.cat(
        [batch.frame[:, :1, 5:7], batch.frame.new_full((len(batch.frame), 1, 1), _HEIGHT_M)], -1
    )
    return boxes.center_enu_m / site


def _coarse_branch(cfg: ModelCfg) -> nn.Module:
    if cfg.coarse_branch == "cnn":
        return CoarseCnn(cfg.width, cfg.grid_channels, cfg.grid_shape, cfg.grid_reach)
    return ScaleAttention(cfg.width, cfg.heads, of_siblings=False)


def _fine_branch(cfg: ModelCfg) -> nn.Module:
    if cfg.fine_branch == "radius_gnn":
        return FineGnn(cfg.width, cfg.graph_radius)
    return ScaleAttention(cfg.width, cfg.heads, of_siblings=True)
