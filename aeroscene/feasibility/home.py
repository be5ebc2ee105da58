"""Start of the flight: the home pad on open ground, and the air above it that stays free."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.feasibility.boxes import Boxes, footprint_depth, joined, strangers
from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import OPEN_GROUND, PADS, ROADS, TERRAIN

# As curation keeps them, see `aeroscene.corpus.curation.start`.
FREE_RADIUS_M = 3.6
"""Half the side of the square of air above the pad that stays free."""
_FREE_HEIGHT_M = 60.0
_OPEN_RADII_M = (11.0, 9.0, 7.0, 5.0)
"""Half the sides of free squares higher above the pad; the first that is free is taken."""
_OPEN_ABOVE_M = 3.5
_INDOOR_RADIUS_M = 3.2
_START_RADIUS_M = 1.6
"""Half the side of the square of air above a start without a pad that stays free."""
_CEILING_M = 0.1
"""Distance below a ceiling in which lights hang."""
_KERB_M = 0.16
"""Height above the pad up to which an object is no obstacle."""
_TOUCH_M = 0.001
# A pad with that much open air stays where it is.
_WANTED_M = 5.0
_STEP_M = 0.75
_RIM_M = 0.3
"""Width of ground around the pad."""
_FAR = 0.15
"""Openness that is given up for each metre that the pad moves."""


def home_row(layout: Layout) -> int | None:
    """Row of the pad from which the flight starts; None if the scene has none."""
    pads = layout.rows(PADS)
    return next((i for i in pads if layout.objects[i].attributes.get("is_start") is True), None)


def settle_home(layout: Layout, row: int) -> None:
    """Move the pad, and nothing else, to a place where the air above is free of structures.

    Args:
        layout: Layout; changed.
        row: Row of the pad.
    """
    spot = layout.boxes.centre_m[row, :2].copy()
    host = int(layout.host[row])
    is_open_air = host >= 0 and layout.scene.domain != "indoor"
    is_level = host >= 0 and _is_level(layout, host)
    if is_open_air and not (
        is_level and _openness_m(layout, row, host, spot[None])[0] >= _WANTED_M
    ):
        # Its own ground first, then other open ground, then streets.
        best = (
            _best_spot(layout, row, [host] if is_level else [])
            or _best_spot(layout, row, _grounds(layout, OPEN_GROUND))
            or _best_spot(layout, row, _grounds(layout, ROADS))
        )
        if best is not None:
            _move_home(layout, row, *best)


def _is_level(layout: Layout, ground: int) -> bool:
    """Return true if a pad lies flat on some ground; it would sink into a ramp or a mound."""
    obj = layout.objects[ground]
    return obj.category not in TERRAIN or obj.attributes.get("form") == "terrace"


def _move_home(layout: Layout, row: int, ground: int, at: Float[np.ndarray, " 2"]) -> None:
    boxes = layout.boxes
    rise = float(boxes.top_m[ground] - boxes.base_m[row])
    layout.shift(row, np.array([*(at - boxes.centre_m[row, :2]), rise]))
    if ground != layout.host[row]:
        layout.adopt(row, ground)


def _grounds(layout: Layout, names: frozenset[str]) -> list[int]:
    return [i for i in layout.rows(names) if layout.objects[i].domain == "outdoor"]


def _best_spot(
    layout: Layout, row: int, grounds: list[int]
) -> tuple[int, Float[np.ndarray, " 2"]] | None:
    """The most open spot that is not too far away, if any is open enough."""
    boxes = layout.boxes
    here = boxes.centre_m[row, :2]
    best, found = -math.inf, None
    for ground in grounds:
        spots = _spots(layout, row, ground)
        open_m = _openness_m(layout, row, ground, spots)
        # A far place has to be more open than a near one.
        score = open_m - _FAR * np.hypot(*(spots - here).T)
        score[open_m < FREE_RADIUS_M] = -math.inf
        if len(spots) and score.max() > best:
            best, found = float(score.max()), (ground, spots[score.argmax()])
    return found


def _spots(layout: Layout, row: int, ground: int) -> Float[np.ndarray, "k 2"]:
    """A grid of places for the pad on some ground."""
    boxes = layout.boxes
    reach = boxes.half_m[ground, :2] - boxes.half_m[row, :2].max() - _RIM_M
    if reach.min() < 0:
        return np.empty((0, 2))
    u, v = (np.linspace(-r, r, 1 + max(1, int(2 * r / _STEP_M))) for r in reach)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    return boxes.centre_m[ground, :2] + grid @ boxes.frame(ground)


def _openness_m(
    layout: Layout, row: int, ground: int, spots: Float[np.ndarray, "k 2"]
) -> Float[np.ndarray, " k"]:
    """Half the side of the widest free square of air above spots, m; 0 if none is wide enough."""
    boxes, top_m = layout.boxes, float(layout.boxes.top_m[ground])
    low, high = layout.extent_m[:, :2]
    border_m = np.minimum(spots - low, high - spots).min(axis=1)
    is_obstacle = _structures(layout, row)
    yaw = float(boxes.yaw_rad[ground])
    open_m = np.zeros(len(spots))
    # Too near to the border, no square of air fits into the volume.
    candidates = np.flatnonzero(border_m >= FREE_RADIUS_M)
    candidates = candidates[
        _are_free(boxes, is_obstacle, spots[candidates], yaw, FREE_RADIUS_M, top_m + _KERB_M)
    ]
    open_m[candidates] = FREE_RADIUS_M
    # From the widest square down: spots that pass need no further test.
    for radius_m in _OPEN_RADII_M:
        base_m = top_m + _OPEN_ABOVE_M
        is_free = _are_free(boxes, is_obstacle, spots[candidates], yaw, radius_m, base_m)
        open_m[candidates[is_free]] = radius_m
        candidates = candidates[~is_free]
    return open_m


def _structures(layout: Layout, row: int) -> Bool[np.ndarray, " n"]:
    """Coarse objects that stay; fine ones make room."""
    return layout.is_coarse & layout.is_present & ~layout.moves_with[:, row]


def _are_free(
    boxes: Boxes,
    is_obstacle: Bool[np.ndarray, " n"],
    spots: Float[np.ndarray, "k 2"],
    yaw_rad: float,
    radius_m: float,
    base_m: float,
) -> Bool[np.ndarray, " k"]:
    """Return true for spots above which nothing extends into the squares of air."""
    high = np.flatnonzero(is_obstacle & (boxes.top_m > base_m))
    # Circles leave few pairs for the exact test.
    reach = np.hypot(boxes.half_m[high, 0], boxes.half_m[high, 1]) + math.sqrt(2) * radius_m
    offset = boxes.centre_m[high, :2] - spots[:, None]
    spot, near = np.nonzero(np.hypot(offset[..., 0], offset[..., 1]) < reach)
    found = strangers(boxes.centre_m[high], boxes.half_m[high], boxes.yaw_rad[high])
    squares = _squares(spots, yaw_rad, radius_m, base_m, base_m + _FREE_HEIGHT_M)
    depth_m = footprint_depth(joined(found, squares), near, len(high) + spot)
    is_free = np.ones(len(spots), dtype=bool)
    is_free[spot[depth_m > _TOUCH_M]] = False
    return is_free


def _squares(
    spots: Float[np.ndarray, "k 2"], yaw_rad: float, radius_m: float, base_m: float, top_m: float
) -> Boxes:
    k = len(spots)
    middle_m, half_m = (base_m + top_m) / 2, (top_m - base_m) / 2
    return strangers(
        np.column_stack([spots, np.full(k, middle_m)]),
        np.tile([radius_m, radius_m, half_m], (k, 1)),
        np.full(k, yaw_rad),
    )


def start_air(layout: Layout) -> Boxes:
    """Give the box of air that stays free above the start of a scene without a pad."""
    x, y, z = layout.scene.start_position_enu_m
    return _squares(np.array([[x, y]]), 0.0, _START_RADIUS_M, z + _KERB_M, z + _FREE_HEIGHT_M)


def home_air(layout: Layout, row: int) -> Boxes:
    """Give the boxes of air about the pad that stay free.

    Args:
        layout: Layout.
        row: Row of the pad.
    """
    boxes, host = layout.boxes, int(layout.host[row])
    spot, top_m, yaw = boxes.centre_m[row, :2], float(boxes.top_m[row]), float(boxes.yaw_rad[row])
    if layout.scene.domain == "indoor" and host >= 0:
        # Indoors the air ends at the walls of the hall and below its lights.
        radius_m = min(_INDOOR_RADIUS_M, float(boxes.half_m[host, :2].min()))
        ceiling_m = float(boxes.top_m[host]) - _CEILING_M
        return _squares(spot[None], yaw, radius_m, top_m + 0.001, max(ceiling_m, top_m + 0.1))
    near = _squares(spot[None], yaw, FREE_RADIUS_M, top_m, top_m + _FREE_HEIGHT_M)
    open_m = 0.0 if host < 0 else float(_openness_m(layout, row, host, spot[None])[0])
    if open_m <= FREE_RADIUS_M:
        return near
    above_m = top_m + _OPEN_ABOVE_M
    return joined(near, _squares(spot[None], yaw, open_m, above_m, above_m + _FREE_HEIGHT_M))
