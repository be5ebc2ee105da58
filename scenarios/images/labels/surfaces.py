"""Surface normals by ray casting: exact on every pixel, where depth images have only differences.

The rays meet the surfaces that the camera draws, without the thin layers of light on them.
"""

from __future__ import annotations

import mujoco
import numpy as np
from jaxtyping import Float, Float32

from flightsim.looks.drawing import drawn_mesh
from flightsim.looks.rays import RayScene
from flightsim.looks.surfaces import FAST
from flightsim.world import World
from scenarios.images.labels.projection import Pinhole


class Surfaces:
    """Triangles of a world, of what stands and of what moves."""

    def __init__(self, world: World) -> None:
        """Gather the triangles of what stands."""
        self._world = world
        mesh = drawn_mesh(world.scene, world.solids, FAST, world.light)
        self._standing = _Triangles(mesh.corners_enu_m())

    def normals(
        self, camera: Pinhole, data: mujoco.MjData
    ) -> tuple[Float32[np.ndarray, "h w 3"], Float32[np.ndarray, "h w"]]:
        """Return the normals that a camera sees, and the depth of the rays.

        Args:
            camera: Camera.
            data: State of the world, for what moves.

        Returns:
            Unit normals in the optical frame, which point to the camera's side, 0 in the sky; and
            depth in m, inf in the sky.
        """
        turn = camera.pose.rotation_enu_from_optical.astype(np.float32)
        rays = camera.rays().astype(np.float32).reshape(-1, 3) @ turn.T
        depth_m, normals = self._standing.met(camera, rays)
        moving, _ = self._world.movers.triangles_enu(data)
        if len(moving):
            near_m, near_normals = _Triangles(moving).met(camera, rays)
            is_nearer = near_m < depth_m
            depth_m[is_nearer], normals[is_nearer] = near_m[is_nearer], near_normals[is_nearer]
        shape = (camera.height, camera.width)
        return normals.reshape(*shape, 3), depth_m.reshape(shape)


class _Triangles:
    """Triangles with their normals, prepared for rays."""

    def __init__(self, corners_enu_m: Float[np.ndarray, "t 3 3"]) -> None:
        self._rays = RayScene(corners_enu_m.astype(np.float32))
        self._first_enu_m = corners_enu_m[:, 0]
        a, b, c = corners_enu_m.transpose(1, 0, 2)
        across = np.cross(b - a, c - a)
        self._normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)

    def met(
        self, camera: Pinhole, rays_enu: Float32[np.ndarray, "n 3"]
    ) -> tuple[Float32[np.ndarray, " n"], Float32[np.ndarray, "n 3"]]:
        """Return depth and normal in the optical frame at the first hit of each ray."""
        eye = camera.pose.position_enu_m
        hits = self._rays.first_hits(eye, rays_enu)
        # A plane is seen from one side by all rays of an eye. Thin things are drawn from both.
        is_away = np.einsum("ti,ti->t", self._normals, self._first_enu_m - eye) > 0.0
        facing = np.where(is_away[:, None], -self._normals, self._normals)
        table = (facing @ camera.pose.rotation_enu_from_optical).astype(np.float32)
        # The last entry stands for `NOTHING`, which is -1.
        return hits.distance, np.vstack([table, np.zeros((1, 3), np.float32)])[hits.triangle]
