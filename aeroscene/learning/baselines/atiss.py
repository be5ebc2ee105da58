"""ATISS: draws one object after the other, given the unordered set of earlier objects.

This is a re-implementation from the paper.

    choice      paper                                                    here
    network     transformer encoder without positions, a query token     narrower
    an object   category, place, angle, size, each given those before    the same
    attributes  mixtures of ten logistic distributions                   the same
    context     features of the floor plan                               the domain alone
    training    random order, cut at random; next one is the target      all later objects are

Taking all objects after a cut as targets has the same expectation as taking one of them, and less
variance.

Source: Paschalidou, Kar, Shugrina, Kreis, Geiger and Fidler 2021, "ATISS: Autoregressive
Transformers for Indoor Scene Synthesis", NeurIPS, sections 3.1 to 3.3.
"""

from __future__ import annotations

import math

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn

from aeroscene.learning.baselines.layouts import (
    CATEGORY,
    CENTRE,
    EMPTY,
    HEADING,
    LOG_SIZE,
    N_CHANNELS,
    N_GEOMETRY,
    LayoutCode,
)
from aeroscene.learning.baselines.model import BaselineCfg, BaselineModel
from aeroscene.learning.baselines.networks.mixture import (
    N_COMPONENTS,
    draw_mixture,
    mixture_loss,
    spread_means,
)
from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.model.encoding import fourier_features
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.training.loop import LossTerms
from aeroscene.metrics.arrays import N_CATEGORIES
from aeroscene.scene import DOMAINS

_END = N_CATEGORIES
"""Class that ends a scene, after those of the categories."""
# Frequencies of the Fourier features of each number.
_BANDS = 6
# Weight, mean and log scale of each component of a mixture.
_PER_NUMBER = 3 * N_COMPONENTS
_REACH = 2.0
"""Standardised places and sizes mostly lie within this distance of 0."""


class Atiss(BaselineModel):
    """Encoder of the objects so far, and one head for each attribute of the next object.

    The heads form a chain: class, place, angle, size. Each reads the values that the earlier ones
    gave.
    """

    def __init__(self, code: LayoutCode, cfg: BaselineCfg) -> None:
        super().__init__(code)
        width = cfg.width
        n_geometry = N_GEOMETRY * (1 + 2 * _BANDS)
        self.inward = nn.Linear(n_geometry + N_CATEGORIES, width)
        self.domain = nn.Embedding(len(DOMAINS), width)
        self.query = nn.Parameter(torch.randn(width) / math.sqrt(width))
        layer = nn.TransformerEncoderLayer(
            width, cfg.heads, 2 * width, dropout=0.0, batch_first=True, norm_first=True
        )
        self.encoder = nn.TransformerEncoder(layer, cfg.levels, enable_nested_tensor=False)
        self.kind = nn.Embedding(N_CATEGORIES, width)
        self.class_head = _head(width, N_CATEGORIES + 1)
        # Each head reads the query's token, the category and all earlier attributes.
        known = 2 * width
        self.place_head = _mixture_head(known, 3, _REACH)
        known += 3 * (1 + 2 * _BANDS)
        self.angle_head = _mixture_head(known, 1, 1.0)
        known += 1 + 2 * _BANDS
        self.size_head = _mixture_head(known, 3, _REACH)

    def forward(self, batch: TokenBatch, generator: torch.Generator) -> LossTerms:
        """Negative log-likelihood of the objects that follow a random part of a scene, in nats.

        Args:
            batch: Layouts with `x0`, as `LayoutCode.encode` writes them.
            generator: Source of the order of the objects and of the cut.

        Returns:
            `total`, and its detached parts `category` and `geometry`.
        """
        x, mask = _shuffled(batch, generator)
        count = mask.sum(dim=1)
        share = torch.rand(len(x), generator=generator, device=generator.device).to(x)
        n_known = (share * (count + 1)).floor().long().clamp(max=x.shape[1])
        place = torch.arange(x.shape[1], device=x.device)
        is_known = place < n_known[:, None]
        # The encoder reads no slots beyond the longest known part of the batch: saves time.
        most = int(n_known.max())
        told = self._told(x[:, :most], is_known[:, :most], batch.domain)
        follows = mask & ~is_known
        is_whole = ~follows.any(dim=1)
        # Each scene contributes one term: the mean over all objects that may follow, or the end.
        weight = follows / follows.sum(dim=1, keepdim=True).clamp(min=1)
        log_class = torch.log_softmax(self.class_head(told), dim=-1)
        category = x[..., CATEGORY].argmax(dim=-1)
        of_class = -(log_class.gather(1, category) * weight).sum(1) - log_class[:, _END] * is_whole
        scene, slot = follows.nonzero(as_tuple=True)
        of_object = self._geometry_loss(told[scene], x[scene, slot], category[scene, slot])
        of_geometry = torch.zeros_like(of_class).index_add(
            0, scene, of_object * weight[scene, slot]
        )
        return {
            "total": (of_class + of_geometry).mean(),
            "category": of_class.mean().detach(),
            "geometry": of_geometry.mean().detach(),
        }

    def _geometry_loss(
        self,
        told: Float[Tensor, "m d"],
        x: Float[Tensor, "m c"],
        category: Int[Tensor, " m"],
    ) -> Float[Tensor, " m"]:
        """Negative log-likelihood of objects, each given what its scene has already."""
        known = torch.cat([told, self.kind(category)], dim=-1)
        angle = _angle(x)
        total = mixture_loss(_mixtures(self.place_head(known)), x[..., CENTRE])
        known = torch.cat([known, _encoded(x[..., CENTRE])], dim=-1)
        total = total + mixture_loss(_mixtures(self.angle_head(known)), angle)
        known = torch.cat([known, _encoded(angle)], dim=-1)
        return total + mixture_loss(_mixtures(self.size_head(known)), x[..., LOG_SIZE])

    @torch.no_grad()
    def draw(self, domain: int, generator: torch.Generator) -> FlatBoxes:
        """Draw a layout object by object, until the end is drawn or all slots are full."""
        device = next(self.parameters()).device
        x = torch.zeros((1, self.code.n_slots, N_CHANNELS), device=device)
        where = torch.tensor([domain], device=device)
        n = 0
        while n < self.code.n_slots:
            is_known = torch.ones((1, n), dtype=torch.bool, device=device)
            told = self._told(x[:, :n], is_known, where)[0]
            logits = self.class_head(told)
            if n == 0:
                # An empty scene cannot be decoded.
                logits[_END] = -math.inf
            category = int(torch.multinomial(logits.softmax(-1), 1, generator=generator))
            if category == _END:
                break
            x[0, n] = self._drawn_object(told, category, generator)
            n += 1
        return self.code.decode(x[0, :n].double().cpu().numpy())

    def _drawn_object(
        self, told: Float[Tensor, " d"], category: int, generator: torch.Generator
    ) -> Float[Tensor, " c"]:
        low, high = (
            torch.as_tensor(bound[:6], dtype=torch.float32, device=told.device)
            for bound in (self.code.low, self.code.high)
        )
        known = torch.cat([told, self.kind.weight[category]])
        place = draw_mixture(_mixtures(self.place_head(known)), generator)
        # The tails of a logistic distribution reach beyond every value of training.
        place = torch.minimum(torch.maximum(place, low[CENTRE]), high[CENTRE])
        known = torch.cat([known, _encoded(place)])
        angle = draw_mixture(_mixtures(self.angle_head(known)), generator).clamp(-1, 1)
        known = torch.cat([known, _encoded(angle)])
        size = draw_mixture(_mixtures(self.size_head(known)), generator)
        size = torch.minimum(torch.maximum(size, low[LOG_SIZE]), high[LOG_SIZE])
        turn = math.pi * angle
        found = torch.full((N_CHANNELS,), -1.0, device=told.device)
        found[CENTRE], found[LOG_SIZE] = place, size
        found[HEADING] = torch.cat([turn.cos(), turn.sin()])
        found[N_GEOMETRY + category] = 1.0
        found[EMPTY] = -1.0
        return found

    def _told(
        self,
        x: Float[Tensor, "batch n c"],
        is_known: Bool[Tensor, "batch n"],
        domain: Tensor,
    ) -> Float[Tensor, "batch d"]:
        """Encode the known objects and return the query's token."""
        category = (x[..., CATEGORY] + 1) / 2
        # Categories are stored as -1 and 1; here 0 and 1 select a column of the layer.
        objects = self.inward(torch.cat([_encoded(x[..., :N_GEOMETRY]), category], dim=-1))
        context = self.domain(domain)[:, None]
        query = self.query.expand(len(x), 1, -1)
        tokens = torch.cat([query, context, objects], dim=1)
        always = torch.ones((len(x), 2), dtype=torch.bool, device=x.device)
        is_missing = ~torch.cat([always, is_known], dim=1)
        return self.encoder(tokens, src_key_padding_mask=is_missing)[:, 0]


def _head(inward: int, outward: int) -> nn.Sequential:
    width = inward // 2
    return nn.Sequential(nn.Linear(inward, width), nn.ReLU(), nn.Linear(width, outward))


def _mixture_head(inward: int, numbers: int, reach: float) -> nn.Sequential:
    head = _head(inward, numbers * _PER_NUMBER)
    last = head[-1]
    assert isinstance(last, nn.Linear)
    spread_means(last, reach)
    return head


def _mixtures(flat: Float[Tensor, "*n c"]) -> Float[Tensor, "*n k 30"]:
    return flat.unflatten(-1, (-1, _PER_NUMBER))


def _encoded(values: Float[Tensor, "*n c"]) -> Float[Tensor, "*n f"]:
    return torch.cat([values, fourier_features(values, _BANDS)], dim=-1)


def _angle(x: Float[Tensor, "batch n c"]) -> Float[Tensor, "batch n 1"]:
    """Yaw divided by pi, -1 to 1."""
    cos, sin = x[..., HEADING].chunk(2, dim=-1)
    return torch.atan2(sin, cos) / math.pi


def _shuffled(batch: TokenBatch, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Shuffle the objects of each layout, padding last."""
    assert batch.x0 is not None
    chance = torch.rand(batch.mask.shape, generator=generator, device=generator.device)
    # Chance is below 1, so that adding 1 to padding sorts it behind all objects.
    order = (chance.to(batch.x0) + ~batch.mask).argsort(dim=1)
    x = batch.x0.gather(1, order[..., None].expand_as(batch.x0))
    return x, batch.mask.gather(1, order)
