"""New hosts after cuts and moves: other rooms, other ground, or the bare earth."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import BEARING, is_chained
from aeroscene.scene.catalogue import BUILDING_PARTS, COVERS, GROUND, ROOMS

# Bounds the search for places.
_MOST_HOSTS = 4
_BESIDE_M = 0.5
"""Distance beside its ground up to which an object is pulled back onto it."""
_LOST_M = 3.0
"""Distance from all ground beyond which an object is left on the bare earth."""
_STEP_M = 0.2
"""Difference in height up to which the floors of rooms are on one level."""


def dissolve(layout: Layout, row: int) -> None:
    """Take a surface out, and leave its objects to its neighbours.

    Objects of a room that have no other room are dropped; objects of open ground stay on the bare
    earth.
    """
    children = np.flatnonzero((layout.boxes.parent == row) & layout.is_present).tolist()
    is_room = layout.objects[row].category in ROOMS
    layout.is_present[row] = False
    for child in children:
        ground = _ground_below(layout, child, row)
        if is_room and ground < 0:
            layout.drop(child)
        else:
            layout.adopt(child, ground)
    # Roots stand on it without being its children.
    layout.host[(layout.host == row) & layout.is_present] = -1
    layout.relink()


def rehome(layout: Layout) -> None:
    """Leave objects that a cut has left beside their surface to the surface below them.

    A cut then displaces nothing: a bench stays where it is, on the lawn instead of the plaza. If
    there is no surface below, fine objects keep theirs, or get one that is much nearer.
    """
    boxes = layout.boxes
    for row, obj in enumerate(layout.objects):
        host = int(boxes.parent[row])
        if host < 0 or not layout.is_present[row]:
            continue
        bearer = layout.objects[host]
        is_surface = bearer.category in GROUND or (bearer.category in ROOMS and not obj.is_coarse)
        if not is_surface or is_chained(obj, bearer):
            continue
        beside_m = _beside_m(layout, host, boxes.centre_m[row, :2])
        if beside_m < _BESIDE_M:
            continue
        ground = _ground_below(layout, row, host)
        if ground not in (-1, host) or (ground < 0 and beside_m > _LOST_M):
            layout.adopt(row, ground)


def _ground_below(layout: Layout, row: int, host: int) -> int:
    """The surface of the same kind that lies below the middle of an object; -1 without one.

    If no surface holds a fine object, or one that stood in a room, it is the nearest one, its own
    included if that is still there.
    """
    at, is_fine = layout.boxes.centre_m[row, :2], not layout.objects[row].is_coarse
    like = [g for g in _hosts_like(layout, host) if not layout.moves_with[g, row]]
    for ground in like:
        if _holds(layout, ground, at):
            return ground
    if not is_fine and layout.objects[host].category not in ROOMS:
        return -1
    like = [host, *like] if layout.is_present[host] else like
    return min(like, key=lambda ground: _beside_m(layout, ground, at), default=-1)


def other_hosts(layout: Layout, row: int) -> list[int]:
    """List other possible hosts of an object, nearest first.

    Args:
        layout: Layout.
        row: Row of the object.

    Returns:
        Rows of surfaces of the same kind that are wide enough; -1 is the bare earth.
    """
    if layout.objects[row].category in COVERS | BUILDING_PARTS:
        return []
    boxes, host = layout.boxes, int(layout.host[row])
    like = _hosts_like(layout, None if host < 0 else host)
    size = boxes.half_m[row, :2].min()
    far = np.array([float(_beside_m(layout, h, boxes.centre_m[row, :2])) for h in like])
    # Too narrow a surface for the object would not carry it.
    is_wide = [boxes.half_m[h, :2].min() >= size for h in like]
    order = [like[k] for k in np.argsort(far, kind="stable").tolist() if is_wide[k]]
    order = [h for h in order if not layout.moves_with[h, row] and h != host]
    # Only coarse objects may stand on the bare earth.
    is_outside = host >= 0 and layout.objects[host].category in BEARING
    is_outside &= layout.objects[row].is_coarse
    return [*order[:_MOST_HOSTS], *([-1] if is_outside else [])]


def _hosts_like(layout: Layout, host: int | None) -> list[int]:
    """Other surfaces of the kind: rooms of the same building at its height, or open ground."""
    if host is not None and layout.objects[host].category in ROOMS:
        found = _rooms_beside(layout, host)
    elif host is None or layout.objects[host].category in GROUND:
        found = [
            row
            for row in layout.rows(BEARING)
            if layout.objects[row].domain == "outdoor" and row != host
        ]
    else:
        return []
    # Small covers lie on large ones and come first; the ground that carries the host comes last.
    found.sort(key=lambda row: float(layout.boxes.half_m[row, :2].prod()))
    above = -1 if host is None else int(layout.boxes.parent[host])
    is_bearer = above >= 0 and layout.objects[above].category in BEARING | ROOMS
    return [*found, above] if is_bearer and above not in found else found


def _rooms_beside(layout: Layout, room: int) -> list[int]:
    """The other rooms of the storey, or of the building if the storey has no other."""
    boxes = layout.boxes
    parent = boxes.parent
    rooms = [i for i in layout.rows(ROOMS) if i != room and parent[i] == parent[room]]
    beside = [row for row in rooms if abs(boxes.base_m[row] - boxes.base_m[room]) < _STEP_M]
    return beside or rooms


def _beside_m(layout: Layout, host: int, at: Float[np.ndarray, " 2"]) -> float:
    """Distance of a point from an outline, m; 0 inside it."""
    boxes = layout.boxes
    local = np.abs(boxes.frame(host) @ (at - boxes.centre_m[host, :2]))
    return float(np.hypot(*np.maximum(local - boxes.half_m[host, :2], 0.0)))


def _holds(layout: Layout, host: int, at: Float[np.ndarray, " 2"]) -> bool:
    return _beside_m(layout, host, at) == 0.0
