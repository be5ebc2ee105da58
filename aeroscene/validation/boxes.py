"""Boxes against each other and against the flight volume."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from jaxtyping import Int

from aeroscene.scene import Scene
from aeroscene.scene.box import box_corners
from aeroscene.scene.geometry import iou, penetration_depth
from aeroscene.validation.findings import Finding

MAX_IOU = 0.01
"""Of two boxes neither of which is the other's parent."""
OUTSIDE_TOLERANCE_M = 0.01


def overlaps(scene: Scene) -> Iterator[Finding]:
    """Pairs of boxes that share volume and are not parent and child."""
    objects = scene.objects
    for first, second in _candidates(scene).tolist():
        a, b = objects[first], objects[second]
        share = iou(a.bbox, b.bbox)
        if share > MAX_IOU:
            yield Finding(
                kind="overlap",
                scene_id=scene.scene_id,
                object_id=b.id,
                detail=f"{b.category} {b.id} and {a.category} {a.id} overlap with an IoU of "
                f"{share:.3f}, valid: at most {MAX_IOU}",
            )


def _candidates(scene: Scene) -> Int[np.ndarray, "pairs 2"]:
    """Pairs that may overlap by enough: near, like in size, not parent and child."""
    if not scene.objects:
        return np.empty((0, 2), dtype=int)
    p, q, s = _boxes(scene)
    corners = box_corners(p, q, s)
    low, high = corners.min(axis=1), corners.max(axis=1)
    volume = s.prod(axis=1)
    first, second = np.triu_indices(len(p), 1)
    near = ((low[first] < high[second]) & (low[second] < high[first])).all(axis=1)
    # Two volumes so unlike share too little even where one holds the other.
    ratio = volume[first] / volume[second]
    pairs = np.stack([first, second], axis=1)[near & (ratio > MAX_IOU) & (ratio < 1 / MAX_IOU)]
    ids = np.array([obj.id for obj in scene.objects])
    # -1 is no object's id.
    parents = np.array([-1 if obj.parent_id is None else obj.parent_id for obj in scene.objects])
    is_family = (parents[pairs[:, 1]] == ids[pairs[:, 0]]) | (
        parents[pairs[:, 0]] == ids[pairs[:, 1]]
    )
    a, b = pairs[~is_family].T
    depth = penetration_depth(p[a], q[a], s[a], p[b], q[b], s[b])
    return np.stack([a, b], axis=1)[depth > 0]


def outside(scene: Scene) -> Iterator[Finding]:
    """Boxes with a corner beyond the flight volume."""
    if not scene.objects:
        return
    corners = box_corners(*_boxes(scene))
    low, high = np.asarray(scene.extent_min_enu_m), np.asarray(scene.extent_max_enu_m)
    beyond = np.maximum(low - corners.min(axis=1), corners.max(axis=1) - high)
    for obj, by in zip(scene.objects, beyond, strict=True):
        axis = int(np.argmax(by))
        if by[axis] > OUTSIDE_TOLERANCE_M:
            yield Finding(
                kind="outside",
                scene_id=scene.scene_id,
                object_id=obj.id,
                detail=f"{obj.category} {obj.id} reaches {by[axis]:.3f} m beyond the extent along "
                f"{'xyz'[axis]}, valid: at most {OUTSIDE_TOLERANCE_M} m",
            )


def _boxes(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    boxes = [obj.bbox for obj in scene.objects]
    p, q, s = ([getattr(box, name) for box in boxes] for name in "pqs")
    return np.array(p), np.array(q), np.array(s)
