"""Things that stand in line: siblings that nearly share a line come to share it.

Shelves stand in rows, panels in grids, a chair before the middle of its desk: exactly so in the
corpus, nearly so in what a network predicts. Late in the sampling, and on predicted x0, siblings
square to their parent whose middles nearly have one coordinate along an axis of it get that
coordinate, the mean weighted by their areas. It runs before separation, which parts what this
brings together, along the line since that is the shorter way. The paper has nothing of the kind.

Which pairs have the habit was counted in the corpus, see `_IN_LINE_PERCENT`. There it is mostly
all or nothing: of nearest siblings of one category less than 30 cm off a common line, 92 to 100%
are within 2 cm of it for benches, shelves, cars, planters, bicycles, barrels, panels and lamps, but
77% for chairs. It mends lines, not distances: semantic plausibility, which counts those in wide
bins, stays as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import require_within
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Footprints, footprints_of
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.kinds import Vocabulary

_IN_LINE_PERCENT: Mapping[str, Mapping[str, int]] = {
    "ac_unit": {"ac_unit": 93},
    "armchair": {"armchair": 88, "coffee_table": 78, "lamp": 21},
    "barrel": {"barrel": 86},
    "bench": {"bench": 66, "table": 83},
    "bicycle": {"bicycle": 89},
    "bin": {"bin": 58, "kiosk": 27},
    "book": {"laptop": 99},
    "box": {"box": 96, "cup": 99},
    "bus": {"car": 21},
    "bush": {"kiosk": 73},
    "cabinet": {"cabinet": 42},
    "car": {"car": 75, "van": 82},
    "chair": {"chair": 71, "desk": 96, "table": 44},
    "coffee_table": {"sofa": 93},
    "container": {"container": 75},
    "counter": {"counter": 51, "fridge": 83, "stove": 100},
    "crate": {"crate": 26},
    "cup": {"cup": 24, "cutlery": 31},
    "cutlery": {"plate": 100},
    "desk": {"desk": 61},
    "fridge": {"fridge": 92},
    "kiosk": {"tree": 37},
    "lamp": {"sofa": 81},
    "landing_pad": {"landing_pad": 64},
    "laptop": {"monitor": 100},
    "nightstand": {"nightstand": 100},
    "pallet": {"pallet": 83},
    "plant": {"plant": 25},
    "planter": {"planter": 66, "table": 33},
    "plate": {"plate": 98},
    "shelf": {"shelf": 96},
    "sign": {"sign": 55},
    "solar_panel": {"solar_panel": 100},
    "street_lamp": {"street_lamp": 99},
    "table": {"table": 60},
    "van": {"van": 55},
    "wardrobe": {"wardrobe": 100},
}
"""Percent of the objects with such a sibling that are within 2 cm of a line with the nearest.

Counted in the 812 training scenes, the more frequent one of both directions; all pairs of at least
90 objects and 20%, but for tiles, walls and what else `aeroscene.learning.guidance.borders` moves.
"""


@dataclass(frozen=True, kw_only=True)
class AlignmentCfg:
    """Settings of the alignment of siblings."""

    late_share: float = 0.5
    """Share of the sampling steps, the last ones, at which siblings are aligned."""
    most_m: float = 1.0
    """Distance from a line beyond which an object is not meant to be in it."""
    most_share: float = 0.8
    """That distance as a share of the smaller one's extent across the line."""
    reach_m: float = 6.0
    """Siblings farther apart than this along a line do not make one."""

    def __post_init__(self) -> None:
        require_within("alignment", self, (0, 1), "late_share", "most_share")
        require_within("alignment", self, (0, 100), "most_m")
        require_within("alignment", self, (0, 1000), "reach_m")


class AlignmentGuidance:
    """Brings siblings in line in the predicted clean layout."""

    def __init__(
        self, decoder: TreeDecoder, vocabulary: Vocabulary, cfg: AlignmentCfg | None = None
    ) -> None:
        names, category = np.unique([k.category for k in vocabulary.kinds], return_inverse=True)
        habit = [[_has_habit(first, second) for second in names] for first in names]
        self._habit = np.array(habit, dtype=bool)
        self._category = category
        self._decoder = decoder
        self.cfg = cfg or AlignmentCfg()

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """The layout with its siblings in line."""
        if at.share_left > self.cfg.late_share and not at.is_last:
            return x0
        before = footprints_of(self._decoder.decode(x0, batch), batch)
        after = replace(before, middle_m=self._aligned(before, batch, at).to(before.middle_m))
        return self._decoder.with_footprints(x0, batch, before, after)

    def on_mean(self, mean: Tensor, x_t: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Nothing: the layout was moved where it was clean."""
        return mean

    def _aligned(
        self, outlines: Footprints, batch: TokenBatch, at: Moment
    ) -> Float[Tensor, "batch n 2"]:
        """The middles after all scenes were aligned, one by one."""
        may = batch.mask & self._decoder.is_aligned(batch) & (batch.depth > 0)
        fixed = torch.zeros_like(may) if at.fixed is None else at.fixed
        tensors = (outlines.middle_m, outlines.reach_m, batch.kind, batch.parent, may, fixed)
        middle, reach, kind, parent, may, fixed = (tensor.cpu().numpy() for tensor in tensors)
        middle = middle.astype(float)
        for scene in range(len(middle)):
            some = np.flatnonzero(may[scene])
            category, above = self._category[kind[scene, some]], parent[scene, some]
            pairs = self._habit[category[:, None], category] & (above[:, None] == above)
            middle[scene, some] = in_line(
                middle[scene, some], reach[scene, some], fixed[scene, some], pairs, self.cfg
            )
        return torch.from_numpy(middle)


def in_line(
    middle_m: Float[np.ndarray, "n 2"],
    reach_m: Float[np.ndarray, "n 2"],
    is_fixed: Bool[np.ndarray, " n"],
    has_habit: Bool[np.ndarray, "n n"],
    cfg: AlignmentCfg,
) -> Float[np.ndarray, "n 2"]:
    """Where the middles of objects come that nearly share a line, in the axes of their parents.

    What is fixed stays, and the others come to its line.
    """
    first, second = np.nonzero(np.triu(has_habit, 1))
    apart = np.abs(middle_m[first] - middle_m[second])
    extent = 2 * np.minimum(reach_m[first], reach_m[second])
    limit = np.minimum(cfg.most_m, cfg.most_share * extent)
    weight = np.where(is_fixed, 1e9, reach_m.prod(axis=1) + 1e-3)
    moved = middle_m.copy()
    for axis, other in ((0, 1), (1, 0)):
        # What lies on one another would only be drawn closer.
        is_beside = (apart[:, other] > extent[:, other] / 2) & (apart[:, other] < cfg.reach_m)
        near = np.flatnonzero(is_beside & (apart[:, axis] < limit[:, axis]))
        near = near[np.argsort(apart[near, axis], kind="stable")]
        pairs = np.stack([first[near], second[near]], axis=1)
        for line in _lines(pairs, limit[near, axis], middle_m[:, axis]):
            moved[line, axis] = np.average(middle_m[line, axis], weights=weight[line])
    return np.where(is_fixed[:, None], middle_m, moved)


def _lines(
    pairs: Int[np.ndarray, "k 2"], limit_m: Float[np.ndarray, " k"], place_m: np.ndarray
) -> list[list[int]]:
    """Groups joined pair by pair, none wider than the limit of the pair that joins it."""
    groups = {i: [i] for i in pairs.ravel().tolist()}
    for (i, j), limit in zip(pairs.tolist(), limit_m.tolist(), strict=True):
        if groups[i] is groups[j]:
            continue
        both = groups[i] + groups[j]
        if np.ptp(place_m[both]) <= limit:
            groups.update(dict.fromkeys(both, both))
    return [group for i, group in groups.items() if group[0] == i and len(group) > 1]


def _has_habit(first: str, second: str) -> bool:
    known = _IN_LINE_PERCENT
    return second in known.get(first, ()) or first in known.get(second, ())
