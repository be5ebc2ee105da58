"""Initial layout and hierarchy embedding: from the noisy channels of an object to its token.

The network sees a layout twice: as the noisy channels, and as the boxes in the world that the
channels stand for. Of the boxes their faces matter, since a wall ends where another begins and a
bed stands against one. Both come as Fourier features, in which equal places have equal vectors and
small differences are large. A wave that is shorter than the doubt about its value is only noise. It
fades: its mean over that doubt remains (Barron et al. 2021, "Mip-NeRF", section 3.1).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.model.config import N_GEOMETRY, ModelCfg
from aeroscene.learning.model.encoding import sinusoid
from aeroscene.learning.paper.guidance.layout import Layout

LONGEST_M = 128.0
"""Longest wavelength of a face's Fourier features; each further band halves it."""
_LONGEST = 16.0
"""Longest wavelength of a channel's Fourier features, in spreads."""
_N_ALIKE = 64
"""Number of slots of one category with a vector of their own; later ones share the last."""
_N_TURNS = 4
_N_FACES = 6
_N_SHAPE = 7
"""Numbers of the heading (2), of the log extents (3) and of the frame's log half extents (2)."""
_FACES_M = 8.0
"""Scale by which faces are divided, beside their waves."""
_MOST = 6.0
"""Channels are clipped at so many spreads, because an object may differ from all in training."""
_PLACE_SCALE = 0.1
"""Factor on e_pos. Unscaled, keys and values would consist mostly of the index."""


class Seen(NamedTuple):
    """A noisy layout, and the clean layout that a formula without parameters finds in it."""

    x: Float[Tensor, "batch n c"]
    """Noisy channels, divided to unit variance."""
    clean: Float[Tensor, "batch n c"]
    """Clean channels by the formula, in spreads."""
    doubt: Float[Tensor, "batch n c"]
    """Standard deviations of the clean channels about the truth."""
    boxes: Layout
    """Boxes of the clean channels."""
    faces_doubt_m: Float[Tensor, "batch n 6"]
    """Standard deviations of the faces of these boxes."""


class Embedded(NamedTuple):
    """The paper's token and its summands."""

    feature: Float[Tensor, "batch n d"]
    """f^(0), geometry and semantics alone; the routing reads it."""
    token: Float[Tensor, "batch n d"]
    """h = f^(0) + e_pos + e_dom, plus the time."""
    place: Float[Tensor, "batch n d"]
    """e_pos: the place in the list, and the learned slot among objects of the category."""


class LayoutEmbedding(nn.Module):
    """The paper's h_i = f_i^(0) + e_i^pos + e_i^dom with f_i^(0) = MLP([p, q, s, Emb(c)]).

    The category and its quarter turn are given: "a one-hot vector which conditioned as learned
    soft-embeddings". The contents of a region are given too, so that a room is made for its
    furniture. The place i is counted among real tokens. Beside its sinusoid stand learned vectors
    for the k-th object of a category that faces one way, from the first and from the last. Where
    all is noise, nothing else tells the four walls of a room from each other.
    """

    def __init__(self, cfg: ModelCfg, *, has_regions: bool) -> None:
        super().__init__()
        self.width, self.bands = cfg.width, cfg.fourier_bands
        self.category = nn.Embedding(1 + cfg.n_categories, cfg.width)
        self.turn = nn.Embedding(_N_TURNS, cfg.width)
        n_held = 1 + cfg.n_categories
        self.held = nn.Linear(n_held, cfg.width, bias=False) if has_regions else None
        n_waves = 2 * cfg.fourier_bands * (_N_FACES + N_GEOMETRY)
        self.mlp = nn.Sequential(
            nn.Linear(N_GEOMETRY + n_waves + _N_FACES + _N_SHAPE + cfg.width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.width),
        )
        self.domain = nn.Embedding(cfg.n_domains, cfg.width)
        self.from_first = nn.Embedding(_N_ALIKE, cfg.width)
        self.from_last = nn.Embedding(_N_ALIKE, cfg.width)

    def forward(self, seen: Seen, time: Float[Tensor, "batch n d"], batch: TokenBatch) -> Embedded:
        """Embed a noisy layout.

        Args:
            seen: The layout, as channels and as boxes.
            time: Embedded time of each token.
            batch: Categories, turns, frames and contents of regions.
        """
        assert batch.turn is not None
        assert batch.frame is not None
        assert batch.held is not None
        known = self.category(batch.kind) + self.turn(batch.turn)
        if self.held is not None:
            known = known + self.held(batch.held.log1p())
        boxes = seen.boxes
        faces = faces_m(boxes)
        parts = [
            seen.x.clamp(-_MOST, _MOST),
            faces / _FACES_M,
            fourier(faces, seen.faces_doubt_m, LONGEST_M, self.bands),
            fourier(seen.clean, seen.doubt, _LONGEST, self.bands),
            boxes.heading,
            boxes.size_m.log(),
            batch.frame[..., 5:7].log(),
            known,
        ]
        # In bfloat16 a place of one spread would be off by half a hundredth, so the first layer
        # runs in single precision.
        with torch.autocast(seen.x.device.type, enabled=False):
            feature = self.mlp(torch.cat(parts, dim=-1).float())
        place = _PLACE_SCALE * sinusoid(batch.mask.cumsum(1) - 1, self.width)
        before, after = among_alike(batch)
        place = place + self.from_first(before) + self.from_last(after)
        token = feature + place + time + self.domain(batch.domain).unsqueeze(1)
        return Embedded(feature, token, place)


def among_alike(batch: TokenBatch) -> tuple[Int[Tensor, "batch n"], Int[Tensor, "batch n"]]:
    """Count the objects of each one's category, turn and region that come before and after it."""
    assert batch.turn is not None
    same = batch.mask.unsqueeze(1)
    for known in (batch.kind, batch.turn, batch.parent):
        same = same & (known.unsqueeze(2) == known.unsqueeze(1))
    before, after = (side.sum(-1).clamp(max=_N_ALIKE - 1) for side in (same.tril(-1), same.triu(1)))
    return before, after


def level_extent_m(boxes: Layout) -> Float[Tensor, "batch n 3"]:
    """Extents of the upright boxes along east, north and up."""
    cos, sin = boxes.heading.abs().unbind(-1)
    x, y, z = boxes.size_m.unbind(-1)
    return torch.stack([cos * x + sin * y, sin * x + cos * y, z], dim=-1)


def faces_m(boxes: Layout) -> Float[Tensor, "batch n 6"]:
    """Faces of each box along east, north and up: the lower three, then the upper three."""
    half = level_extent_m(boxes) / 2
    return torch.cat([boxes.center_enu_m - half, boxes.center_enu_m + half], dim=-1)


def fourier(
    value: Float[Tensor, "batch n k"],
    doubt: Float[Tensor, "batch n k"],
    longest: float,
    bands: int,
) -> Float[Tensor, "batch n f"]:
    """Mean sines and cosines of values that are known up to normal doubts, by band.

    Args:
        value: The values.
        doubt: Standard deviation of each value.
        longest: Length of the first wave; each further one is half as long.
        bands: Number of waves.
    """
    octave = torch.arange(bands, device=value.device, dtype=torch.float32)
    rate = 2 * math.pi / longest * 2.0**octave
    angle = (value.unsqueeze(-1) * rate).flatten(-2)
    # Mean of a wave over a normal distribution: exp(-(rate sigma)^2 / 2) of the wave at its middle.
    left = (-0.5 * (doubt.unsqueeze(-1) * rate).square()).exp().flatten(-2)
    return torch.cat([left * angle.sin(), left * angle.cos()], dim=-1)
