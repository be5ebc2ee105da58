"""Depth and segments of a world: images of the solids that the physics has.

Images are cast by rays instead of rendered. Rays meet the same solids that the vehicle can touch,
they need no graphics context, and several threads share the images of a step.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Float

from autonomy.jit import compile_ahead
from flightsim.cameras.image_batch import VIEW_DTYPE, cast_images, example_arguments
from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.cameras.segmentation import Classes
from flightsim.cameras.view import NO_OBJECT_ID
from flightsim.looks.embree import functions
from flightsim.looks.rays import RayScene
from flightsim.plant.rays import RAYS_DTYPE
from flightsim.vehicles.airframe import Airframe, CameraMount
from flightsim.world import World
from scenarios.environments.cfg import CameraName, Segment

FAR_M = 20.0
"""Depth of everything that is farther away, including the sky."""
_COMPILE_SECONDS = 5.0
SEGMENT_DTYPES = {"classes": np.uint8, "objects": np.int32}
"""Type of the pixels of each segment."""


class CameraImages:
    """Images of one camera on each of many vehicles."""

    def __init__(
        self,
        worlds: Sequence[World],
        size_px: tuple[int, int],
        camera: CameraName,
        segments: Sequence[Segment] = (),
        n_threads: int | None = None,
        rays: np.ndarray | None = None,
    ) -> None:
        """Prepare the static solids of each scene.

        Args:
            worlds: World of each vehicle.
            size_px: Width and height of the images.
            camera: Name of the camera.
            segments: Kinds of images besides the depth.
            n_threads: Threads that cast; None takes one for each core.
            rays: `RAYS_DTYPE` (n,) with the movers around each vehicle; None sees no movers.
        """
        n, (width, height) = len(worlds), size_px
        self._size, self._segments = (height, width), segments
        # Worlds of one scene share their solids.
        builds = {id(world.rays): world for world in worlds}
        solids = {key: _Solids(world) for key, world in builds.items()}
        self._solids = [solids[id(world.rays)] for world in worlds]
        self._tables = _tables(worlds, self._solids) if segments else []
        mounts = [_mount(world.airframe, camera) for world in worlds]
        self._eyes_flu_m = np.array([mount.position_flu_m for mount in mounts])
        self._turns = np.array([mount.rotation_flu_from_optical for mount in mounts])
        self._rays = np.zeros(n, RAYS_DTYPE) if rays is None else rays
        self._views = np.zeros(n, VIEW_DTYPE)
        self._views["focal_px"] = [
            0.5 * height / np.tan(0.5 * mount.vertical_fov_rad) for mount in mounts
        ]
        # Objects beyond the greatest depth still have a segment.
        self._views["far_m"] = np.inf if segments else FAR_M
        self._views["scene_address"] = [each.rays.address for each in self._solids]
        self._views["own_body"] = [world.vehicle_body_id for world in worlds]
        # The calling thread casts too.
        self._n_helpers = min(n_threads or os.cpu_count() or 1, n) - 1
        self._pool = ThreadPoolExecutor(self._n_helpers, "images") if self._n_helpers else None
        compile_ahead(cast_images, example_arguments(), "image kernels", _COMPILE_SECONDS)

    def render(
        self,
        position_enu_m: Float[np.ndarray, "n 3"],
        rotation_enu_from_flu: Float[np.ndarray, "n 3 3"],
        whose: Sequence[int] | None = None,
    ) -> dict[str, np.ndarray]:
        """Return images (k, h, w) by name: `depth` along the axis up to `FAR_M`, and the segments.

        Args:
            position_enu_m: True positions of all vehicles.
            rotation_enu_from_flu: Their true attitudes.
            whose: Numbers of the k vehicles to take images of; None takes all.
        """
        eyes_enu_m = (rotation_enu_from_flu @ self._eyes_flu_m[:, :, None])[..., 0]
        self._views["position_enu_m"] = position_enu_m + eyes_enu_m
        self._views["rotation_enu_from_optical"] = rotation_enu_from_flu @ self._turns
        numbers = np.arange(len(self._views)) if whose is None else np.array(whose)
        shape = (len(numbers), *self._size)
        depth_m, hits = np.empty(shape, np.float32), np.empty(shape, np.int32)
        self._cast(self._views[numbers], self._rays[numbers], depth_m, hits)
        images = {"depth": np.minimum(depth_m, np.float32(FAR_M)) if self._segments else depth_m}
        for name in self._segments:
            images[name] = np.empty(shape, SEGMENT_DTYPES[name])
            for image, hit, i in zip(images[name], hits, numbers, strict=True):
                image[:] = self._tables[i][name][hit]
        return images

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _cast(self, *task: np.ndarray) -> None:
        """Cast the images of some cameras on all threads; `task` has arguments of `cast_images`."""
        # Threads take images from this counter, so that none waits for a slower one.
        counter = np.zeros(1, np.int64)
        query, pool = functions().intersect, self._pool
        n_helpers = min(self._n_helpers, len(task[0]) - 1)
        helpers = (
            [pool.submit(cast_images, query, counter, *task) for _ in range(n_helpers)]
            if pool
            else []
        )
        cast_images(query, counter, *task)
        for helper in helpers:
            # Raises what a helper has raised.
            helper.result()


def _mount(airframe: Airframe, camera: CameraName) -> CameraMount:
    return next(mount for mount in airframe.cameras if mount.name == camera)


class _Solids:
    """All static solids of a world that can be touched.

    Attributes:
        rays: Its triangles.
        geoms: Geom of each triangle.
    """

    def __init__(self, world: World) -> None:
        model, data = world.model, world.new_data()
        geoms = np.flatnonzero((model.geom_bodyid == 0) & (model.geom_contype > 0))
        parts = [
            geom_triangles(model, geom) @ data.geom_xmat[geom].reshape(3, 3).T
            + data.geom_xpos[geom]
            for geom in geoms.tolist()
        ]
        self.geoms = np.repeat(geoms, [len(part) for part in parts])
        self.rays = RayScene(np.concatenate(parts))


def _tables(worlds: Sequence[World], solids: list[_Solids]) -> list[dict[str, np.ndarray]]:
    """The meaning of each hit of `cast_images` for each vehicle, by the names of the images."""
    known: dict[tuple[int, int], dict[str, np.ndarray]] = {}
    for world, standing in zip(worlds, solids, strict=True):
        # Hits below zero, for nothing and for moving geoms, count from the end.
        ids = world.geom_object_id
        objects = np.concatenate([ids[standing.geoms], ids[::-1], [NO_OBJECT_ID]])
        objects = objects.astype(SEGMENT_DTYPES["objects"])
        tables = {"objects": objects, "classes": Classes(world).of(objects)}
        known[id(world.rays), world.number] = tables
    return [known[id(world.rays), world.number] for world in worlds]
