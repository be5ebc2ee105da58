"""Scenes in the paper's form: lists of objects (p, q, s, c), coarse ones first.

The paper leaves the order of its list open. Here a list has one order, so that a model need not
learn that orders do not matter. Coarse objects are sorted by category, quarter turn and place from
right to left, as seen by someone who looks where they face. Fine objects follow alike, grouped by
the region that they belong to. The place matters most. Where all is noise, it tells the network
which of two walls is the southern one, and that the third of thirty trees stands near the border.

The paper leaves the frame of p open, too. Most sites are built along two axes, which point
anywhere. A layout is the site turned so that these axes are east and north. Most headings are then
quarter turns exactly, and a place by itself says whether it is at a border.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.symmetry import draw_symmetry
from aeroscene.learning.wishes import Wish
from aeroscene.metrics.arrays import NO_PARENT, scene_arrays
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import CATALOGUE, TWO_SIDED

NO_REGION = -1
"""Region of an object that belongs to the site itself."""
QUARTER_RAD = np.pi / 2
# Least half extent of a site, so that an empty one has a frame.
_LEAST_HALF_M = 0.5
_ALIKE_RAD = np.radians(2.0)
"""Headings that differ by less belong to one axis."""

IS_TWO_SIDED = np.array([False, *(CATALOGUE[c].name in TWO_SIDED for c in sorted(CATALOGUE))])
"""True for a category that looks the same after half a turn, by its number from 1."""


@dataclass(frozen=True, eq=False)
class FlatLayout:
    """One scene as a list of boxes with categories."""

    category: Int[np.ndarray, " n"]
    """Numbers of the catalogue, from 1."""
    center_enu_m: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    """Yaw; from -45 to below 135 degrees for objects that look the same after half a turn."""
    size_m: Float[np.ndarray, "n 3"]
    region: Int[np.ndarray, " n"]
    """Row of the coarse object that a fine one stands in or on; `NO_REGION` for others."""
    n_coarse: int
    half_m: Float[np.ndarray, " 2"]
    """Half extents of the site along east and north, about the origin."""
    site_yaw_rad: float
    """Yaw of the real site against this layout about the origin, -45 to 45 degrees."""
    wish: Wish

    def __len__(self) -> int:
        return len(self.category)

    @property
    def is_coarse(self) -> Bool[np.ndarray, " n"]:
        """True in rows of coarse objects."""
        return np.arange(len(self)) < self.n_coarse


def flat_layout(scene: Scene, wish: Wish, *, has_regions: bool) -> FlatLayout:
    """List a scene's objects in the one order.

    Args:
        scene: Scene whose objects are listed; tilts are lost.
        wish: Contents that the layout is labelled with.
        has_regions: True keeps the region of each fine object; the paper's own lists have none.
    """
    arrays = scene_arrays(scene)
    fine_first = np.argsort(~arrays.is_coarse, kind="stable")
    # The inverse of a sorting order is the new row of each old one.
    row_of = np.argsort(fine_first)
    region = arrays.region[fine_first]
    region = np.where(region == NO_PARENT, NO_REGION, row_of[region])
    n_coarse = int(arrays.is_coarse.sum())
    region[: n_coarse if has_regions else None] = NO_REGION
    yaw_rad, size_m = arrays.yaw_rad[fine_first], arrays.size_m[fine_first]
    site_yaw_rad = _site_yaw_rad(yaw_rad[:n_coarse], size_m[:n_coarse])
    layout = FlatLayout(
        category=arrays.category[fine_first] + 1,
        center_enu_m=turned(arrays.centre_enu_m[fine_first], -site_yaw_rad),
        yaw_rad=yaw_rad - site_yaw_rad,
        size_m=size_m,
        region=region,
        n_coarse=n_coarse,
        half_m=np.full(2, _LEAST_HALF_M),
        site_yaw_rad=site_yaw_rad,
        wish=wish,
    )
    reach = np.abs(layout.center_enu_m[:, :2]) + _level_extents(layout) / 2
    # The site's half extents are about the origin, even if its objects lie to one side.
    half_m = np.maximum(reach.max(axis=0, initial=_LEAST_HALF_M), _LEAST_HALF_M)
    return _ordered(replace(layout, half_m=half_m))


def turned(center_enu_m: Float[np.ndarray, "n 3"], yaw_rad: float) -> Float[np.ndarray, "n 3"]:
    """Turn places about the vertical through the origin, counter-clockwise seen from above."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    x, y, z = center_enu_m.T
    return np.column_stack([cos * x - sin * y, sin * x + cos * y, z])


def _site_yaw_rad(yaw_rad: Float[np.ndarray, " n"], size_m: Float[np.ndarray, "n 3"]) -> float:
    """Return the remainder of the heading that the largest area of coarse objects shares."""
    if not len(yaw_rad):
        return 0.0
    rest_rad = _rest_rad(yaw_rad)
    # Remainders wrap around: 44 and -44 degrees are alike.
    is_alike = np.abs(_rest_rad(rest_rad[:, None] - rest_rad)) < _ALIKE_RAD
    return float(rest_rad[np.argmax(is_alike @ (size_m[:, 0] * size_m[:, 1]))])


def _rest_rad(yaw_rad: np.ndarray) -> np.ndarray:
    """Remainder of headings, or of differences of headings, after their nearest quarter turns."""
    return yaw_rad - np.round(yaw_rad / QUARTER_RAD) * QUARTER_RAD


def _level_extents(layout: FlatLayout) -> Float[np.ndarray, "n 2"]:
    cos, sin = np.abs(np.cos(layout.yaw_rad)), np.abs(np.sin(layout.yaw_rad))
    x, y, _ = layout.size_m.T
    return np.column_stack([cos * x + sin * y, sin * x + cos * y])


def random_symmetry(layout: FlatLayout, rng: np.random.Generator) -> FlatLayout:
    """Turn a layout by quarter turns at random, and mirror it at random indoors."""
    turns, is_mirrored = draw_symmetry(layout.wish.domain, rng)
    if turns == 0 and not is_mirrored:
        return layout
    angle_rad = turns * QUARTER_RAD
    center, yaw = turned(layout.center_enu_m, angle_rad), layout.yaw_rad + angle_rad
    half, site_yaw_rad = layout.half_m[:: -1 if turns % 2 else 1], layout.site_yaw_rad
    if is_mirrored:
        center[:, 1] *= -1
        yaw, site_yaw_rad = -yaw, -site_yaw_rad
    # The order depends on places and turns, so a turned layout is sorted anew.
    return _ordered(
        replace(layout, center_enu_m=center, yaw_rad=yaw, half_m=half, site_yaw_rad=site_yaw_rad)
    )


def quarter_turns(
    yaw_rad: Float[np.ndarray, " n"], is_two_sided: Bool[np.ndarray, " n"]
) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Split headings into their nearest quarter turn and a remainder of -45 to 45 degrees.

    Args:
        yaw_rad: Headings.
        is_two_sided: True for objects that look the same after half a turn.

    Returns:
        The turns, 0 or 1 for two-sided objects and 0 to 3 for others, and the remainders.
    """
    quarters = np.round(yaw_rad / QUARTER_RAD)
    turn = quarters.astype(int) % np.where(is_two_sided, 2, 4)
    return turn, yaw_rad - quarters * QUARTER_RAD


def _ordered(layout: FlatLayout) -> FlatLayout:
    turn, rest_rad = quarter_turns(layout.yaw_rad, IS_TWO_SIDED[layout.category])
    layout = replace(layout, yaw_rad=turn * QUARTER_RAD + rest_rad)
    keys = np.vstack([*_places_seen(layout), layout.category])
    n = layout.n_coarse
    coarse = np.lexsort(keys[:, :n])
    # New place of each coarse row; the last entry serves `NO_REGION`, which is -1.
    place = np.append(np.argsort(coarse), NO_REGION)
    region = place[layout.region]
    # Objects of the site itself form the last group.
    group = np.where(region < 0, n, region)
    fine = n + np.lexsort(np.vstack([keys[:, n:], group[n:]]))
    order = np.concatenate([coarse, fine])
    return replace(
        layout,
        category=layout.category[order],
        center_enu_m=layout.center_enu_m[order],
        yaw_rad=layout.yaw_rad[order],
        size_m=layout.size_m[order],
        region=region[order],
    )


def _places_seen(layout: FlatLayout) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place of each object ahead and to the left, as it faces in its region, and its turn there."""
    region_yaw_rad = np.where(layout.region < 0, 0.0, layout.yaw_rad[layout.region])
    facing_rad = layout.yaw_rad - region_yaw_rad
    turn, _ = quarter_turns(facing_rad, IS_TWO_SIDED[layout.category])
    axis_rad = turn * QUARTER_RAD + region_yaw_rad
    cos, sin = np.cos(axis_rad), np.sin(axis_rad)
    x, y, _ = layout.center_enu_m.T
    # Rounded to a centimetre, so that objects in one line across are ordered by their place ahead.
    return cos * x + sin * y, np.round(cos * y - sin * x, 2), turn
