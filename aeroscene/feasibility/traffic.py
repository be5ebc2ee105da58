"""Vehicles and their roads: each is headed along its road, with the road's middle to its left."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool

from aeroscene.feasibility.boxes import Boxes
from aeroscene.relations.plane import QUARTER, Place, Rectangle
from aeroscene.scene import SceneObject
from aeroscene.scene.catalogue import ROADS, VEHICLES

_ACROSS_RAD = math.radians(45.0)
"""Angle to its road from which a vehicle stands across it."""


def turns_with_traffic(
    objects: Sequence[SceneObject], boxes: Boxes, is_present: Bool[np.ndarray, " n"]
) -> list[tuple[int, float]]:
    """Rows of vehicles on the wrong side of a road, and the turns that correct it, rad."""
    present = np.flatnonzero(is_present).tolist()
    roads = [_outline(boxes, row) for row in present if objects[row].category in ROADS]
    vehicles = [row for row in present if objects[row].category in VEHICLES]
    turns = ((row, _turn_rad(_outline(boxes, row).place, roads)) for row in vehicles)
    return [(row, turn_rad) for row, turn_rad in turns if turn_rad]


def _outline(boxes: Boxes, row: int) -> Rectangle:
    x_m, y_m = boxes.centre_m[row, :2].tolist()
    half_x_m, half_y_m = boxes.half_m[row, :2].tolist()
    return Rectangle(Place(x_m, y_m, float(boxes.yaw_rad[row])), (half_x_m, half_y_m))


def _turn_rad(at: Place, roads: Sequence[Rectangle]) -> float:
    """Turn of a vehicle at a place, by the road under it that lies most along it; 0 for none."""
    under: list[tuple[float, float]] = []
    for road in roads:
        u_m, v_m, turn_rad = road.place.local(at)
        if abs(u_m) <= road.half_m[0] and abs(v_m) <= road.half_m[1]:
            under.append((v_m, turn_rad))
    if not under:
        return 0.0
    v_m, turn_rad = min(under, key=lambda each: abs(math.sin(each[1])))
    is_across = abs(math.cos(turn_rad)) < math.cos(_ACROSS_RAD)
    # On the right: to the left (v > 0) of a road's axis, vehicles drive against it.
    if not is_across and v_m * math.cos(turn_rad) <= 0:
        return 0.0
    ahead_rad = 0.0 if v_m <= 0 else math.pi
    return ahead_rad + math.remainder(turn_rad, QUARTER) - turn_rad
