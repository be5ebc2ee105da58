"""RGB-D by ray casting with Embree: for machines where no OpenGL library loads.

Depth and object ids are those of the OpenGL renderer; the colours are plain (material, sun, ambient
light, sky), without textures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from autonomy.model.quadrotor import Vector3
from flightsim.geom_groups import GeomGroup
from flightsim.sensors.camera import NO_OBJECT_ID, PoseCopy, Quality, RgbdFrame, Viewpoint, look_at
from flightsim.sensors.raycast_mesh import geom_triangles
from flightsim.sensors.sky import sky_rgb
from flightsim.world import World

_NOTHING = -1
_MIN_OPACITY = 0.5
# The headlight shines from the eye; its cosine is replaced by its mean over a hemisphere's
# directions, which lets a triangle have one colour.
_MEAN_HEADLIGHT_COSINE = 0.5


@dataclass
class _Hits:
    """What each ray meets: depth along the axis (inf nothing), geom (-1 nothing), colour."""

    depth_m: np.ndarray
    geom_id: np.ndarray
    rgb: np.ndarray

    def take_nearer(self, other: _Hits) -> None:
        """Replace what is behind the other's."""
        is_nearer = other.depth_m < self.depth_m
        for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True):
            mine[is_nearer] = theirs[is_nearer]


class _Light:
    """The model's headlight and sun, without shadows, about as its OpenGL renderer applies them."""

    def __init__(self, model: mujoco.MjModel) -> None:
        headlight: Any = model.vis.headlight
        self._base = np.asarray(headlight.ambient) + _MEAN_HEADLIGHT_COSINE * np.asarray(
            headlight.diffuse
        )
        self._suns = list(zip(model.light_dir.copy(), model.light_diffuse.copy(), strict=True))

    def shade(self, rgb: np.ndarray, normals_enu: np.ndarray) -> np.ndarray:
        """(n, 3) uint8: light that leaves surfaces of these colours."""
        light = np.tile(self._base, (len(rgb), 1))
        for direction, diffuse in self._suns:
            light += np.maximum(0.0, -(normals_enu @ direction))[:, None] * diffuse
        return (255.0 * np.clip(rgb * light, 0.0, 1.0) + 0.5).astype(np.uint8)


class _Body:
    """The visible geoms of one body, as one Embree scene in the body's frame.

    Arrays by triangle have a last row for "nothing", which Embree's index -1 then finds.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, geom_ids: list[int], light: _Light
    ) -> None:
        self.body_id = int(model.geom_bodyid[geom_ids[0]])
        rotation, origin = self._pose(data)
        parts = []
        for g in geom_ids:
            in_world = geom_triangles(model, g) @ data.geom_xmat[g].reshape(3, 3).T
            parts.append((in_world + data.geom_xpos[g] - origin) @ rotation)
        triangles = np.concatenate(parts)
        counts = [len(part) for part in parts]
        self._geom_id = np.append(np.repeat(geom_ids, counts), _NOTHING).astype(np.int32)
        self._colours = np.repeat(model.geom_rgba[geom_ids, :3], counts, axis=0)
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        self._normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        self._light = light
        self._static_rgb = self._shade(rotation) if model.body_weldid[self.body_id] == 0 else None
        self._scene = EmbreeScene()
        # Held: the scene refers to it.
        self._mesh = TriangleMesh(self._scene, triangles.astype(np.float32))

    def cast(self, data: mujoco.MjData, eye_enu_m: np.ndarray, rays_enu: np.ndarray) -> _Hits:
        """What rays of unit depth, (n, 3) float32, meet of this body."""
        rotation, origin = self._pose(data)
        rays = rays_enu @ rotation.astype(np.float32)
        eye = ((eye_enu_m - origin) @ rotation).astype(np.float32)
        eyes = np.broadcast_to(eye, rays.shape).copy()
        result = self._scene.run(eyes, rays, query="INTERSECT", output=True)
        triangle = result["primID"]
        depth_m = np.where(triangle == _NOTHING, np.float32(np.inf), result["tfar"])
        rgb = self._shade(rotation) if self._static_rgb is None else self._static_rgb
        return _Hits(depth_m, self._geom_id[triangle], rgb[triangle])

    def _pose(self, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
        return data.xmat[self.body_id].reshape(3, 3), data.xpos[self.body_id]

    def _shade(self, rotation_enu_from_body: np.ndarray) -> np.ndarray:
        rgb = self._light.shade(self._colours, self._normals @ rotation_enu_from_body.T)
        return np.vstack([rgb, np.zeros((1, 3), np.uint8)])


class RaycastCameraRenderer:
    """Frames by Embree; see `CameraRenderer`."""

    backend: Literal["gl", "raycast"] = "raycast"

    def __init__(self, world: World, width: int, height: int, reason: str) -> None:
        self.reason = reason
        self._world = world
        self._width, self._height = width, height
        self._poses = PoseCopy(world.model)
        model = world.model
        light = _Light(model)
        self._surroundings: list[_Body] = []
        self._vehicle: list[_Body] = []
        for body_id in range(model.nbody):
            geom_ids = _visible_geoms(model, body_id)
            if geom_ids:
                bodies = self._vehicle if body_id == world.vehicle_body_id else self._surroundings
                bodies.append(_Body(model, self._poses.data, geom_ids, light))

    def render(self, data: mujoco.MjData, camera_name: str, time_us: int) -> RgbdFrame:
        """See `CameraRenderer`."""
        self._poses.update(data)
        return self._frame(self._poses.viewpoint(camera_name), time_us, self._surroundings)

    def render_ids(self, data: mujoco.MjData, camera_name: str) -> np.ndarray:
        """See `CameraRenderer`."""
        self._poses.update(data)
        view = self._poses.viewpoint(camera_name)
        hits = self._cast(view, view.rays_enu(self._width, self._height), self._surroundings)
        ids = np.where(
            hits.geom_id == _NOTHING, NO_OBJECT_ID, self._world.geom_object_id[hits.geom_id]
        )
        return ids.reshape(self._height, self._width).astype(np.int32)

    def render_view(
        self,
        data: mujoco.MjData,
        eye_enu_m: Vector3,
        target_enu_m: Vector3,
        vertical_fov_rad: float = math.radians(50.0),
        quality: Quality = "fast",
    ) -> RgbdFrame:
        """See `CameraRenderer`; both qualities are the same here."""
        del quality
        self._poses.update(data)
        view = look_at(eye_enu_m, target_enu_m, vertical_fov_rad)
        return self._frame(view, round(data.time * 1e6), self._surroundings + self._vehicle)

    def close(self) -> None:
        """See `CameraRenderer`."""
        self._surroundings.clear()
        self._vehicle.clear()

    def _cast(self, view: Viewpoint, rays: np.ndarray, bodies: list[_Body]) -> _Hits:
        flat = rays.reshape(-1, 3)
        first, *others = (body.cast(self._poses.data, view.position_enu_m, flat) for body in bodies)
        for hits in others:
            first.take_nearer(hits)
        return first

    def _frame(self, view: Viewpoint, time_us: int, bodies: list[_Body]) -> RgbdFrame:
        rays = view.rays_enu(self._width, self._height)
        hits = self._cast(view, rays, bodies)
        is_sky = hits.geom_id == _NOTHING
        hits.rgb[is_sky] = sky_rgb(rays.reshape(-1, 3)[is_sky])
        shape = (self._height, self._width)
        return view.frame(time_us, hits.rgb.reshape(*shape, 3), hits.depth_m.reshape(shape))


def _visible_geoms(model: mujoco.MjModel, body_id: int) -> list[int]:
    """Geoms of a body that cameras see; rays pass what is mostly transparent, such as discs."""
    visible = (GeomGroup.SCENE, GeomGroup.DECOR, GeomGroup.VEHICLE_LOOKS)
    first, count = int(model.body_geomadr[body_id]), int(model.body_geomnum[body_id])
    return [
        g
        for g in range(first, first + count)
        if model.geom_group[g] in visible and model.geom_rgba[g, 3] >= _MIN_OPACITY
    ]
