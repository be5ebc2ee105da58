"""Geometry of a layout as ten channels (p, q, s), given categories and quarter turns.

    channels  name                                        frame and unit
    0, 1      centre, east and north                      object's frame; half extents by 0.5
    2         height of the underside over the frame's    m; standardised
    3 to 6    quaternion wxyz of the heading's remainder  -; standardised
    7, 8, 9   logarithms of the full extents              -; standardised

The remainder of a heading is what its quarter turn leaves. Standardised means less the mean of the
category, divided by the spread of the category. The paper leaves the units of its x_t open. With
these the best guess from a category alone is the zero vector, so that five centimetres are visible
to the network and a chair is never drawn as large as a house.

The frame is the site's. In the progressive preset a fine object has the frame of its region, which
is known by then. The paper says that p is in R^3 and names no frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.paper.layouts import (
    IS_TWO_SIDED,
    NO_REGION,
    FlatLayout,
    quarter_turns,
)
from aeroscene.scene import DOMAINS
from aeroscene.scene.catalogue import CATALOGUE

POSITION, ROTATION, SCALE = slice(0, 3), slice(3, 7), slice(7, 10)
N_GEOMETRY = 10
N_ROWS = 1 + max(CATALOGUE)
"""Rows of a table by category number; row 0 serves padding and categories that were never seen."""

PLACE_SPREAD = 0.5
"""Spread that standardises east and north, in half extents of the frame. All categories share it,
so that noise moves all objects of a frame alike and keeps the differences between them."""
_LEAST_SPREAD = np.array([0.5, 0.5, 0.01, 0.02, 1.0, 1.0, 0.02, 0.05, 0.05, 0.05])
"""Lower bounds of the spreads: a hundredth of a metre in height, a twentieth in log size."""
_LEAST_VARIANCE = 1e-4
"""Channels that vary less are constants of their category."""
_LEAST_SEEN = 4
"""Categories with fewer objects take the spreads of all objects."""
# Yaws of training sites are kept as so many quantiles of each domain.
_N_QUANTILES = 64
LEAST_HALF_M = 0.25
"""Least half extent of a frame, because a thin wall may be a region too."""


@dataclass(frozen=True, eq=False)
class FlatStatistics:
    """Numbers that standardise the channels, one row for each category."""

    mean: Float[np.ndarray, "categories 10"]
    spread: Float[np.ndarray, "categories 10"]
    variance: Float[np.ndarray, "categories 10"]
    """Variance of the standardised channels. It is 1 in most; less where the spread was raised; any
    value in east and north; and 0 where all objects of a category agree, whose channel is held at
    its mean."""
    stands_on_top: Bool[np.ndarray, " categories"]
    """True if heights in a region of the category count from its top, not from its underside."""
    holds: Bool[np.ndarray, " categories"]
    """True if regions of the category hold fine objects."""
    has_regions: Bool[np.ndarray, ""]
    """True if fine objects have the frames of their regions."""
    site_yaw_rad: Float[np.ndarray, "domains quantiles"]
    """Quantiles of the yaw of training sites; the yaw of a new site is drawn among these."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames of the objects of a layout: origin, yaw and half extents."""

    origin_enu_m: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    half_m: Float[np.ndarray, "n 2"]

    @property
    def packed(self) -> Float[np.ndarray, "n 7"]:
        """Origin, cosine and sine of the yaw, half extents: the form that batches have."""
        heading = np.column_stack([np.cos(self.yaw_rad), np.sin(self.yaw_rad)])
        return np.hstack([self.origin_enu_m, heading, self.half_m])


def frames_of(layout: FlatLayout, statistics: FlatStatistics) -> Frames:
    """Return the frame of each object.

    It is the site's. If the statistics have regions, a fine object has the frame of its region,
    whose height is the region's top or underside.
    """
    n = len(layout)
    origin, yaw, half = np.zeros((n, 3)), np.zeros(n), np.tile(layout.half_m, (n, 1))
    if statistics.has_regions:
        inside = np.flatnonzero(layout.region != NO_REGION)
        region = layout.region[inside]
        origin[inside] = layout.center_enu_m[region]
        height = layout.size_m[region, 2]
        on_top = statistics.stands_on_top[layout.category[region]]
        # Objects on ground count from its top, objects in a room from its underside.
        origin[inside, 2] += np.where(on_top, height, -height) / 2
        yaw[inside] = layout.yaw_rad[region]
        half[inside] = np.maximum(layout.size_m[region, :2] / 2, LEAST_HALF_M)
    return Frames(origin, yaw, half)


def measured_channels(
    layout: FlatLayout, frames: Frames
) -> tuple[Float[np.ndarray, "n 10"], Int[np.ndarray, " n"]]:
    """Return the channels of a layout, not yet standardised, and its quarter turns.

    Args:
        layout: Layout of n objects.
        frames: Frame of each object.
    """
    offset = layout.center_enu_m - frames.origin_enu_m
    cos, sin = np.cos(frames.yaw_rad), np.sin(frames.yaw_rad)
    x, y = offset[:, 0], offset[:, 1]
    along = np.column_stack([cos * x + sin * y, cos * y - sin * x]) / frames.half_m
    turn, rest_rad = quarter_turns(layout.yaw_rad - frames.yaw_rad, IS_TWO_SIDED[layout.category])
    zero = np.zeros(len(layout))
    # The remainder is about the vertical, so x and y of its quaternion are 0.
    quat = np.column_stack([np.cos(rest_rad / 2), zero, zero, np.sin(rest_rad / 2)])
    underside_m = offset[:, 2] - layout.size_m[:, 2] / 2
    return np.column_stack([along, underside_m, quat, np.log(layout.size_m)]), turn


def standardised(
    rows: Float[np.ndarray, "n 10"], category: Int[np.ndarray, " n"], statistics: FlatStatistics
) -> Float[np.ndarray, "n 10"]:
    """Subtract the mean of each object's category and divide by its spread."""
    return (rows - statistics.mean[category]) / statistics.spread[category]


def measure(layouts: Sequence[FlatLayout], *, has_regions: bool) -> FlatStatistics:
    """Measure the statistics of training layouts and, by symmetry, of their turns and mirrors.

    Args:
        layouts: Training layouts with their regions.
        has_regions: True puts fine objects into the frames of their regions.
    """
    empty = np.zeros(N_ROWS, dtype=bool)
    holds = empty.copy()
    for layout in layouts:
        holds[layout.category[layout.region[layout.region != NO_REGION]]] = True
    ones = np.ones((N_ROWS, N_GEOMETRY))
    on_top = _stands_on_top(layouts) if has_regions else empty
    rest = on_top, holds, np.array(has_regions), site_yaw_quantiles_rad(layouts)
    # Frames depend on `stands_on_top` alone, so the moments can be placeholders here.
    framed = FlatStatistics(0 * ones, ones, ones, *rest)
    rows = [measured_channels(layout, frames_of(layout, framed))[0] for layout in layouts]
    mean, spread, variance = _moments(
        np.concatenate(rows), np.concatenate([layout.category for layout in layouts])
    )
    return FlatStatistics(mean, spread, variance, *rest)


def site_yaw_quantiles_rad(
    layouts: Sequence[FlatLayout],
) -> Float[np.ndarray, "domains quantiles"]:
    """Quantiles of the yaw of each domain's sites; zeros for a domain without sites.

    They are existing values, never interpolated ones: most sites stand at a few angles.
    """
    shares = (np.arange(_N_QUANTILES) + 0.5) / _N_QUANTILES
    own = [[each.site_yaw_rad for each in layouts if each.wish.domain == d] for d in DOMAINS]
    return np.stack([np.quantile(rad or [0.0], shares, method="nearest") for rad in own])


def _moments(
    rows: Float[np.ndarray, "n 10"], category: Int[np.ndarray, " n"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    mean = np.zeros((N_ROWS, N_GEOMETRY))
    deviation = np.zeros((N_ROWS, N_GEOMETRY))
    for number in range(N_ROWS):
        own = rows[category == number]
        seen = own if len(own) >= _LEAST_SEEN else rows
        mean[number], deviation[number] = seen.mean(axis=0), seen.std(axis=0)
        # A turned or mirrored layout is a layout too. Therefore east and north share one spread
        # about 0, and left and right turns balance.
        mean[number, :2], mean[number, 6] = 0.0, 0.0
        deviation[number, :2] = np.sqrt((seen[:, :2] ** 2).mean())
        deviation[number, 6] = np.sqrt((seen[:, 6] ** 2).mean())
    spread = np.maximum(deviation, _LEAST_SPREAD)
    spread[:, :2] = PLACE_SPREAD
    variance = (deviation / spread) ** 2
    return mean, spread, np.where(variance < _LEAST_VARIANCE, 0.0, variance)


def _stands_on_top(layouts: Sequence[FlatLayout]) -> Bool[np.ndarray, " categories"]:
    """Mark categories whose contents stand more alike over the top than over the underside."""
    over: list[list[np.ndarray]] = [[], []]
    categories = []
    for layout in layouts:
        inside = np.flatnonzero(layout.region != NO_REGION)
        region = layout.region[inside]
        under_m = layout.center_enu_m[inside, 2] - layout.size_m[inside, 2] / 2
        half_m = layout.size_m[region, 2] / 2
        for sign, found in zip((-1, 1), over, strict=True):
            found.append(under_m - layout.center_enu_m[region, 2] - sign * half_m)
        categories.append(layout.category[region])
    category = np.concatenate(categories)
    bottom, top = (np.abs(np.concatenate(found)) for found in over)
    result = np.zeros(N_ROWS, dtype=bool)
    for number in np.unique(category):
        own = category == number
        result[number] = np.median(top[own]) < np.median(bottom[own])
    return result
