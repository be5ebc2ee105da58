"""The paper's network: embed, route, extract, fuse, and condition a UNet on the result."""

from __future__ import annotations

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.encoding import TimeEmbedding
from aeroscene.learning.paper.network.attention import (
    CrossScaleProgressiveAttention,
    ScaleAttention,
)
from aeroscene.learning.paper.network.coarse import CoarseCnn
from aeroscene.learning.paper.network.embedding import LayoutEmbedding
from aeroscene.learning.paper.network.fine import FineGnn
from aeroscene.learning.paper.network.routing import LearnedRouting, Routes, given_routes
from aeroscene.learning.paper.network.unet import Condition, TokenUnet
from aeroscene.learning.tokens.batch import TokenBatch


class LayoutDenoiser(nn.Module):
    """Sections 3.2 to 3.4 of the paper in their order, each part a module of its own.

    Any of routing and branches can be exchanged for ours by the configuration.
    """

    def __init__(self, cfg: ModelCfg) -> None:
        super().__init__()
        self.cfg = cfg
        self.embedding = LayoutEmbedding(cfg)
        self.routing = LearnedRouting(cfg.width) if cfg.routing == "learned" else None
        self.coarse = _coarse_branch(cfg)
        self.fine = _fine_branch(cfg)
        self.attention = CrossScaleProgressiveAttention(cfg.width, cfg.heads, cfg.blocks)
        self.time = TimeEmbedding(cfg.width)
        self.unet = TokenUnet(cfg.channels, cfg.width, cfg.unet_widths, cfg.heads)
        self.unet_position = nn.Linear(cfg.width, cfg.unet_widths[0])

    def forward(
        self,
        x_t: Float[Tensor, "batch n c"],
        t: Float[Tensor, " batch"],
        batch: TokenBatch,
    ) -> Prediction:
        """Predict for a batch of noisy layouts; grid and graph find the positions in x_t."""
        real = batch.mask.unsqueeze(-1)
        x_t = x_t * real
        feature, token, place = self.embedding(x_t, batch)
        routes = given_routes(batch) if self.routing is None else self.routing(feature, batch.mask)
        fused = self.attention(self._extract(token, x_t[..., :3], routes, batch), routes)
        output = self._denoise(x_t, t, fused, place, batch)
        return Prediction(output * real, routes.tokenizability)

    def _extract(
        self,
        token: Float[Tensor, "batch n d"],
        position: Float[Tensor, "batch n 3"],
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
            where = batch.parent if isinstance(branch, ScaleAttention) else position
            found = found + weight * branch(token, is_member, where)
        return found

    def _denoise(
        self,
        x_t: Float[Tensor, "batch n c"],
        t: Float[Tensor, " batch"],
        fused: Float[Tensor, "batch n d"],
        place: Float[Tensor, "batch n d"],
        batch: TokenBatch,
    ) -> Float[Tensor, "batch n c"]:
        # The UNet's list has no gaps: real tokens first, in their order.
        order = torch.argsort(batch.mask.to(torch.uint8), dim=1, descending=True, stable=True)
        condition = Condition(self.time(t), fused, batch.mask.unsqueeze(1))
        position = self.unet_position(place)
        output = self.unet(
            _pick(x_t, order), _pick(position, order), batch.mask.gather(1, order), condition
        )
        return _pick(output, torch.argsort(order, dim=1))


def _pick(value: Float[Tensor, "batch n c"], order: Int[Tensor, "batch n"]) -> Tensor:
    return value.gather(1, order.unsqueeze(-1).expand_as(value))


def _coarse_branch(cfg: ModelCfg) -> nn.Module:
    if cfg.coarse_branch == "cnn":
        return CoarseCnn(cfg.width, cfg.grid_channels, cfg.grid_shape, cfg.grid_reach)
    return ScaleAttention(cfg.width, cfg.heads, of_siblings=False)


def _fine_branch(cfg: ModelCfg) -> nn.Module:
    if cfg.fine_branch == "radius_gnn":
        return FineGnn(cfg.width, cfg.graph_radius)
    return ScaleAttention(cfg.width, cfg.heads, of_siblings=True)
