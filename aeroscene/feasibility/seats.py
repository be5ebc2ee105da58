"""Chairs and their tables: the table of each chair, and chairs that face away from it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import Boxes, separation
from aeroscene.scene import SceneObject
from aeroscene.scene.catalogue import SEATS, TABLES

AT_TABLE_M = 0.5
"""Widest gap between a table and a chair that is drawn up to it."""
TO_CHAIR_M = 0.9
"""Greatest distance between the middle of a plate and the middle of its chair."""
OFF_RAD = math.radians(45.0)
"""Largest angle between a chair's heading and the direction of its table."""
_QUARTER = math.pi / 2


def tables_of(
    objects: Sequence[SceneObject], boxes: Boxes, is_present: Bool[np.ndarray, " n"]
) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
    """Rows of chairs that are drawn up to a table of the same parent, and rows of these tables.

    A chair's table is the nearest one that shares height with it.
    """
    present = np.flatnonzero(is_present).tolist()
    chairs = [i for i in present if objects[i].category in SEATS]
    tables = [i for i in present if objects[i].category in TABLES]
    pairs = [(i, j) for i in chairs for j in tables if boxes.parent[i] == boxes.parent[j]]
    if not pairs:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    chair, table = np.array(pairs).T
    rise_m = np.minimum(boxes.top_m[chair], boxes.top_m[table])
    rise_m = rise_m - np.maximum(boxes.base_m[chair], boxes.base_m[table])
    apart_m = separation(boxes, chair, table)[0]
    near = (rise_m > 0) & (apart_m <= AT_TABLE_M)
    chair, table, apart_m = chair[near], table[near], apart_m[near]
    # Sorted by chair, then by distance; the first entry of each chair is its nearest table.
    best = np.lexsort((apart_m, chair))
    best = best[np.unique(chair[best], return_index=True)[1]]
    return chair[best], table[best]


def turns_to_tables(
    objects: Sequence[SceneObject], boxes: Boxes, is_present: Bool[np.ndarray, " n"]
) -> list[tuple[int, float]]:
    """Rows of chairs that face away from their table, and quarter turns to correct it, rad."""
    found: list[tuple[int, float]] = []
    for chair, table in zip(
        *(rows.tolist() for rows in tables_of(objects, boxes, is_present)), strict=True
    ):
        way = _way(boxes, chair, table)
        if not way.any():
            continue
        off_rad = math.atan2(way[1], way[0]) - float(boxes.yaw_rad[chair])
        off_rad = math.remainder(off_rad, math.tau)
        if abs(off_rad) > OFF_RAD:
            # Chairs are turned by quarters, so that they stay square to the table.
            found.append((chair, round(off_rad / _QUARTER) * _QUARTER))
    return found


def _way(boxes: Boxes, chair: int, table: int) -> Float[np.ndarray, " 2"]:
    """Vector from a chair to the nearest point of a table; inside it, to the table's middle."""
    frame, half_m = boxes.frame(table), boxes.half_m[table, :2]
    offset = frame @ (boxes.centre_m[chair, :2] - boxes.centre_m[table, :2])
    way = np.clip(offset, -half_m, half_m) - offset
    return frame.T @ (way if np.abs(way).max() > 0 else -offset)
