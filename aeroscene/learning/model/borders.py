"""Where the borders of noisy boxes are, in the frames of their parents and in the world.

Things meet at borders: rooms tile a building, shelves stand along a wall, a pavement follows a
road. A network that is given centres and log extents must learn to add and multiply before it can
see that two borders coincide; here they are given, with Fourier features that tell centimetres
from metres.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.model.encoding import fourier_features
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes, footprints_of

_BANDS = 7
"""Octaves of a border: the last one turns over 1/32 of half the parent's extent."""
_WORLD_BANDS = 6
_SITE_M = 40.0
"""Places in the world are in this unit: about half the side of a site."""
_LIMIT = 2.0
"""Largest border or place in its unit: noise may ask for anything."""
_EXTENTS_M = (0.01, 300.0)
_PLAY_M = (0.01, 100.0)
N_BORDER_FEATURES = 4 + 8 * _BANDS + 2 + 4 * _WORLD_BANDS + 2 + 3 + 2


def border_features(boxes: Boxes, batch: TokenBatch) -> Float[Tensor, "batch n f"]:
    """Borders in units of half the parent's extent, places, headings and log extents."""
    outlines = footprints_of(boxes, batch)
    half = outlines.parent_half_m.clamp(*_EXTENTS_M)
    low, high = outlines.middle_m - outlines.reach_m, outlines.middle_m + outlines.reach_m
    borders = _tamed(torch.cat([low / half, high / half], dim=-1), _LIMIT)
    place = _tamed(boxes.center_enu_m[..., :2] / _SITE_M, _LIMIT)
    return torch.cat(
        [
            borders,
            fourier_features(borders, _BANDS),
            place,
            fourier_features(place, _WORLD_BANDS),
            boxes.heading,
            boxes.size_m.clamp(*_EXTENTS_M).log(),
            boxes.play_m.clamp(*_PLAY_M).log(),
        ],
        dim=-1,
    )


def _tamed(value: Tensor, limit: float) -> Tensor:
    return value.nan_to_num(0.0).clamp(-limit, limit)
