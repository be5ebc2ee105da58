"""Buildings with rooms: shell, roof and slabs fit each other, storeys share their heights.

A model samples each part on its own. Here the parts of a building agree again, before anything is
pushed: the shell grows around its rooms, slabs of a storey become level, and walls end at ceilings.
All lengths are in the building's own axes, in which its parts stand square.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import BUILDINGS, FLOORS, ROOFS, ROOMS, WALLS
from aeroscene.solids.shapes.facade import WALL_M

_MOST_GROWTH_M = {"indoor": 4.0, "outdoor": 0.75, "mixed": 0.75}
"""Greatest distance by which a side of a shell moves out to hold its rooms."""
_EAVES_M = 0.4
_MOST_EAVES_M = 0.6
_PITCHED = frozenset({"gable", "hip", "shed"})
_SAME_M = 1e-3
_STOREY_M = 1.2
"""Difference in height up to which slabs are on one storey."""
_NEAR_M = 0.8
"""Distance up to which a room or wall is meant to reach a ceiling."""


def fit_shells(layout: Layout) -> None:
    """Make each building hold its rooms, lie under its roof and on its slab."""
    for row in layout.rows(BUILDINGS):
        parts = _parts(layout, row)
        if parts.rooms:
            _grow(layout, row, parts.rooms)
            _lay_slab(layout, row, parts.floors)
            _level(layout, row, parts)
    lay_roofs(layout)


def lay_roofs(layout: Layout) -> None:
    """Lay each roof over its building."""
    for row in layout.rows(BUILDINGS):
        for roof in _parts(layout, row).roofs:
            _cover(layout, row, roof)


class _Parts(NamedTuple):
    rooms: list[int]
    floors: list[int]
    walls: list[int]
    roofs: list[int]


def _parts(layout: Layout, row: int) -> _Parts:
    parts = np.flatnonzero((layout.boxes.parent == row) & layout.is_present).tolist()
    kinds = (ROOMS, FLOORS, WALLS, ROOFS)
    return _Parts(*([i for i in parts if layout.objects[i].category in kind] for kind in kinds))


def _borders(layout: Layout, row: int, part: int) -> Float[np.ndarray, "2 2"]:
    """Low and high ends of a part along a building's axes, from the building's middle, m."""
    boxes = layout.boxes
    axes = boxes.frame(row)
    middle = axes @ (boxes.centre_m[part, :2] - boxes.centre_m[row, :2])
    reach = np.abs(axes @ boxes.frame(part).T) @ boxes.half_m[part, :2]
    return np.stack([middle - reach, middle + reach])


def _grow(layout: Layout, row: int, rooms: list[int]) -> None:
    """Move the sides of a shell out to its rooms."""
    boxes = layout.boxes
    borders = np.stack([_borders(layout, row, room) for room in rooms])
    half = boxes.half_m[row, :2]
    most = _MOST_GROWTH_M[layout.scene.domain]
    low = np.clip(-half - (borders[:, 0].min(axis=0) - WALL_M), 0.0, most)
    high = np.clip(borders[:, 1].max(axis=0) + WALL_M - half, 0.0, most)
    low, high = (np.where(grown > _SAME_M, grown, 0.0) for grown in (low, high))
    boxes.centre_m[row, :2] += boxes.frame(row).T @ ((high - low) / 2)
    boxes.half_m[row, :2] += (high + low) / 2


def _lay_slab(layout: Layout, row: int, floors: list[int]) -> None:
    """Let the lowest slab fill the shell."""
    boxes = layout.boxes
    if not floors:
        return
    slab = min(floors, key=lambda floor: float(boxes.base_m[floor]))
    # Only upper slabs: the building has no ground floor of its own.
    if boxes.base_m[slab] - boxes.base_m[row] > _STOREY_M:
        return
    _place(layout, slab, row, boxes.half_m[row, :2] - WALL_M)
    _set_span(layout, slab, float(boxes.base_m[row]), 2 * float(boxes.half_m[slab, 2]))


def _place(layout: Layout, part: int, row: int, half: Float[np.ndarray, " 2"]) -> None:
    """Lay a part around its building's middle; half extents in the building's axes."""
    boxes = layout.boxes
    # A part at a quarter turn has its extents exchanged.
    turns = abs(math.sin(float(boxes.yaw_rad[part] - boxes.yaw_rad[row])))
    wanted = half[::-1] if turns > 0.5 else half
    if np.abs(boxes.half_m[part, :2] - wanted).max() > _SAME_M:
        boxes.half_m[part, :2] = wanted
    offset = boxes.centre_m[row, :2] - boxes.centre_m[part, :2]
    if np.abs(offset).max() > _SAME_M:
        boxes.centre_m[part, :2] += offset


def _set_span(layout: Layout, part: int, base_m: float, height_m: float) -> None:
    """Set a part's underside and height; objects on it follow its underside."""
    boxes = layout.boxes
    rise = base_m - float(boxes.base_m[part])
    if abs(rise) > _SAME_M:
        layout.shift(part, np.array([0.0, 0.0, rise]))
    if abs(height_m - 2 * boxes.half_m[part, 2]) > _SAME_M:
        boxes.half_m[part, 2] = height_m / 2
        boxes.centre_m[part, 2] = base_m + height_m / 2


def _level(layout: Layout, row: int, parts: _Parts) -> None:
    """Level the slabs of each storey; rooms and walls stand on slabs, below the next ones."""
    boxes = layout.boxes
    ground_m, roof_m = float(boxes.base_m[row]), float(boxes.top_m[row])
    upper = [f for f in parts.floors if boxes.base_m[f] - ground_m > _STOREY_M]
    lower = [f for f in parts.floors if f not in upper]
    floors_m = [max(float(boxes.top_m[f]) for f in lower) if lower else ground_m]
    ceilings_m = [roof_m]
    for group in _storeys(layout, upper):
        thick_m = 2 * float(np.median(boxes.half_m[group, 2]))
        # At least 2 m remain below the roof.
        base_m = min(float(np.median(boxes.base_m[group])), roof_m - thick_m - 2.0)
        for slab in group:
            _set_span(layout, slab, base_m, thick_m)
        floors_m.append(base_m + thick_m)
        ceilings_m.append(base_m)
    for part in (*parts.rooms, *parts.walls):
        _stand(layout, part, floors_m, ceilings_m)
    _bear(layout, row, upper, [r for r in parts.rooms if boxes.base_m[r] - ground_m > _STOREY_M])


def _storeys(layout: Layout, slabs: list[int]) -> list[list[int]]:
    """Slabs by storey, from the lowest."""
    groups: list[list[int]] = []
    for slab in sorted(slabs, key=lambda floor: float(layout.boxes.base_m[floor])):
        base_m = float(layout.boxes.base_m[slab])
        if groups and base_m - float(layout.boxes.base_m[groups[-1][0]]) < _STOREY_M:
            groups[-1].append(slab)
        else:
            groups.append([slab])
    return groups


def _stand(layout: Layout, part: int, floors_m: list[float], ceilings_m: list[float]) -> None:
    """Set a room or wall onto the nearest floor, and up to the ceiling that it nearly reaches."""
    boxes = layout.boxes
    base_m, top_m = float(boxes.base_m[part]), float(boxes.top_m[part])
    is_wall = layout.objects[part].category in WALLS
    # Beside the edge of an upper floor a wall stands on the wall below.
    stands = [*floors_m, *(ceilings_m[1:] if is_wall else [])]
    foot_m = min(stands, key=lambda floor: abs(floor - base_m))
    above = [ceiling for ceiling in ceilings_m if ceiling > foot_m + 1.0]
    if not above:
        return
    ceiling_m = min(above, key=lambda ceiling: abs(ceiling - top_m))
    height_m = top_m - base_m if top_m <= max(above) else max(above) - foot_m
    if abs(ceiling_m - top_m) < _NEAR_M and not _is_short(layout, part, ceilings_m[0]):
        height_m = ceiling_m - foot_m
    _set_span(layout, part, foot_m, height_m)


def _bear(layout: Layout, row: int, slabs: list[int], rooms: list[int]) -> None:
    """Let each upper room move with the nearest slab of its storey, which grows below it."""
    boxes = layout.boxes
    for room in rooms:
        level = [s for s in slabs if abs(boxes.top_m[s] - boxes.base_m[room]) < _SAME_M]
        if not level:
            continue
        away = [np.hypot(*(boxes.centre_m[s] - boxes.centre_m[room])[:2]) for s in level]
        slab = level[int(np.argmin(away))]
        own, wanted = _borders(layout, row, slab), _borders(layout, row, room)
        low = np.maximum(own[0] - wanted[0], 0.0)
        high = np.maximum(wanted[1] - own[1], 0.0)
        if max(low.max(), high.max()) > _SAME_M:
            _widen(layout, row, slab, low, high)
        layout.rehost(room, slab)


def _widen(
    layout: Layout, row: int, part: int, low: Float[np.ndarray, " 2"], high: Float[np.ndarray, " 2"]
) -> None:
    """Extend a part at its low and high ends along its building's axes."""
    boxes = layout.boxes
    boxes.centre_m[part, :2] += boxes.frame(row).T @ ((high - low) / 2)
    grown = (high + low) / 2
    turns = abs(math.sin(float(boxes.yaw_rad[part] - boxes.yaw_rad[row])))
    boxes.half_m[part, :2] += grown[::-1] if turns > 0.5 else grown


def _is_short(layout: Layout, part: int, roof_m: float) -> bool:
    """Return true if a room ends below a ceiling on purpose, as in a hall of sheet metal."""
    return abs(roof_m - 0.3 - float(layout.boxes.top_m[part])) < _SAME_M


def _cover(layout: Layout, row: int, roof: int) -> None:
    """Lay a roof over its building; a pitched one gets eaves as wide as on its narrowest side."""
    boxes = layout.boxes
    borders = _borders(layout, row, roof)
    eaves = np.abs(borders) - boxes.half_m[row, :2]
    is_pitched = layout.objects[roof].attributes.get("form") in _PITCHED
    is_even = np.abs(borders.sum(axis=0)).max() < _SAME_M and eaves.min() > -_SAME_M
    if is_even and eaves.max() < (_MOST_EAVES_M if is_pitched else _SAME_M):
        return
    over_m = min(max(float(eaves.min()), 0.0), _EAVES_M) if is_pitched else 0.0
    _place(layout, roof, row, boxes.half_m[row, :2] + over_m)
