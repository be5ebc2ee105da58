"""A scene while it is being changed: boxes that move with the objects that carry them."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import (
    Boxes,
    Overlaps,
    boxes_of,
    forbidden_overlaps,
    joined,
    kinship,
)
from aeroscene.feasibility.seats import tables_of
from aeroscene.scene import AttributeValue, OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import FLOORS, ROOMS, WALLS
from aeroscene.scene.rooms import NO_ROOM, tile_groups

_DIGITS = 4
"""Decimals of lengths in a scene document, as curation writes them."""


@dataclass(slots=True, eq=False)
class Layout:
    """Objects of a scene with boxes that may change; rows are the scene's objects throughout."""

    scene: Scene
    """Scene before any change."""
    boxes: Boxes
    host: Int[np.ndarray, " n"]
    """Row of the object with which each moves: its parent, or for a root the ground on which it
    stands; -1 for neither.
    """
    is_present: Bool[np.ndarray, " n"]
    """True for objects that are still there."""
    extent_m: Float[np.ndarray, "2 3"]
    """Lower and upper corner of the flight volume, which may grow."""
    moves_with: Bool[np.ndarray, "n n"]
    """True if an object (row) moves with another (column)."""
    is_coarse: Bool[np.ndarray, " n"]
    """True for coarse objects; it does not change."""
    table: Int[np.ndarray, " n"]
    """Row of the table that a chair is drawn up to, with which it moves too; -1 for all other
    objects.
    """
    is_pinned: Bool[np.ndarray, " n"]
    """True for objects that stay exactly as they are, whatever is beside them."""
    tile_group: Int[np.ndarray, " n"]
    """Group of tiles of one room, see `aeroscene.scene.rooms`."""
    attributes: dict[int, dict[str, AttributeValue]] = field(default_factory=dict)
    """New attributes of the objects whose attributes have changed."""
    apron_m: dict[int, float] = field(default_factory=dict)
    """Depth of the air at the doors of walls that have less of it than usual."""

    @property
    def objects(self) -> Sequence[SceneObject]:
        """The objects before any change."""
        return self.scene.objects

    @property
    def is_fine(self) -> Bool[np.ndarray, " n"]:
        """Objects that make room: fine ones that are not pinned."""
        return ~self.is_coarse & ~self.is_pinned

    def overlaps(self, least_m: float, obstacles: Boxes | None = None) -> Overlaps:
        """Forbidden overlaps of the remaining objects, and of obstacles behind them.

        Args:
            least_m: Depth up to which an overlap does not count.
            obstacles: Boxes to be kept free; their rows follow those of the objects.
        """
        boxes = joined(self.boxes, obstacles)
        is_present = np.ones(len(boxes), dtype=bool)
        is_present[: len(self.boxes)] = self.is_present
        return forbidden_overlaps(boxes, least_m, is_present)

    def obstructs(self, row: int) -> Bool[np.ndarray, " n"]:
        """Objects for which an object must make room: all for fine ones, coarse for coarse."""
        return self.is_coarse if self.is_coarse[row] else np.ones(len(self.host), dtype=bool)

    def rows(self, categories: frozenset[str]) -> list[int]:
        """Rows of the remaining objects of some categories."""
        present = np.flatnonzero(self.is_present).tolist()
        return [row for row in present if self.objects[row].category in categories]

    def parent_of(self, row: int) -> SceneObject | None:
        """Parent of an object before any change; None without one."""
        above = int(self.boxes.parent[row])
        return None if above < 0 else self.objects[above]

    def is_balcony(self, row: int) -> bool:
        """Return true if an object is a slab held from the side, outside of its host."""
        host = int(self.host[row])
        if self.objects[row].category not in FLOORS or host < 0:
            return False
        # Beyond the outline on one of both axes.
        offset = self.boxes.centre_m[row, :2] - self.boxes.centre_m[host, :2]
        return bool((np.abs(self.boxes.frame(host) @ offset) > self.boxes.half_m[host, :2]).any())

    def chain(self, row: int) -> list[int]:
        """An object and all that it moves with, upwards.

        Args:
            row: Row of the object, which comes first.
        """
        found = [row]
        while self.host[found[-1]] >= 0:
            found.append(int(self.host[found[-1]]))
        return found

    @property
    def is_house(self) -> Bool[np.ndarray, " n"]:
        """Rooms and walls without a parent, if there are such rooms.

        A house of rooms alone stands on the bare earth, with its yard around it.
        """
        is_free = self.boxes.parent < 0
        is_room, is_wall = (
            np.array([obj.category in names for obj in self.objects], dtype=bool)
            for names in (ROOMS, WALLS)
        )
        return is_free & (is_room | is_wall) & (is_free & is_room).any()

    def tiles(self, row: int) -> Int[np.ndarray, " k"]:
        """Objects that carry others as one with an object: the tiles of its room, or it alone."""
        group = int(self.tile_group[row])
        if group == NO_ROOM:
            return np.array([row])
        return np.flatnonzero((self.tile_group == group) & self.is_present)

    def relink(self) -> None:
        """Update `moves_with` after hosts have changed."""
        self.moves_with = np.eye(len(self.host), dtype=bool)
        for row in range(len(self.host)):
            self.moves_with[row, self.chain(row)] = True
        # A chair follows its table only while both stand on the same host.
        seated = np.flatnonzero((self.table >= 0) & self.is_present & self.is_present[self.table])
        for row in seated.tolist():
            if self.host[row] == self.host[self.table[row]]:
                self.moves_with[row, self.table[row]] = True

    def carried(self, row: int) -> Int[np.ndarray, " k"]:
        """Rows of an object and all that moves with it, in order.

        Args:
            row: Row of the object.
        """
        return np.flatnonzero(self.moves_with[:, row])

    def shift(self, row: int, offset_m: Float[np.ndarray, " 3"]) -> None:
        """Move an object with all that it carries, by a vector in the world, m."""
        self.boxes.centre_m[self.carried(row)] += offset_m

    def turn(self, row: int, angle_rad: float) -> None:
        """Turn an object about its middle with all that it carries, counter-clockwise, rad."""
        rows = self.carried(row)
        c, s = math.cos(angle_rad), math.sin(angle_rad)
        middle = self.boxes.centre_m[row, :2].copy()
        offset = self.boxes.centre_m[rows, :2] - middle
        self.boxes.centre_m[rows, :2] = middle + offset @ np.array([[c, s], [-s, c]])
        self.boxes.yaw_rad[rows] += angle_rad

    def adopt(self, row: int, parent: int) -> None:
        """Give an object, with all that belongs to it, another parent; -1 makes it a root."""
        self.host[row] = self.boxes.parent[row] = parent
        self.boxes.is_kin[:] = kinship(self.boxes.parent, self.tile_group)
        self.relink()

    def rehost(self, row: int, host: int) -> None:
        """Let a root stand on other ground, without becoming a child of it."""
        self.host[row] = host
        self.relink()

    def family(self, row: int) -> Int[np.ndarray, " k"]:
        """Rows of an object and its descendants."""
        parent = self.boxes.parent
        found = {row}
        # Rows have no order by generations, so that levels are added until none is new.
        growing = True
        while growing:
            below = set(np.flatnonzero(np.isin(parent, list(found))).tolist()) - found
            found |= below
            growing = bool(below)
        return np.array(sorted(found), dtype=int)

    def drop(self, row: int) -> None:
        """Take an object out with all its descendants.

        Objects that merely stand on it stay, and have the bare earth as their host.

        Args:
            row: Row of the object.
        """
        gone = self.family(row)
        self.is_present[gone] = False
        self.host[np.isin(self.host, gone) & self.is_present] = -1
        self.relink()

    def box(self, row: int) -> OrientedBox:
        """Box of an object, rounded as documents are; the original one if nothing has changed.

        Args:
            row: Row of the object.
        """
        old = self.objects[row].bbox
        x, y, z = (round(v, _DIGITS) for v in self.boxes.centre_m[row].tolist())
        a, b, c = (round(2 * v, _DIGITS) for v in self.boxes.half_m[row].tolist())
        q = old.q
        # An unchanged heading keeps its quaternion to the last digit.
        if abs(math.remainder(self.boxes.yaw_rad[row] - old.yaw_rad, math.tau)) > 1e-7:
            q = quat_from_yaw(float(self.boxes.yaw_rad[row]))
        return OrientedBox((x, y, z), q, (a, b, c))

    def object(self, row: int) -> SceneObject:
        """An object in its present state; a pinned one is returned as it came."""
        old = self.objects[row]
        if self.is_pinned[row]:
            return old
        above = int(self.boxes.parent[row])
        return replace(
            old,
            parent_id=None if above < 0 else self.objects[above].id,
            bbox=self.box(row),
            attributes=self.attributes.get(row, old.attributes),
        )

    def remaining(self) -> tuple[SceneObject, ...]:
        """All remaining objects in their present state, parents first."""
        order: list[int] = []
        waiting = np.flatnonzero(self.is_present).tolist()
        while waiting:
            row = waiting.pop(0)
            above = int(self.boxes.parent[row])
            # A new parent may come later in the original order: the child then waits for it.
            if above in waiting:
                waiting.insert(waiting.index(above) + 1, row)
            else:
                order.append(row)
        return tuple(self.object(row) for row in order)


def layout_of(scene: Scene, pinned: Collection[int] = ()) -> Layout:
    """Begin to change a scene.

    Args:
        scene: Scene; it stays as it is.
        pinned: Ids of objects that must not change.
    """
    boxes = boxes_of(scene.objects)
    is_present = np.ones(len(boxes), dtype=bool)
    extent = np.array([scene.extent_min_enu_m, scene.extent_max_enu_m], dtype=float)
    moves_with = np.eye(len(boxes), dtype=bool)
    is_coarse = np.array([obj.is_coarse for obj in scene.objects], dtype=bool)
    is_pinned = np.array([obj.id in pinned for obj in scene.objects], dtype=bool)
    table = np.full(len(boxes), -1)
    chairs, tables = tables_of(scene.objects, boxes, is_present)
    table[chairs] = tables
    table[is_pinned] = -1
    layout = Layout(
        scene=scene,
        boxes=boxes,
        host=boxes.parent.copy(),
        is_present=is_present,
        extent_m=extent,
        moves_with=moves_with,
        is_coarse=is_coarse,
        table=table,
        is_pinned=is_pinned,
        tile_group=tile_groups(scene.objects),
    )
    layout.relink()
    return layout
