"""How far units keep from others of their category, as in training.

No two boxes have to overlap for a pair to be absurd: two street lamps a hand apart, one fence
beside another. What a category keeps free ahead and beside is read off scenes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from aeroscene.scene import OrientedBox

_SHARE = 0.05
"""Share of the units in training that stand nearer than what a category is said to keep."""
_LEAST_COUNT = 20
"""Categories with fewer units beside others keep nothing."""
_MOST_M = 3.0
_BESIDE_M = 0.01
"""Boxes are ahead of each other where their widths share more than this."""


@dataclass(frozen=True, slots=True)
class Clearances:
    """Metres between boxes of different units of a category: ahead of one, and beside it."""

    by_category: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def of(self, category: str) -> tuple[float, float]:
        """Those of a category; 0 of one that keeps nothing."""
        return self.by_category.get(category, (0.0, 0.0))


NO_CLEARANCES = Clearances()


def measure_clearances(
    gaps_by_scene: Sequence[Mapping[str, Float[np.ndarray, "k 2"]]],
) -> Clearances:
    """What categories keep, by what `gaps_between` finds in scenes."""
    rows: defaultdict[str, list[np.ndarray]] = defaultdict(list)
    for gaps in gaps_by_scene:
        for category, found in gaps.items():
            rows[category].append(found)
    kept = {category: _kept_m(np.concatenate(found)) for category, found in rows.items()}
    return Clearances(
        {category: kept[category] for category in sorted(kept) if any(kept[category])}
    )


def gaps_between(units: Sequence[Sequence[OrientedBox]]) -> Float[np.ndarray, "k 2"]:
    """The gap from each box to the next of another unit ahead of or behind it, and beside it.

    Args:
        units: The boxes of each unit of one category, (x, y, z) in metres, ENU.

    Returns:
        Metres for each box in turn; NaN where there is nothing on its level.
    """
    boxes = [box for unit in units for box in unit]
    unit = np.repeat(np.arange(len(units)), [len(each) for each in units])
    centre, half = np.array([box.p for box in boxes]), np.array([box.s for box in boxes]) / 2
    yaw_rad = np.array([box.yaw_rad for box in boxes])
    gaps = np.full((len(boxes), 2), np.nan)
    for row in range(len(boxes)):
        is_level = np.abs(centre[:, 2] - centre[row, 2]) < half[:, 2] + half[row, 2]
        others = (unit != unit[row]) & is_level
        away = centre[others, :2] - centre[row, :2]
        c, s = np.cos(yaw_rad[row]), np.sin(yaw_rad[row])
        lean, slant = (
            np.abs(np.cos(yaw_rad[others] - yaw_rad[row])),
            np.abs(np.sin(yaw_rad[others] - yaw_rad[row])),
        )
        x, y = half[others, 0], half[others, 1]
        ahead = np.abs(away @ (c, s)) - half[row, 0] - lean * x - slant * y
        beside = np.abs(away @ (-s, c)) - half[row, 1] - slant * x - lean * y
        for column, gap, other in ((0, ahead, beside), (1, beside, ahead)):
            facing = gap[other < -_BESIDE_M]
            gaps[row, column] = facing.min() if len(facing) else np.nan
    return gaps


def _kept_m(gaps: Float[np.ndarray, "k 2"]) -> tuple[float, float]:
    known = [column[~np.isnan(column)] for column in gaps.T]
    ahead, beside = (
        float(np.quantile(column, _SHARE).clip(0.0, _MOST_M))
        if len(column) >= _LEAST_COUNT
        else 0.0
        for column in known
    )
    return ahead, beside
