"""Boxes against each other and against the flight volume.

An object with an outline counts as the prism over it, not as the box around it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Int

from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.box import box_corners
from aeroscene.scene.footprint import footprint
from aeroscene.scene.outline import OUTLINE
from aeroscene.scene.overlap import near_pairs, pair_iou
from aeroscene.scene.rooms import NO_ROOM, tile_groups
from aeroscene.validation.findings import Finding

MAX_IOU = 0.01
"""Largest overlap of two boxes unless one is the other's parent, or a tile of the same room as its
parent.
"""
OUTSIDE_TOLERANCE_M = 0.01


def overlaps(scene: Scene) -> Iterator[Finding]:
    """Find pairs of boxes that share volume and are not parent and child.

    The later object of a pair is the one at fault.

    Args:
        scene: Scene.
    """
    if not scene.objects:
        return
    objects, boxes = scene.objects, _boxes(scene)
    first, second = _candidates(scene, *boxes)
    shares = pair_iou(*(values[first] for values in boxes), *(values[second] for values in boxes))
    # Boxes first; prisms, which are slower, only if their boxes overlap.
    for row in np.flatnonzero(shares > 0):
        a, b = objects[first[row]], objects[second[row]]
        if OUTLINE in a.attributes or OUTLINE in b.attributes:
            shares[row] = _prism_iou(a, b)
    for row in np.flatnonzero(shares > MAX_IOU):
        a, b = objects[first[row]], objects[second[row]]
        yield Finding(
            kind="overlap",
            scene_id=scene.scene_id,
            object_id=b.id,
            detail=f"{b.category} {b.id} and {a.category} {a.id} overlap with an IoU of "
            f"{shares[row]:.3f}; valid: at most {MAX_IOU}",
        )


def _prism_iou(a: SceneObject, b: SceneObject) -> float:
    """Intersection over union of upright prisms over footprints, 0 to 1."""
    (low_a, high_a), (low_b, high_b) = _heights(a), _heights(b)
    first, second = footprint(a), footprint(b)
    high = max(0.0, min(high_a, high_b) - max(low_a, low_b))
    shared = first.intersection(second).area * high
    volume = first.area * (high_a - low_a) + second.area * (high_b - low_b)
    return shared / (volume - shared)


def _heights(obj: SceneObject) -> tuple[float, float]:
    z, height = obj.bbox.p[2], obj.bbox.s[2]
    return z - height / 2, z + height / 2


def _candidates(
    scene: Scene, p: np.ndarray, q: np.ndarray, s: np.ndarray
) -> tuple[Int[np.ndarray, " pairs"], Int[np.ndarray, " pairs"]]:
    """Pairs that may overlap by enough: near, similar in size, not parent and child."""
    a, b = near_pairs(p, q, s)
    volume = s.prod(axis=1)
    for row, obj in enumerate(scene.objects):
        if OUTLINE in obj.attributes:
            volume[row] = footprint(obj).area * s[row, 2]
    # Volumes that differ this much have a small IoU even if one contains the other.
    ratio = volume[a] / volume[b]
    ids = np.array([obj.id for obj in scene.objects])
    # No object has the id -1.
    parents = np.array([-1 if obj.parent_id is None else obj.parent_id for obj in scene.objects])
    is_family = (parents[b] == ids[a]) | (parents[a] == ids[b])
    is_family |= _is_in_tiles(scene, a, b) | _is_in_tiles(scene, b, a)
    is_wanted = (ratio > MAX_IOU) & (ratio < 1 / MAX_IOU) & ~is_family
    return a[is_wanted], b[is_wanted]


def _is_in_tiles(
    scene: Scene, child: Int[np.ndarray, " pairs"], tile: Int[np.ndarray, " pairs"]
) -> Bool[np.ndarray, " pairs"]:
    """Return true for pairs of which the second is a tile of the room that contains the first."""
    group = tile_groups(scene.objects)
    row = {obj.id: number for number, obj in enumerate(scene.objects)}
    around = np.array(
        [NO_ROOM if o.parent_id is None else group[row[o.parent_id]] for o in scene.objects]
    )
    return (group[tile] != NO_ROOM) & (around[child] == group[tile])


def outside(scene: Scene) -> Iterator[Finding]:
    """Find boxes with a corner beyond the flight volume.

    Args:
        scene: Scene.
    """
    if not scene.objects:
        return
    corners = box_corners(*_boxes(scene))
    least, most = corners.min(axis=1), corners.max(axis=1)
    # The box of an outline may extend beyond the volume where the outline does not.
    for row, obj in enumerate(scene.objects):
        if OUTLINE in obj.attributes:
            x0, y0, x1, y1 = footprint(obj).bounds
            least[row, :2], most[row, :2] = (x0, y0), (x1, y1)
    low, high = np.asarray(scene.extent_min_enu_m), np.asarray(scene.extent_max_enu_m)
    beyond = np.maximum(low - least, most - high)
    for obj, by in zip(scene.objects, beyond, strict=True):
        axis = int(np.argmax(by))
        if by[axis] > OUTSIDE_TOLERANCE_M:
            yield Finding(
                kind="outside",
                scene_id=scene.scene_id,
                object_id=obj.id,
                detail=f"{obj.category} {obj.id} reaches {by[axis]:.3f} m beyond the extent along "
                f"{'xyz'[axis]}; valid: at most {OUTSIDE_TOLERANCE_M} m",
            )


def _boxes(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    boxes = [obj.bbox for obj in scene.objects]
    p, q, s = ([getattr(box, name) for box in boxes] for name in "pqs")
    return np.array(p), np.array(q), np.array(s)
