"""Depth and segments of what stands in a world, cast by Embree: the solids that the physics has.

Embree casts without the interpreter's lock, so that several threads cast at once. Each takes the
next image that nobody has, and no image depends on who cast it.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Float

from flightsim.looks.rays import RayScene
from flightsim.sensors.cameras.raycast_mesh import geom_triangles
from flightsim.sensors.cameras.segmentation import Classes
from flightsim.sensors.cameras.view import NO_OBJECT_ID, Viewpoint
from flightsim.vehicles.airframe import Airframe, CameraMount
from flightsim.world import World
from scenarios.environments.cfg import CameraName, Segment

FAR_M = 20.0
"""Depth of everything that is farther away, and of the sky."""
SEGMENT_DTYPES = {"classes": np.uint8, "objects": np.int32}
"""Type of the pixels of each segment."""


class CameraImages:
    """Images of one camera on each of many vehicles."""

    def __init__(
        self,
        worlds: list[World],
        size_px: tuple[int, int],
        camera: CameraName,
        segments: Sequence[Segment] = (),
        n_threads: int | None = None,
    ) -> None:
        """Prepare the solids of each scene.

        Args:
            worlds: World of each vehicle.
            size_px: Width and height of the images.
            camera: Name of the camera.
            segments: What to tell of each pixel besides its depth.
            n_threads: Threads that cast; None takes one for each core.
        """
        self._width, self._height = size_px
        scenes = {id(world.scene): world for world in worlds}
        self._segments = segments
        solids = {key: _Solids(world) for key, world in scenes.items()}
        self._solids = [solids[id(world.scene)] for world in worlds]
        mounts = [_mount(world.airframe, camera) for world in worlds]
        self._eyes_flu_m = [np.array(mount.position_flu_m) for mount in mounts]
        self._rays_flu = [self._rays(mount) for mount in mounts]
        self._n_helpers = min(n_threads or os.cpu_count() or 1, len(worlds)) - 1
        self._pool = ThreadPoolExecutor(self._n_helpers, "images") if self._n_helpers else None

    def render(
        self, position_enu_m: Float[np.ndarray, "n 3"], rotation_enu_from_flu: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Images (n, h, w) by name: `depth` along the axis up to `FAR_M`, and the segments.

        Args:
            position_enu_m: True positions of the vehicles.
            rotation_enu_from_flu: Their true attitudes (n, 3, 3).
        """
        shape = (len(self._solids), self._height, self._width)
        images = {"depth": np.empty(shape, np.float32)}
        images |= {name: np.empty(shape, SEGMENT_DTYPES[name]) for name in self._segments}
        numbers = itertools.count()

        def cast() -> None:
            while (i := next(numbers)) < len(self._solids):
                rotation = rotation_enu_from_flu[i]
                eye = (position_enu_m[i] + rotation @ self._eyes_flu_m[i]).astype(np.float32)
                rays = self._rays_flu[i] @ rotation.T.astype(np.float32)
                for name, image in self._solids[i].seen(eye, rays, self._segments).items():
                    images[name][i] = image.reshape(shape[1:])

        helpers = [self._pool.submit(cast) for _ in range(self._n_helpers)] if self._pool else []
        cast()
        for helper in helpers:
            helper.result()
        return images

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _rays(self, mount: CameraMount) -> Float[np.ndarray, "k 3"]:
        """Rays of all pixels in the body frame, one metre deep."""
        view = Viewpoint(
            name=mount.name,
            position_enu_m=np.zeros(3),
            rotation_enu_from_optical=mount.rotation_flu_from_optical,
            vertical_fov_rad=mount.vertical_fov_rad,
        )
        return view.rays_enu(self._width, self._height).reshape(-1, 3)


def _mount(airframe: Airframe, camera: CameraName) -> CameraMount:
    return next(mount for mount in airframe.cameras if mount.name == camera)


class _Solids:
    """All that stands in a world and can be touched."""

    def __init__(self, world: World) -> None:
        model, data = world.model, world.new_data()
        geoms = np.flatnonzero((model.geom_bodyid == 0) & (model.geom_contype > 0))
        parts = [
            geom_triangles(model, geom) @ data.geom_xmat[geom].reshape(3, 3).T
            + data.geom_xpos[geom]
            for geom in geoms.tolist()
        ]
        objects = np.repeat(world.geom_object_id[geoms], [len(part) for part in parts])
        # The last entry is for Embree's "nothing", -1.
        objects = np.append(objects, NO_OBJECT_ID).astype(SEGMENT_DTYPES["objects"])
        self._tables = {"objects": objects, "classes": Classes(world).of(objects)}
        self._rays = RayScene(np.concatenate(parts))

    def seen(
        self, eye_enu_m: np.ndarray, rays_enu: np.ndarray, segments: Sequence[Segment]
    ) -> dict[str, np.ndarray]:
        """What each ray from one point meets, by the names of the images."""
        if not segments:
            return {"depth": self._rays.distances(eye_enu_m, rays_enu, FAR_M)}
        hits = self._rays.first_hits(np.broadcast_to(eye_enu_m, rays_enu.shape), rays_enu)
        images = {name: self._tables[name][hits.triangle] for name in segments}
        return {"depth": np.minimum(hits.distance, np.float32(FAR_M)), **images}
