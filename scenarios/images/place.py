"""Free space of a scene, in which cameras are held."""

from __future__ import annotations

import functools
import itertools

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import Scene
from aeroscene.scene.relief import ground_m
from aeroscene.solids.field_cache import cached_distance_field
from aeroscene.solids.freespace import NoFreeSpaceError, reachable
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.wide_field import is_wide
from aeroscene.sources import load_scene
from scenarios.images.request import MOST_OBJECT_ID, ImagesError

ROOM_M = 0.5
"""Least distance from a camera to anything solid."""
_SPHERE_M = 0.35
"""Radius of the drone that must be able to fly from the start to the camera's room."""
_LEAST_HEIGHT_M = 0.7
"""Least height above the ground."""
_RESOLUTIONS_M = (0.25, 0.5, 1.0, 2.0, 4.0)
_CANDIDATES, _ROUNDS = 256, 40


class Place:
    """A scene with its distance field.

    Attributes:
        scene: The scene.
    """

    def __init__(self, scene: Scene) -> None:
        """Compute the free space, or take it from the cache.

        Raises:
            ImagesError: If an object's id does not fit into an image.
        """
        self.scene = scene
        highest = max((obj.id for obj in scene.objects), default=0)
        if highest > MOST_OBJECT_ID:
            raise ImagesError(
                f"scene {scene.scene_id!r} has an object {highest}; valid: ids to {MOST_OBJECT_ID}"
            )
        # A large scene has coarser cells, so that its field fits into memory.
        resolution_m = next(r for r in _RESOLUTIONS_M if not is_wide(scene, r))
        self._field = cached_distance_field(scene, resolution_m, scene_primitives(scene))
        try:
            self._is_reached = reachable(self._field, scene.start_position_enu_m, _SPHERE_M)
        except NoFreeSpaceError:
            self._is_reached = self._field.distance_m >= _SPHERE_M

    def is_free(self, points_enu_m: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
        """Return whether a camera has room at points, and a drone can get there."""
        field = self._field
        cells = np.rint((points_enu_m - np.array(field.origin_enu_m)) / field.resolution_m)
        shape = np.array(field.distance_m.shape)
        is_inside: np.ndarray = np.all((cells >= 0) & (cells < shape), axis=1)
        i, j, k = np.where(is_inside[:, None], cells, 0).astype(int).T
        return is_inside & self._is_reached[i, j, k] & (field.distance_m[i, j, k] >= ROOM_M)

    def height_m(self, point_enu_m: Float[np.ndarray, " 3"]) -> float:
        """Return the height of a point above the ground."""
        ground = ground_m(self.scene.relief, point_enu_m[0], point_enu_m[1])
        return float(point_enu_m[2] - ground)

    def draw(self, rng: np.random.Generator) -> Float[np.ndarray, " 3"]:
        """Draw a free point whose height above the ground has a uniform logarithm.

        A uniform height would put most cameras high above everything, because most free space is
        there.

        Raises:
            ImagesError: If no free point is found.
        """
        low, high = np.array(self.scene.extent_min_enu_m), np.array(self.scene.extent_max_enu_m)
        most_m = max(high[2] - low[2], 2.0 * _LEAST_HEIGHT_M)
        for _ in itertools.repeat(None, _ROUNDS):
            points = rng.uniform(low, high, (_CANDIDATES, 3))
            heights = np.exp(rng.uniform(np.log(_LEAST_HEIGHT_M), np.log(most_m), _CANDIDATES))
            points[:, 2] = ground_m(self.scene.relief, points[:, 0], points[:, 1]) + heights
            free = np.flatnonzero(self.is_free(points))
            if len(free):
                return points[free[0]]
        raise ImagesError(
            f"scene {self.scene.scene_id!r} has no free point for a camera; valid: a scene with "
            f"{ROOM_M} m of room somewhere above its start"
        )


@functools.lru_cache(maxsize=2)
def place_of(name: str) -> Place:
    """Return the place of a scene by its name; a process keeps the last two.

    Raises:
        SceneError: If there is no such scene.
        ImagesError: If it cannot be shown in images.
    """
    return Place(load_scene(name))
