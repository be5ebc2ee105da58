"""Instances of a frame: masks, boxes in the image, and boxes in the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Int
from scipy.ndimage import find_objects
from scipy.spatial.transform import Rotation

from aeroscene.scene import OrientedBox, Scene
from flightsim.cameras.segmentation import CLASS_NAMES, Classes
from flightsim.environment.movers import MOVER_KINDS
from flightsim.world import FIRST_MOVER_ID, World
from scenarios.images.labels.projection import Pinhole
from scenarios.images.labels.rle import encode_labels

LEAST_PIXELS = 20
"""Fewest pixels of an instance or of a landing area that is labelled."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Thing:
    """An object or a mover with its box."""

    category_id: int
    """Key of `CLASS_NAMES`."""
    box: OrientedBox


def things_of(scene: Scene) -> dict[int, Thing]:
    """Return the objects of a scene by their ids."""
    return {obj.id: Thing(category_id=obj.category_id, box=obj.bbox) for obj in scene.objects}


def movers_of(
    world: World, classes: Classes, position_enu_m: np.ndarray, quat_wxyz: np.ndarray
) -> dict[int, Thing]:
    """Return the movers of a world by their ids.

    Args:
        world: World.
        classes: Its classes.
        position_enu_m: Middle of each mover's underside, (n, 3).
        quat_wxyz: Attitude of each, (n, 4).
    """
    things = {}
    for index, mover in enumerate(world.obstacles):
        number = FIRST_MOVER_ID - index
        size_m = MOVER_KINDS[mover.kind].size_m
        x, y, z = position_enu_m[index].tolist()
        w, i, j, k = quat_wxyz[index].tolist()
        upright = OrientedBox(p=(x, y, z + size_m[2] / 2), q=(w, i, j, k), s=size_m)
        category = int(classes.of(np.array([number], np.int32))[0])
        things[number] = Thing(category_id=category, box=upright)
    return things


def instances(
    camera: Pinhole, ids: Int[np.ndarray, "h w"], things: Mapping[int, Thing]
) -> list[dict[str, Any]]:
    """Return the labels of all instances that a camera sees, in the order of their ids.

    Args:
        camera: Camera of the frame.
        ids: Object of each pixel.
        things: Objects and movers by their ids.
    """
    seen, index, counts = np.unique(ids, return_inverse=True, return_counts=True)
    slices = find_objects(index.reshape(ids.shape).astype(np.int32) + 1)
    masks = encode_labels(ids)
    found = []
    for number, n_pixels, place in zip(seen.tolist(), counts.tolist(), slices, strict=True):
        if number in things and n_pixels >= LEAST_PIXELS:
            rows, columns = place
            found.append(
                {
                    "id": number,
                    "category_id": things[number].category_id,
                    "category": CLASS_NAMES[things[number].category_id],
                    "pixels": n_pixels,
                    "box_px": [
                        columns.start,
                        rows.start,
                        columns.stop - columns.start,
                        rows.stop - rows.start,
                    ],
                    "is_cut": _touches_border(rows, columns, ids.shape),
                    "box3d": _box(camera, things[number].box),
                    "rle": masks[number],
                }
            )
    return found


def _touches_border(rows: slice, columns: slice, shape: tuple[int, ...]) -> bool:
    ends = (rows.stop == shape[0], columns.stop == shape[1])
    return rows.start == 0 or columns.start == 0 or any(ends)


def _box(camera: Pinhole, box: OrientedBox) -> dict[str, Any]:
    corners = box.corners()
    local = camera.to_optical(corners)
    is_ahead = bool((local[:, 2] > 0.0).all())
    attitude = Rotation.from_quat(box.q, scalar_first=True)
    turn = Rotation.from_matrix(camera.pose.rotation_enu_from_optical.T) * attitude
    centre = camera.to_optical(np.array([box.p]))[0]
    return {
        "centre_enu_m": list(box.p),
        "quat_wxyz": list(box.q),
        "size_m": list(box.s),
        "centre_optical_m": _rounded(centre, 4),
        "quat_optical_wxyz": _rounded(turn.as_quat(scalar_first=True, canonical=True), 6),
        # Corners behind the camera have no place in its image.
        "corners_px": _rounded(camera.pixels(local), 2) if is_ahead else None,
    }


def _rounded(values: np.ndarray, digits: int) -> Any:
    return np.round(values, digits).tolist()
