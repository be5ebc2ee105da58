"""From channels to boxes in the world, differentiable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.tokens.batch import TokenBatch
from aeroscene.tokens.boxes import Boxes, Footprints
from aeroscene.tokens.channels import (
    HEADING,
    HEIGHT,
    LEAST_PLAY,
    OPENING,
    PLACE,
    SITE_HEIGHT_M,
    SIZE,
)
from aeroscene.tokens.kinds import OPENINGS, Vocabulary
from aeroscene.tokens.statistics import Statistics

_OFFSETS = (OPENINGS.index("door_offset_m"), OPENINGS.index("window_offset_m"))


class TreeDecoder:
    """The statistics of a corpus as tensors, and the way from channels to boxes."""

    def __init__(
        self,
        vocabulary: Vocabulary,
        statistics: Statistics,
        device: torch.device | str = "cpu",
    ) -> None:
        def tensor(values: np.ndarray) -> Tensor:
            dtype = torch.bool if values.dtype == bool else torch.float32
            return torch.as_tensor(values, dtype=dtype, device=device)

        self._mean = tensor(statistics.mean)
        self._spread = tensor(statistics.spread)
        self._low = tensor(statistics.low)
        self._high = tensor(statistics.high)
        self._is_free = tensor(statistics.is_free)
        self._is_relative = tensor(statistics.is_relative)
        self._is_aligned = tensor(np.array([kind.is_aligned for kind in vocabulary.kinds]))

    def bounds(self, batch: TokenBatch) -> tuple[Tensor, Tensor]:
        """Least and greatest value that each channel had in training, by the kind of the token."""
        return self._low[batch.kind], self._high[batch.kind]

    def decode(self, x0: Float[Tensor, "batch n 15"], batch: TokenBatch) -> Boxes:
        """Boxes in the world.

        Gradients flow to places, heights and sizes, and to headings but where a kind stands
        square to its parent: there the nearest quarter turn is taken.
        """
        kind = batch.kind
        is_free = self._is_free[kind]
        mean, spread = self._mean[kind], self._spread[kind]
        values = torch.where(is_free, x0 * spread + mean, mean)
        boxes = place_boxes(values, self._is_relative[kind], self._is_aligned[kind], batch)
        return replace(boxes, play_m=boxes.play_m * spread[..., PLACE])

    def with_footprints(
        self,
        x0: Float[Tensor, "batch n 15"],
        batch: TokenBatch,
        before: Footprints,
        after: Footprints,
    ) -> Float[Tensor, "batch n 15"]:
        """Channels of the same layout with other outlines, where places and extents are free.

        Args:
            x0: Channels.
            batch: Their tokens.
            before: The outlines that they stand for.
            after: Those that they should.
        """
        kind = batch.kind
        is_free, mean, spread = self._is_free[kind], self._mean[kind], self._spread[kind]
        place = (after.middle_m / after.play_m - mean[..., PLACE]) / spread[..., PLACE]
        ratio = (after.reach_m / before.reach_m.clamp_min(1e-6)).clamp_min(1e-3).log()
        ratio = torch.where(before.is_crosswise[..., None], ratio.flip(-1), ratio)
        extents = slice(SIZE.start, SIZE.start + 2)
        values = x0.clone()
        values[..., PLACE] = torch.where(is_free[..., PLACE], place, x0[..., PLACE])
        grown = x0[..., extents] + ratio / spread[..., extents]
        values[..., extents] = torch.where(is_free[..., extents], grown, x0[..., extents])
        return values

    def with_heights(
        self,
        x0: Float[Tensor, "batch n 15"],
        batch: TokenBatch,
        ratio: Float[Tensor, "batch n"],
    ) -> Float[Tensor, "batch n 15"]:
        """Channels of the same layout with other heights, where those are free.

        Args:
            x0: Channels.
            batch: Their tokens.
            ratio: New height over old.
        """
        height = SIZE.stop - 1
        kind = batch.kind
        grown = x0[..., height] + ratio.log() / self._spread[kind][..., height]
        values = x0.clone()
        values[..., height] = torch.where(self._is_free[kind][..., height], grown, x0[..., height])
        return values

    def has_free_extents(self, batch: TokenBatch) -> Bool[Tensor, "batch n"]:
        """Which tokens are of kinds whose length and width both vary."""
        return self._is_free[batch.kind][..., SIZE.start : SIZE.start + 2].all(-1)

    def is_aligned(self, batch: TokenBatch) -> Bool[Tensor, "batch n"]:
        """Which tokens stand square to their parents."""
        return self._is_aligned[batch.kind]


def place_boxes(
    values: Float[Tensor, "batch n 15"],
    is_relative: Bool[Tensor, "batch n 3"],
    is_aligned: Bool[Tensor, "batch n"],
    batch: TokenBatch,
) -> Boxes:
    """Boxes of channels that are not standardised; play for one unit of those.

    Args:
        values: Channels.
        is_relative: Which extents are ratios to the parent's.
        is_aligned: Which tokens stand square to their parents.
        batch: The tokens.
    """
    relative = _headings(values[..., HEADING], is_aligned)
    relative = torch.where((batch.depth == 0)[..., None], _site_heading(values), relative)
    center, heading, size, play = _Tree(batch, values, relative, is_relative).place()
    openings = values[..., OPENING].clone()
    openings[..., _OFFSETS] = openings[..., _OFFSETS] * size[..., 1:2] / 2
    return Boxes(center, heading, size, play, openings, batch.mask)


def _headings(raw: Tensor, is_aligned: Tensor) -> Tensor:
    """Unit vectors, along the nearest axis where a token stands square to its parent."""
    unit = raw / raw.norm(dim=-1, keepdim=True).clamp_min(1e-6)
    along = raw[..., :1].abs() >= raw[..., 1:].abs()
    none = torch.zeros_like(raw[..., 0])
    quarter = torch.where(
        along,
        torch.stack([raw[..., 0].sign(), none], -1),
        torch.stack([none, raw[..., 1].sign()], -1),
    )
    return torch.where(is_aligned[..., None], quarter.detach(), unit)


class _Tree:
    """Places tokens level by level, parents before children."""

    def __init__(
        self, batch: TokenBatch, values: Tensor, relative: Tensor, is_relative: Tensor
    ) -> None:
        self._batch = batch
        self._values = values
        self._relative = relative
        self._is_relative = is_relative
        place = batch.parent[..., None]
        self._gather3 = place.expand(-1, -1, 3)
        self._gather2 = place.expand(-1, -1, 2)

    def place(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Centres, headings, sizes and play of all boxes."""
        size = torch.exp(self._values[..., SIZE])
        heading = self._relative
        center = torch.cat([torch.zeros_like(size[..., :2]), size[..., 2:] / 2], dim=-1)
        play = torch.ones_like(heading)
        depth = self._batch.depth
        for level in range(1, int(depth.max()) + 1):
            here = (depth == level)[..., None]
            parent_size = size.gather(1, self._gather3)
            parent_heading = heading.gather(1, self._gather2)
            parent_center = center.gather(1, self._gather3)
            size = torch.where(here, self._sizes(size, parent_size), size)
            offset, play_here = self._offsets(size, parent_size, parent_center)
            turned = torch.cat([_turn(offset[..., :2], parent_heading), offset[..., 2:]], dim=-1)
            base = torch.cat([parent_center[..., :2], torch.zeros_like(offset[..., 2:])], dim=-1)
            center = torch.where(here, base + turned, center)
            play = torch.where(here, play_here, play)
            heading = torch.where(here, _turn(self._relative, parent_heading), heading)
        return center, heading, size, play

    def _sizes(self, size: Tensor, parent_size: Tensor) -> Tensor:
        cos, sin = self._relative.abs().unbind(-1)
        px, py, pz = parent_size.unbind(-1)
        along = torch.stack([cos * px + sin * py, sin * px + cos * py, pz], dim=-1)
        ratio = torch.exp(self._values[..., SIZE])
        return torch.where(self._is_relative, ratio * along, size)

    def _offsets(
        self, size: Tensor, parent_size: Tensor, parent_center: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Centre relative to the parent's in its axes, with the absolute height; and the play."""
        cos, sin = self._relative.abs().unbind(-1)
        sx, sy, sz = size.unbind(-1)
        reach = torch.stack([cos * sx + sin * sy, sin * sx + cos * sy], dim=-1) / 2
        half = parent_size[..., :2] / 2
        play = torch.maximum(half - reach, LEAST_PLAY * half)
        low = parent_center[..., 2] - parent_size[..., 2] / 2
        is_root = self._batch.depth == 1
        unit = torch.where(is_root, torch.full_like(low, SITE_HEIGHT_M), parent_size[..., 2])
        rise = self._values[..., HEIGHT].squeeze(-1) * unit
        lift = torch.where(self._batch.lift_m.isnan(), rise, self._batch.lift_m)
        lift = torch.where(self._batch.stands_on_top, parent_size[..., 2], lift)
        place = self._values[..., PLACE] * play
        return torch.cat([place, (low + lift + sz / 2)[..., None]], dim=-1), play


def _site_heading(values: Tensor) -> Tensor:
    """Of a ground plan, whose channels have four times its yaw."""
    cos, sin = values[..., HEADING].unbind(-1)
    yaw = torch.atan2(sin, cos) / 4
    return torch.stack([yaw.cos(), yaw.sin()], dim=-1)


def _turn(vector: Tensor, heading: Tensor) -> Tensor:
    x, y = vector.unbind(-1)
    c, s = heading.unbind(-1)
    return torch.stack([c * x - s * y, s * x + c * y], dim=-1)
