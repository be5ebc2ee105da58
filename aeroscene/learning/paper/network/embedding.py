"""Initial layout and hierarchy embedding: from the noisy channels of an object to its token.

A network sees a layout twice: the noisy channels themselves, and the boxes in the world that the
channels stand for. Of the latter the faces are what matters, since a wall ends where another
begins and a bed stands against one. They come as Fourier features, in which equal places have
equal vectors.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from aeroscene.learning.model.config import N_GEOMETRY, ModelCfg
from aeroscene.learning.model.encoding import sinusoid
from aeroscene.learning.paper.guidance.layout import Layout
from aeroscene.learning.tokens.batch import TokenBatch

LONGEST_M = 128.0
"""Longest wavelength of a face's Fourier features; each further band halves it."""
_N_TURNS = 4
_FACES_M = 8.0
"""Faces are seen on this scale, beside their waves."""
_MOST = 6.0
"""Channels are cut off at so many spreads: an object may be unlike all that were trained on."""
_PLACE_SCALE = 0.1
"""e_pos is so much quieter than as it is written, or keys and values are mostly the index."""


class Embedded(NamedTuple):
    """The paper's token and what it is the sum of."""

    feature: Float[Tensor, "batch n d"]
    """f^(0), geometry and semantics alone: the routing reads it."""
    token: Float[Tensor, "batch n d"]
    """h = f^(0) + e_pos + e_dom, and the time."""
    place: Float[Tensor, "batch n d"]
    """e_pos."""


class LayoutEmbedding(nn.Module):
    """The paper's h_i = f_i^(0) + e_i^pos + e_i^dom with f_i^(0) = MLP([p, q, s, Emb(c)]).

    The category and its quarter turn are given: "a one-hot vector which conditioned as learned
    soft-embeddings". The place i is counted among real tokens.
    """

    def __init__(self, cfg: ModelCfg) -> None:
        super().__init__()
        self.width, self.bands = cfg.width, cfg.fourier_bands
        self.category = nn.Embedding(1 + cfg.n_categories, cfg.width)
        self.turn = nn.Embedding(_N_TURNS, cfg.width)
        self.mlp = nn.Sequential(
            nn.Linear(N_GEOMETRY + 12 * cfg.fourier_bands + 13 + cfg.width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.width),
        )
        self.domain = nn.Embedding(cfg.n_domains, cfg.width)

    def forward(
        self,
        x: Float[Tensor, "batch n c"],
        boxes: Layout,
        time: Float[Tensor, "batch n d"],
        batch: TokenBatch,
    ) -> Embedded:
        """Tokens of a noisy layout, whose channels have unit variance here."""
        assert batch.turn is not None
        assert batch.frame is not None
        known = self.category(batch.kind) + self.turn(batch.turn)
        faces = faces_m(boxes)
        waves = fourier_of_faces(faces, self.bands)
        shape = [boxes.heading, boxes.size_m.log(), batch.frame[..., 5:7].log()]
        seen = torch.cat([x.clamp(-_MOST, _MOST), faces / _FACES_M, waves, *shape, known], dim=-1)
        feature = self.mlp(seen)
        place = _PLACE_SCALE * sinusoid(batch.mask.cumsum(1) - 1, self.width)
        token = feature + place + time + self.domain(batch.domain).unsqueeze(1)
        return Embedded(feature, token, place)


def level_extent_m(boxes: Layout) -> Float[Tensor, "batch n 3"]:
    """Extents of the upright boxes along east, north and up."""
    cos, sin = boxes.heading.abs().unbind(-1)
    x, y, z = boxes.size_m.unbind(-1)
    return torch.stack([cos * x + sin * y, sin * x + cos * y, z], dim=-1)


def faces_m(boxes: Layout) -> Float[Tensor, "batch n 6"]:
    """Where the faces of each box are along east, north and up: the lower three, then the upper."""
    half = level_extent_m(boxes) / 2
    return torch.cat([boxes.center_enu_m - half, boxes.center_enu_m + half], dim=-1)


def fourier_of_faces(faces: Float[Tensor, "batch n 6"], bands: int) -> Float[Tensor, "batch n f"]:
    """Sines and cosines of where faces are, two of each band and face."""
    octave = torch.arange(bands, device=faces.device, dtype=torch.float32)
    angle = (faces.unsqueeze(-1) * (2 * math.pi / LONGEST_M * 2.0**octave)).flatten(-2)
    return torch.cat([angle.sin(), angle.cos()], dim=-1)
