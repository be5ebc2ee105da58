"""Depth images of what stands in a world, cast by Embree: the same solids as the physics has.

Embree casts without the interpreter's lock, so that several threads cast at once. Each takes the
next image that nobody has, and no image depends on who cast it.
"""

from __future__ import annotations

import itertools
import os
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
from jaxtyping import Float

from flightsim.looks.rays import RayScene
from flightsim.sensors.cameras.raycast_mesh import geom_triangles
from flightsim.sensors.cameras.view import Viewpoint
from flightsim.vehicles.airframe import Airframe, CameraMount
from flightsim.vehicles.builder import camera_quat_wxyz
from flightsim.world import World
from scenarios.environments.cfg import CameraName

FAR_M = 20.0
"""Depth of everything that is farther away, and of the sky."""


class DepthCameras:
    """One camera on each of many vehicles."""

    def __init__(
        self,
        worlds: list[World],
        size_px: tuple[int, int],
        camera: CameraName,
        n_threads: int | None = None,
    ) -> None:
        """Prepare the solids of each scene.

        Args:
            worlds: World of each vehicle.
            size_px: Width and height of the images.
            camera: Name of the camera.
            n_threads: Threads that cast; None takes one for each core.
        """
        self._width, self._height = size_px
        scenes = {id(world.scene): world for world in worlds}
        solids = {key: RayScene(_static_triangles(world)) for key, world in scenes.items()}
        self._solids = [solids[id(world.scene)] for world in worlds]
        mounts = [_mount(world.airframe, camera) for world in worlds]
        self._eyes_flu_m = [np.array(mount.position_flu_m) for mount in mounts]
        self._rays_flu = [self._rays(mount) for mount in mounts]
        self._n_helpers = min(n_threads or os.cpu_count() or 1, len(worlds)) - 1
        self._pool = ThreadPoolExecutor(self._n_helpers, "depth") if self._n_helpers else None

    def render(
        self, position_enu_m: Float[np.ndarray, "n 3"], rotation_enu_from_flu: np.ndarray
    ) -> Float[np.ndarray, "n h w"]:
        """Depth along the axis of each camera, up to `FAR_M`.

        Args:
            position_enu_m: True positions of the vehicles.
            rotation_enu_from_flu: Their true attitudes (n, 3, 3).
        """
        images = np.empty((len(self._solids), self._height, self._width), dtype=np.float32)
        numbers = itertools.count()

        def cast() -> None:
            while (i := next(numbers)) < len(images):
                rotation = rotation_enu_from_flu[i]
                eye = (position_enu_m[i] + rotation @ self._eyes_flu_m[i]).astype(np.float32)
                rays = self._rays_flu[i] @ rotation.T.astype(np.float32)
                depth_m = self._solids[i].distances(eye, rays, FAR_M)
                images[i] = depth_m.reshape(images[i].shape)

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
        flu_from_camera = np.empty(9)
        mujoco.mju_quat2Mat(flu_from_camera, np.array(camera_quat_wxyz(mount)))
        view = Viewpoint(
            name=mount.name,
            position_enu_m=np.zeros(3),
            rotation_enu_from_optical=flu_from_camera.reshape(3, 3) * np.array([1.0, -1.0, -1.0]),
            vertical_fov_rad=mount.vertical_fov_rad,
        )
        return view.rays_enu(self._width, self._height).reshape(-1, 3)


def _mount(airframe: Airframe, camera: CameraName) -> CameraMount:
    return next(mount for mount in airframe.cameras if mount.name == camera)


def _static_triangles(world: World) -> Float[np.ndarray, "t 3 3"]:
    """Triangles of all that stands and can be touched."""
    model, data = world.model, world.new_data()
    is_static = (model.geom_bodyid == 0) & (model.geom_contype > 0)
    return np.concatenate(
        [
            geom_triangles(model, geom) @ data.geom_xmat[geom].reshape(3, 3).T
            + data.geom_xpos[geom]
            for geom in np.flatnonzero(is_static).tolist()
        ]
    )
