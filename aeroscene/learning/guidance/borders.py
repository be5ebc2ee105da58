"""Borders that meet: coarse neighbours that stand square to each other share a border exactly.

Rooms tile a building between walls, a pavement follows a road. A sampled border is off by
decimetres: no push can mend that, since tiles fill what they tile. Here the borders themselves
move, late in the sampling and on predicted x0: what overlaps by little gives way on both sides,
what leaves as little a gap closes it. Walls, stairs and whatever has a size of its own move as a
whole, and so does what is as narrow as its kind can be. The paper has nothing of the kind; its
collision objective also acts on s_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.diffusion.sampling import Guidance, Moment
from aeroscene.learning.diffusion.schedule import require_within
from aeroscene.learning.guidance.containment import contained
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes, Footprints, footprints_of
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.scene.catalogue import by_name

_COVERS = frozenset({"lawn", "plaza", "parking_lot", "road", "sidewalk", "terrain", "water"})
_TILES = _COVERS | {"room", "floor"}
"""Categories that fill the place between their neighbours: their extents give way."""
_PARTS = frozenset({"room", "floor", "wall"})
"""Categories that lie wholly within the building that they are a part of."""
_UPRIGHTS = frozenset({"room", "wall"})
_SLABS = frozenset({"floor", "roof"})
"""Categories that limit the height of those parts."""
_LEAST_HEIGHT_M = 0.005
"""Boxes that share less height than this do not meet."""


@dataclass(frozen=True, kw_only=True)
class BordersCfg:
    """Settings of the guidance that makes borders meet."""

    late_share: float = 0.3
    """Share of the sampling steps, the last ones, at which borders move."""
    n_steps: int = 12
    """Iterations at each of them."""
    last_n_steps: int = 40
    """At the last one."""
    most_overlap_m: float = 8.0
    """Deeper overlaps are no error of a border: they are left to separation."""
    most_gap_m: float = 0.5
    """Wider gaps are meant."""
    most_rise_m: float = 1.0
    """Walls and rooms that reach farther into the slab above them are left as they are."""
    least_share: float = 0.4
    """No extent shrinks below this share of what was sampled, nor below the least of its kind."""

    def __post_init__(self) -> None:
        require_within("borders", self, (0, 1), "late_share")
        require_within("borders", self, (0, 1000), "n_steps", "last_n_steps")
        require_within("borders", self, (0, 100), "most_overlap_m", "most_gap_m", "most_rise_m")
        require_within("borders", self, (0.1, 1), "least_share")


class BorderGuidance:
    """Brings the borders of coarse neighbours together in the predicted clean layout."""

    def __init__(
        self,
        decoder: TreeDecoder,
        vocabulary: Vocabulary,
        device: torch.device | str = "cpu",
        cfg: BordersCfg | None = None,
    ) -> None:
        def flags(names: frozenset[str]) -> Tensor:
            return torch.tensor([k.category in names for k in vocabulary.kinds], device=device)

        self._decoder = decoder
        self._is_tile, self._is_cover, self._is_part = map(flags, (_TILES, _COVERS, _PARTS))
        self._is_upright, self._is_slab = map(flags, (_UPRIGHTS, _SLABS))
        self._is_wall, self._is_room = flags(frozenset({"wall"})), flags(frozenset({"room"}))
        self._least_m = _least_extents_m(self._is_tile, decoder, vocabulary)
        self.cfg = cfg or BordersCfg()

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """The layout with its borders brought together."""
        if at.share_left > self.cfg.late_share and not at.is_last:
            return x0
        boxes = self._decoder.decode(x0, batch)
        before = footprints_of(boxes, batch)
        faces = self._faces(boxes, before, batch, at)
        after = faces.moved(self.cfg.last_n_steps if at.is_last else self.cfg.n_steps)
        moved = self._decoder.with_footprints(x0, batch, before, after)
        boxes = self._decoder.decode(moved, batch)
        before = footprints_of(boxes, batch)
        # Extents that are relative have followed those of their parents.
        after = contained(
            self._long_enough(before, batch, at), boxes, batch, self._is_part[batch.kind]
        )
        moved = self._decoder.with_footprints(moved, batch, before, after)
        boxes = self._decoder.decode(moved, batch)
        lowered = self._lowered(boxes, footprints_of(boxes, batch), batch)
        return self._decoder.with_heights(moved, batch, lowered)

    def on_mean(self, mean: Tensor, x_t: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Nothing: the layout was moved where it was clean."""
        return mean

    def _lowered(
        self, boxes: Boxes, footprints: Footprints, batch: TokenBatch
    ) -> Float[Tensor, "batch n"]:
        """New heights over old ones: walls and rooms end under the slab or roof above them."""
        n = batch.n_coarse_slots
        kind, parent = batch.kind[:, :n], batch.parent[:, :n]
        middle, reach = footprints.middle_m[:, :n], footprints.reach_m[:, :n]
        apart = (middle[:, :, None] - middle[:, None]).abs()
        shares = (reach[:, :, None] + reach[:, None] - apart > _LEAST_HEIGHT_M).all(-1)
        half = boxes.size_m[:, :n, 2] / 2
        low, high = boxes.center_enu_m[:, :n, 2] - half, boxes.center_enu_m[:, :n, 2] + half
        rise = high[:, :, None] - low[:, None]
        meets = shares & (parent[:, :, None] == parent[:, None]) & batch.mask[:, None, :n]
        meets &= self._is_upright[kind][:, :, None] & self._is_slab[kind][:, None]
        meets &= (rise > 0) & (rise < self.cfg.most_rise_m) & (low[:, :, None] < low[:, None])
        excess = (rise * meets).amax(-1)
        ratio = torch.ones_like(boxes.size_m[..., 2])
        ratio[:, :n] = (1 - excess / (high - low).clamp_min(_LEAST_HEIGHT_M)).clamp_min(0.5)
        return ratio

    def _faces(self, boxes: Boxes, footprints: Footprints, batch: TokenBatch, at: Moment) -> _Faces:
        n = batch.n_coarse_slots
        kind, parent = batch.kind[:, :n], batch.parent[:, :n]
        may = (batch.mask & self._decoder.is_aligned(batch) & (batch.depth > 0))[:, :n]
        if at.fixed is not None:
            may = may & ~at.fixed[:, :n]
        siblings = parent[:, :, None] == parent[:, None, :]
        siblings &= may[:, :, None] & may[:, None, :]
        siblings &= ~torch.eye(n, dtype=torch.bool, device=may.device)
        half = boxes.size_m[:, :n, 2] / 2
        low, high = boxes.center_enu_m[:, :n, 2] - half, boxes.center_enu_m[:, :n, 2] + half
        shared = torch.minimum(high[:, :, None], high[:, None]) - torch.maximum(
            low[:, :, None], low[:, None]
        )
        siblings &= shared > _LEAST_HEIGHT_M
        is_cover, is_wall, is_room = (
            flags[kind] for flags in (self._is_cover, self._is_wall, self._is_room)
        )
        attracts = is_cover[:, :, None] & is_cover[:, None]
        attracts |= is_wall[:, :, None] & (is_wall | is_room)[:, None]
        attracts |= (is_wall | is_room)[:, :, None] & is_wall[:, None]
        elastic = self._is_tile[kind] & self._decoder.has_free_extents(batch)[:, :n]
        least = 2 * self.cfg.least_share * footprints.reach_m
        least = torch.maximum(least, self._least_of(footprints, batch))[:, :n]
        return _Faces(footprints, siblings, siblings & attracts, elastic & may, least, self.cfg)

    def _long_enough(self, outlines: Footprints, batch: TokenBatch, at: Moment) -> Footprints:
        """The outlines, where they may change, at least as long and wide as their kinds are."""
        reach = torch.maximum(outlines.reach_m, self._least_of(outlines, batch) / 2)
        if at.fixed is not None:
            reach = torch.where(at.fixed[..., None], outlines.reach_m, reach)
        return replace(outlines, reach_m=reach)

    def _least_of(self, footprints: Footprints, batch: TokenBatch) -> Float[Tensor, "batch n 2"]:
        """Shortest extents of tiles along the axes of their parents, 0 where none is square."""
        least = self._least_m[batch.kind] * self._decoder.is_aligned(batch)[..., None]
        return torch.where(footprints.is_crosswise[..., None], least.flip(-1), least)


def _least_extents_m(
    is_tile: Bool[Tensor, " kinds"], decoder: TreeDecoder, vocabulary: Vocabulary
) -> Float[Tensor, "kinds 2"]:
    """Shortest length and width of each kind of tiles: in training; where relative, known ones."""
    least = decoder.least_extents_m()
    for k, kind in enumerate(vocabulary.kinds):
        if is_tile[k]:
            category = by_name()[kind.category]
            known = least.new_tensor((category.length_m[0], category.width_m[0]))
            least[k] = torch.where(least[k] > 0, least[k], known)
    return least * is_tile[:, None]


@dataclass(frozen=True)
class _Faces:
    """Lower and upper borders of coarse tokens along both axes of their parents."""

    footprints: Footprints
    meets: Bool[Tensor, "batch c c"]
    """Siblings that share height."""
    attracts: Bool[Tensor, "batch c c"]
    """Siblings that close a small gap."""
    is_elastic: Bool[Tensor, "batch c"]
    least_m: Float[Tensor, "batch c 2"]
    """Shortest extents along the parent's axes."""
    cfg: BordersCfg

    def moved(self, n_steps: int) -> Footprints:
        """The outlines after some iterations; the last third only undoes overlaps."""
        n = self.meets.shape[1]
        first = self.footprints
        middle, reach = first.middle_m[:, :n], first.reach_m[:, :n]
        low, high = middle - reach, middle + reach
        for step in range(n_steps):
            closes = step < 2 * n_steps // 3
            low, high = self._step(low, high, closes=closes)
        middles, reaches = first.middle_m.clone(), first.reach_m.clone()
        middles[:, :n], reaches[:, :n] = (low + high) / 2, (high - low) / 2
        return replace(first, middle_m=middles, reach_m=reaches)

    def _step(self, low: Tensor, high: Tensor, *, closes: bool) -> tuple[Tensor, Tensor]:
        """One Jacobi iteration: every border goes half of the way that its neighbours ask for."""
        # [b, i, j, axis]: by how much i reaches beyond the border of j that it faces.
        above = high[:, :, None] - low[:, None]
        below = high[:, None] - low[:, :, None]
        faces_up = (low + high)[:, :, None] < (low + high)[:, None]
        overlap = torch.where(faces_up, above, below)
        along = self._facing_axis(overlap)
        asks = self.meets[..., None] & along & (overlap > 0) & (overlap < self.cfg.most_overlap_m)
        if closes:
            near = (overlap <= 0) & (overlap > -self.cfg.most_gap_m)
            asks |= self.attracts[..., None] & along & near
        share = self._share()[..., None] * overlap * asks
        count_up = (asks & faces_up).sum(2).clamp_min(1)
        count_down = (asks & ~faces_up).sum(2).clamp_min(1)
        up = (share * faces_up).sum(2) / count_up
        down = (share * ~faces_up).sum(2) / count_down
        elastic = self.is_elastic[..., None]
        whole = (down - up) / 2
        new_high = high - torch.where(elastic, up, -whole)
        new_low = low + torch.where(elastic, down, whole)
        return self._long_enough(new_low, new_high, down, up)

    def _long_enough(
        self, low: Tensor, high: Tensor, down: Tensor, up: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Borders of tiles moved apart to their least extents, away from what pushes more."""
        lack = (self.least_m - (high - low)).clamp_min(0) * self.is_elastic[..., None]
        from_above, from_below = up.clamp_min(1e-6), down.clamp_min(1e-6)
        share = from_above / (from_above + from_below)
        return low - lack * share, high + lack * (1 - share)

    @staticmethod
    def _facing_axis(overlap: Tensor) -> Bool[Tensor, "batch c c 2"]:
        """The axis along which two neighbours meet: they overlap along the other one, and more."""
        u, v = overlap.unbind(-1)
        return torch.stack([(u <= v) & (v > 0), (v < u) & (u > 0)], dim=-1)

    def _share(self) -> Float[Tensor, "batch c c"]:
        """Part of an overlap that falls to the first of two; what has its own size yields less."""
        weight = torch.where(self.is_elastic, 1.0, 0.25)
        return weight[:, :, None] / (weight[:, :, None] + weight[:, None])


class GuidanceChain:
    """Several guidances, one after the other."""

    def __init__(self, parts: Sequence[Guidance]) -> None:
        self._parts = parts

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """The layout after all of them."""
        for part in self._parts:
            x0 = part.on_x0(x0, batch, at)
        return x0

    def on_mean(self, mean: Tensor, x_t: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """The mean after all of them."""
        for part in self._parts:
            mean = part.on_mean(mean, x_t, batch, at)
        return mean
