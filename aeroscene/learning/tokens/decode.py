"""Decoding of channels to boxes in the world, differentiable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes, Footprints
from aeroscene.learning.tokens.channels import (
    HEADING,
    HEIGHT,
    LEAST_PLAY,
    OPENING,
    PLACE,
    SITE_HEIGHT_M,
    SIZE,
)
from aeroscene.learning.tokens.codec import DEFAULT_CODEC
from aeroscene.learning.tokens.kinds import OPENINGS, Vocabulary
from aeroscene.learning.tokens.recoding import default_channels
from aeroscene.learning.tokens.statistics import Statistics

_OFFSETS = (OPENINGS.index("door_offset_m"), OPENINGS.index("window_offset_m"))


class TreeDecoder:
    """The statistics of a corpus as tensors, and the way from channels to boxes."""

    def __init__(
        self, vocabulary: Vocabulary, statistics: Statistics, device: torch.device | str = "cpu"
    ) -> None:
        def tensor(values: np.ndarray) -> Tensor:
            dtype = torch.bool if values.dtype == bool else torch.float32
            return torch.as_tensor(values, dtype=dtype, device=device)

        self._codec = statistics.codec
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
        flags = self._is_relative[kind], self._is_aligned[kind]
        if self._codec != DEFAULT_CODEC:
            values = default_channels(
                values, self._codec, batch, lambda default: place_boxes(default, *flags, batch)
            )
        boxes = place_boxes(values, *flags, batch)
        return replace(
            boxes,
            play_m=boxes.play_m * spread[..., PLACE],
            rise_m=boxes.rise_m * spread[..., HEIGHT].squeeze(-1),
        )

    def with_footprints(
        self,
        x0: Float[Tensor, "batch n 15"],
        batch: TokenBatch,
        before: Footprints,
        after: Footprints,
    ) -> Float[Tensor, "batch n 15"]:
        """Channels of the same layout with other outlines, where places and extents are free."""
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
        self, x0: Float[Tensor, "batch n 15"], batch: TokenBatch, ratio: Float[Tensor, "batch n"]
    ) -> Float[Tensor, "batch n 15"]:
        """Channels of the same layout with heights times a ratio, where those are free."""
        height = SIZE.stop - 1
        kind = batch.kind
        grown = x0[..., height] + ratio.log() / self._spread[kind][..., height]
        values = x0.clone()
        values[..., height] = torch.where(self._is_free[kind][..., height], grown, x0[..., height])
        return values

    def has_free_extents(self, batch: TokenBatch) -> Bool[Tensor, "batch n"]:
        """Which tokens are of kinds whose length and width both vary."""
        return self._is_free[batch.kind][..., SIZE.start : SIZE.start + 2].all(-1)

    def least_extents_m(self) -> Float[Tensor, "kinds 2"]:
        """Shortest length and width of each kind in training, 0 where they are relative."""
        extents = slice(SIZE.start, SIZE.start + 2)
        log_m = (self._mean + self._low * self._spread)[:, extents]
        return torch.where(self._is_relative[:, :2], torch.zeros_like(log_m), log_m.exp())

    def is_aligned(self, batch: TokenBatch) -> Bool[Tensor, "batch n"]:
        """Which tokens stand square to their parents."""
        return self._is_aligned[batch.kind]


def place_boxes(
    values: Float[Tensor, "batch n 15"],
    is_relative: Bool[Tensor, "batch n 3"],
    is_aligned: Bool[Tensor, "batch n"],
    batch: TokenBatch,
) -> Boxes:
    """Boxes of channels that are not standardised; play and rise for one unit of those.

    Extents that are relative are ratios to the parent's; aligned tokens stand square to theirs.
    """
    relative = _headings(values[..., HEADING], is_aligned)
    relative = torch.where((batch.depth == 0)[..., None], _site_heading(values), relative)
    return _Tree(batch, values, relative, is_relative).place()


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

    def place(self) -> Boxes:
        """All boxes: sizes and headings from above to below, then places."""
        is_below = (self._batch.depth > 0)[..., None]
        size, heading = self._sizes_and_headings()
        parent_size = size.gather(1, self._gather3)
        lift, rise = self._lifts(parent_size[..., 2])
        play = self._play(size, parent_size)
        turned = _turn(self._values[..., PLACE] * play, heading.gather(1, self._gather2))
        foot = self._summed(torch.cat([turned, lift[..., None]], dim=-1) * is_below)
        openings = self._values[..., OPENING].clone()
        openings[..., _OFFSETS] = openings[..., _OFFSETS] * size[..., 1:2] / 2
        return Boxes(
            torch.cat([foot[..., :2], foot[..., 2:] + size[..., 2:] / 2], dim=-1),
            heading,
            size,
            torch.where(is_below, play, torch.ones_like(play)),
            rise,
            openings,
            self._batch.mask,
        )

    def _levels(self) -> list[Tensor]:
        """Which tokens are at each depth, from 1."""
        depth = self._batch.depth[..., None]
        return [depth == level for level in range(1, int(depth.max()) + 1)]

    def _sizes_and_headings(self) -> tuple[Tensor, Tensor]:
        ratio = torch.exp(self._values[..., SIZE])
        cos, sin = self._relative.abs().unbind(-1)
        size, heading = ratio, self._relative
        for here in self._levels():
            px, py, pz = size.gather(1, self._gather3).unbind(-1)
            along = torch.stack([cos * px + sin * py, sin * px + cos * py, pz], dim=-1)
            size = torch.where(here & self._is_relative, ratio * along, size)
            turned = _turn(self._relative, heading.gather(1, self._gather2))
            heading = torch.where(here, turned, heading)
        return size, heading

    def _play(self, size: Tensor, parent_size: Tensor) -> Tensor:
        """How far from the middle of its parent each may be, along its axes."""
        cos, sin = self._relative.abs().unbind(-1)
        sx, sy, _ = size.unbind(-1)
        reach = torch.stack([cos * sx + sin * sy, sin * sx + cos * sy], dim=-1) / 2
        half = parent_size[..., :2] / 2
        return torch.maximum(half - reach, LEAST_PLAY * half)

    def _lifts(self, parent_height: Tensor) -> tuple[Tensor, Tensor]:
        """Undersides above the parents', and what one unit of the channel adds to them."""
        batch = self._batch
        unit = torch.where(batch.depth == 1, SITE_HEIGHT_M, parent_height)
        is_given = ~batch.lift_m.isnan()
        lift = torch.where(is_given, batch.lift_m, self._values[..., HEIGHT].squeeze(-1) * unit)
        lift = torch.where(batch.stands_on_top, parent_height, lift)
        return lift, torch.where(is_given | batch.stands_on_top, 0.0, unit)

    def _summed(self, step: Tensor) -> Tensor:
        """Steps from parents to children, added up from the site."""
        total = step
        for here in self._levels():
            total = torch.where(here, step + total.gather(1, self._gather3), total)
        return total


def _site_heading(values: Tensor) -> Tensor:
    """Heading of a ground plan, whose channels have four times its yaw."""
    cos, sin = values[..., HEADING].unbind(-1)
    yaw = torch.atan2(sin, cos) / 4
    return torch.stack([yaw.cos(), yaw.sin()], dim=-1)


def _turn(vector: Tensor, heading: Tensor) -> Tensor:
    x, y = vector.unbind(-1)
    c, s = heading.unbind(-1)
    return torch.stack([c * x - s * y, s * x + c * y], dim=-1)
