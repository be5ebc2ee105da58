"""Boxes of a scene as arrays, and the depths of their overlaps.

Objects of a scene stand upright. A tilted box counts by its heading alone, because separating
footprints and heights apart is far cheaper than the general case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.scene import SceneObject
from aeroscene.scene.rooms import NO_ROOM, tile_groups


@dataclass(slots=True, eq=False)
class Boxes:
    """Upright boxes; row i of each array belongs to object i of a scene."""

    centre_m: Float[np.ndarray, "n 3"]
    """Centres, ENU."""
    half_m: Float[np.ndarray, "n 3"]
    """Half extents along the box's own axes."""
    yaw_rad: Float[np.ndarray, " n"]
    parent: Int[np.ndarray, " n"]
    """Row of the parent; -1 without one."""
    is_kin: Bool[np.ndarray, "n n"]
    """Pairs that may overlap: equal objects, ancestor and descendant, and the tiles of a room with
    whatever may overlap one of them.
    """

    def __len__(self) -> int:
        return len(self.yaw_rad)

    def axes_of(self, rows: Int[np.ndarray, " k"]) -> Float[np.ndarray, "k 2 2"]:
        """Unit vectors of some boxes in the plane.

        Args:
            rows: Rows of the boxes.

        Returns:
            For each box its own x (row 0) and y (row 1), in the world's axes.
        """
        c, s = np.cos(self.yaw_rad[rows]), np.sin(self.yaw_rad[rows])
        axes = np.empty((len(rows), 2, 2))
        axes[:, 0, 0] = axes[:, 1, 1] = c
        axes[:, 0, 1], axes[:, 1, 0] = s, -s
        return axes

    def frame(self, row: int) -> Float[np.ndarray, "2 2"]:
        """Unit vectors along own x and y of one box, in the plane.

        Multiplied from the left it takes world vectors into the box's frame; its transpose leads
        back.
        """
        c, s = math.cos(self.yaw_rad[row]), math.sin(self.yaw_rad[row])
        return np.array([[c, s], [-s, c]])

    @property
    def base_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the undersides, m."""
        return self.centre_m[:, 2] - self.half_m[:, 2]

    @property
    def top_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the upper faces, m."""
        return self.centre_m[:, 2] + self.half_m[:, 2]

    def copy(self) -> Boxes:
        """Copy that can be moved without moving the original."""
        return Boxes(
            self.centre_m.copy(), self.half_m.copy(), self.yaw_rad.copy(), self.parent, self.is_kin
        )

    def corners(self) -> Float[np.ndarray, "n 4 2"]:
        """Corners of the footprints, counter-clockwise from own +x and +y, m."""
        axes = self.axes_of(np.arange(len(self))) * self.half_m[:, :2, None]
        x, y = axes[:, 0], axes[:, 1]
        return self.centre_m[:, None, :2] + np.stack([x + y, y - x, -x - y, x - y], axis=1)


def boxes_of(objects: Sequence[SceneObject]) -> Boxes:
    """Arrays of the boxes of some objects.

    Args:
        objects: Objects, parents before their children; the parents of all of them must be
            included.
    """
    n = len(objects)
    row = {obj.id: i for i, obj in enumerate(objects)}
    parent = np.array(
        [-1 if obj.parent_id is None else row[obj.parent_id] for obj in objects], dtype=int
    )
    return Boxes(
        np.array([obj.bbox.p for obj in objects], dtype=float).reshape(n, 3),
        np.array([obj.bbox.s for obj in objects], dtype=float).reshape(n, 3) / 2,
        np.array([obj.bbox.yaw_rad for obj in objects], dtype=float),
        parent,
        kinship(parent, tile_groups(objects)),
    )


def strangers(
    centre_m: Float[np.ndarray, "n 3"],
    half_m: Float[np.ndarray, "n 3"],
    yaw_rad: Float[np.ndarray, " n"],
) -> Boxes:
    """Boxes that belong to no object, such as air that has to stay free; kin of each other."""
    n = len(yaw_rad)
    return Boxes(centre_m, half_m, yaw_rad, np.full(n, -1), np.ones((n, n), dtype=bool))


def kinship(
    parent: Int[np.ndarray, " n"], tile_group: Int[np.ndarray, " n"]
) -> Bool[np.ndarray, "n n"]:
    """True for pairs that may overlap: equal objects, or ancestor and descendant.

    Args:
        parent: Rows of the parents; -1 without one.
        tile_group: Groups of tiles of one room, each of which counts for all.
    """
    is_kin = np.eye(len(parent), dtype=bool)
    # All ancestors, because an object in a room lies in the room's building too.
    for row in range(len(parent)):
        above = int(parent[row])
        while above >= 0:
            is_kin[row, above] = is_kin[above, row] = True
            above = int(parent[above])
    for group in range(tile_group.max(initial=NO_ROOM) + 1):
        tiles = tile_group == group
        is_kin[np.ix_(is_kin[:, tiles].any(axis=1), tiles)] = True
    return is_kin | is_kin.T


def joined(boxes: Boxes, obstacles: Boxes | None) -> Boxes:
    """Boxes with others behind them that are strangers to all of the first; a copy.

    Args:
        boxes: Boxes of objects.
        obstacles: Further boxes; their rows follow those of the objects.
    """
    if obstacles is None or not len(obstacles):
        return boxes.copy()
    n, total = len(boxes), len(boxes) + len(obstacles)
    is_kin = np.zeros((total, total), dtype=bool)
    is_kin[:n, :n] = boxes.is_kin
    # Obstacles never get out of each other's way.
    is_kin[n:, n:] = True
    return Boxes(
        np.concatenate([boxes.centre_m, obstacles.centre_m]),
        np.concatenate([boxes.half_m, obstacles.half_m]),
        np.concatenate([boxes.yaw_rad, obstacles.yaw_rad]),
        np.concatenate([boxes.parent, np.full(len(obstacles), -1)]),
        is_kin,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Overlaps:
    """Pairs of boxes that overlap although they must not."""

    pairs: Int[np.ndarray, "k 2"]
    depth_m: Float[np.ndarray, " k"]
    """Shortest translation, in the plane or along the vertical, that separates each pair."""

    def by_box(self, n: int) -> Float[np.ndarray, " n"]:
        """Depth of the deepest overlap of each of n boxes; 0 without one.

        Args:
            n: Number of boxes.
        """
        deepest = np.zeros(n)
        for column in self.pairs.T:
            np.maximum.at(deepest, column, self.depth_m)
        return deepest


def forbidden_overlaps(
    boxes: Boxes, least_m: float = 0.0, is_present: Bool[np.ndarray, " n"] | None = None
) -> Overlaps:
    """Find pairs that are not kin and overlap.

    Args:
        boxes: Boxes.
        least_m: Depth up to which an overlap does not count.
        is_present: Boxes that are considered; all by default.
    """
    first, second = np.triu_indices(len(boxes), 1)
    is_stranger = ~boxes.is_kin[first, second]
    if is_present is not None:
        is_stranger &= is_present[first] & is_present[second]
    first, second = first[is_stranger], second[is_stranger]
    rise = boxes.half_m[first, 2] + boxes.half_m[second, 2]
    rise -= np.abs(boxes.centre_m[second, 2] - boxes.centre_m[first, 2])
    # Circles around footprints leave few pairs for the exact test.
    reach = np.hypot(boxes.half_m[:, 0], boxes.half_m[:, 1])
    offset = boxes.centre_m[second, :2] - boxes.centre_m[first, :2]
    near = (rise > least_m) & (np.hypot(*offset.T) < reach[first] + reach[second])
    first, second, rise = first[near], second[near], rise[near]
    depth = np.minimum(footprint_depth(boxes, first, second), rise)
    deep = depth > least_m
    return Overlaps(np.stack([first[deep], second[deep]], axis=1), depth[deep])


def footprint_depth(
    boxes: Boxes, first: Int[np.ndarray, " k"], second: Int[np.ndarray, " k"]
) -> Float[np.ndarray, " k"]:
    """Depth to which footprints overlap along the best separating axis.

    Args:
        boxes: Boxes.
        first: Rows of the first boxes.
        second: Rows of the second boxes.

    Returns:
        Depth in m; negative if the footprints are apart.
    """
    return -separation(boxes, first, second)[0]


def separation(
    boxes: Boxes, first: Int[np.ndarray, " k"], second: Int[np.ndarray, " k"]
) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, "k 2"]]:
    """Widest gap between footprints along an axis of either box, and its direction.

    Args:
        boxes: Boxes.
        first: Rows of the first boxes.
        second: Rows of the second boxes.

    Returns:
        Gap in m, negative if the footprints overlap, and the unit normal from the first to the
        second box.

    Source: separating axes, Gottschalk, Lin and Manocha 1996, "OBBTree", in the plane.
    """
    own, other = boxes.axes_of(first), boxes.axes_of(second)
    half, half_other = boxes.half_m[first, :2], boxes.half_m[second, :2]
    offset = boxes.centre_m[second, :2] - boxes.centre_m[first, :2]
    cross = np.abs(np.einsum("kai,kbi->kab", own, other))
    along = np.concatenate(
        [np.einsum("kai,ki->ka", own, offset), np.einsum("kbi,ki->kb", other, offset)], axis=1
    )
    reach = np.concatenate(
        [
            half + np.einsum("kab,kb->ka", cross, half_other),
            half_other + np.einsum("kab,ka->kb", cross, half),
        ],
        axis=1,
    )
    gaps = np.abs(along) - reach
    best = gaps.argmax(axis=1)
    k = np.arange(len(first))
    sign = np.where(along[k, best] < 0, -1.0, 1.0)
    # From the first box to the second.
    normal = np.concatenate([own, other], axis=1)[k, best] * sign[:, None]
    return gaps[k, best], normal


def reach_along(
    boxes: Boxes, rows: Int[np.ndarray, " k"], normal: Float[np.ndarray, "k 2"]
) -> Float[np.ndarray, " k"]:
    """Half the extent of footprints along normals, m.

    Args:
        boxes: Boxes.
        rows: Rows of the footprints.
        normal: Unit vectors in the plane, one for each.
    """
    lean = np.abs(np.einsum("kai,ki->ka", boxes.axes_of(rows), normal))
    return np.einsum("ka,ka->k", lean, boxes.half_m[rows, :2])
