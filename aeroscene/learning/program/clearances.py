"""Distances that units keep from others of their category, as in training.

Two boxes need not overlap to look absurd: two street lamps a hand apart, or one fence beside
another. The free distance ahead of and beside a unit is therefore measured on scenes, and decoding
keeps it where there is room.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from aeroscene.scene import OrientedBox

_SHARE = 0.05
"""Share of the training units that stand nearer than the clearance of their category."""
_LEAST_COUNT = 20
"""Categories with fewer units beside others have no clearance."""
# Greatest clearance of a category.
_MOST_M = 3.0
_BESIDE_M = 0.01
"""Boxes are ahead of each other if their widths overlap by more than this."""


@dataclass(frozen=True, slots=True)
class Clearances:
    """Distances between boxes of different units of a category: ahead of one, and beside it, m."""

    by_category: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def of(self, category: str) -> tuple[float, float]:
        """Return the distances of a category; 0 for one without clearance."""
        return self.by_category.get(category, (0.0, 0.0))


NO_CLEARANCES = Clearances()


def measure_clearances(
    gaps_by_scene: Sequence[Mapping[str, Float[np.ndarray, "k 2"]]],
) -> Clearances:
    """Measure clearances from the results of `gaps_between` in many scenes."""
    rows: defaultdict[str, list[np.ndarray]] = defaultdict(list)
    for gaps in gaps_by_scene:
        for category, found in gaps.items():
            rows[category].append(found)
    kept = {category: _kept_m(np.concatenate(found)) for category, found in rows.items()}
    return Clearances(
        {category: kept[category] for category in sorted(kept) if any(kept[category])}
    )


def gaps_between(units: Sequence[Sequence[OrientedBox]]) -> Float[np.ndarray, "k 2"]:
    """Gap from each box to the next box of another unit ahead or behind, and beside it.

    Args:
        units: Boxes of each unit of one category, (x, y, z) in metres, ENU.

    Returns:
        Metres for each box in turn: ahead or behind, then beside. NaN if there is no other box at
        its height.
    """
    boxes = [box for unit in units for box in unit]
    unit = np.repeat(np.arange(len(units)), [len(each) for each in units])
    centre, half = np.array([box.p for box in boxes]), np.array([box.s for box in boxes]) / 2
    yaw_rad = np.array([box.yaw_rad for box in boxes])
    gaps = np.full((len(boxes), 2), np.nan)
    for row in range(len(boxes)):
        # Boxes on other storeys and shelves do not count.
        is_level = np.abs(centre[:, 2] - centre[row, 2]) < half[:, 2] + half[row, 2]
        others = (unit != unit[row]) & is_level
        away = centre[others, :2] - centre[row, :2]
        c, s = np.cos(yaw_rad[row]), np.sin(yaw_rad[row])
        lean, slant = (
            np.abs(np.cos(yaw_rad[others] - yaw_rad[row])),
            np.abs(np.sin(yaw_rad[others] - yaw_rad[row])),
        )
        x, y = half[others, 0], half[others, 1]
        # Negative gaps are overlaps; the quantile is clipped to 0 later.
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
