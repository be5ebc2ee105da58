"""RGB-D by MuJoCo's OpenGL renderer, colour and depth in one pass.

MuJoCo itself culls nothing: geoms whose bounding sphere is outside the view are put into an unseen
group while the scene is gathered.
"""

from __future__ import annotations

import math
from typing import Literal

import mujoco
import numpy as np

from autonomy.model.quadrotor import Vector3
from flightsim.geom_groups import GeomGroup
from flightsim.sensors.camera import NO_OBJECT_ID, PoseCopy, Quality, RgbdFrame, Viewpoint, look_at
from flightsim.sensors.camera_gl_target import GlTarget, new_gl_context
from flightsim.sensors.sky import sky_rgb
from flightsim.world import World

# In fine pictures the sky is MuJoCo's, a box about the eye whose faces are no nearer than this.
_SKY_BOX_SHARE_OF_FAR = 0.4
# Geoms drawn beside the model's own: none today; MuJoCo warns when its buffer is short.
_SPARE_GEOMS = 16


class GlCameraRenderer:
    """Frames by OpenGL; see `CameraRenderer`."""

    backend: Literal["gl", "raycast"] = "gl"

    def __init__(self, world: World, width: int, height: int) -> None:
        self.reason = "OpenGL loads"
        self._model = world.model
        self._geom_object_id = world.geom_object_id
        self._width, self._height = width, height
        self._poses = PoseCopy(world)
        self._gl = new_gl_context(width, height)
        self._targets = {"fast": self._new_target("fast")}
        self._scene = mujoco.MjvScene(world.model, maxgeom=world.model.ngeom + _SPARE_GEOMS)
        self._option = mujoco.MjvOption()
        self._camera = mujoco.MjvCamera()
        extent = world.model.stat.extent
        self._near_m = float(world.model.vis.map.znear * extent)
        self._far_m = float(world.model.vis.map.zfar * extent)

    def render(self, data: mujoco.MjData, camera_name: str, time_us: int) -> RgbdFrame:
        """See `CameraRenderer`."""
        view = self._aim_fixed_camera(data, camera_name)
        return self._draw(view, time_us, quality="fast", has_vehicle=False)

    def render_ids(self, data: mujoco.MjData, camera_name: str) -> np.ndarray:
        """See `CameraRenderer`; a pass of its own."""
        view = self._aim_fixed_camera(data, camera_name)
        flags = self._scene.flags
        id_flags = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
        self._prepare(view, quality="fast", has_vehicle=False)
        for flag in id_flags:
            flags[flag] = True
        try:
            rgb, _ = self._targets["fast"].read(self._scene)
        finally:
            for flag in id_flags:
                flags[flag] = False
        return self._object_ids(rgb)

    def render_view(
        self,
        data: mujoco.MjData,
        eye_enu_m: Vector3,
        target_enu_m: Vector3,
        vertical_fov_rad: float = math.radians(50.0),
        quality: Quality = "fast",
    ) -> RgbdFrame:
        """See `CameraRenderer`."""
        self._poses.update(data)
        view = look_at(eye_enu_m, target_enu_m, vertical_fov_rad)
        self._aim_free_camera(view)
        time_us = round(data.time * 1e6)
        focus = np.array(target_enu_m, dtype=float)
        return self._draw(view, time_us, quality=quality, has_vehicle=True, focus_enu_m=focus)

    def close(self) -> None:
        """See `CameraRenderer`."""
        if self._gl is None:
            return
        self._gl.make_current()
        for target in self._targets.values():
            target.free()
        self._targets.clear()
        self._gl.free()
        self._gl = None

    def _new_target(self, quality: Quality) -> GlTarget:
        return GlTarget(self._model, self._width, self._height, quality)

    def _aim_fixed_camera(self, data: mujoco.MjData, camera_name: str) -> Viewpoint:
        self._poses.update(data)
        view = self._poses.viewpoint(camera_name)
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._camera.fixedcamid = self._model.camera(camera_name).id
        return view

    def _aim_free_camera(self, view: Viewpoint) -> None:
        _, _, forward = view.rotation_enu_from_optical.T
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        self._camera.distance = 1.0
        self._camera.lookat[:] = view.position_enu_m + forward
        self._camera.elevation = math.degrees(math.asin(max(-1.0, min(1.0, forward[2]))))
        right = view.rotation_enu_from_optical[:, 0]
        self._camera.azimuth = math.degrees(math.atan2(right[0], -right[1]))

    def _draw(
        self,
        view: Viewpoint,
        time_us: int,
        *,
        quality: Quality,
        has_vehicle: bool,
        focus_enu_m: np.ndarray | None = None,
    ) -> RgbdFrame:
        self._prepare(view, quality=quality, has_vehicle=has_vehicle)
        target = self._targets[quality]
        if quality == "fine" and focus_enu_m is not None:
            target.cast_shadows_around(self._scene, focus_enu_m, view)
        rgb, buffer = target.read(self._scene)
        depth_m = self._metres(buffer)
        if quality == "fast":
            depth_m[buffer <= 0] = np.inf
            self._paint_sky(rgb, depth_m, view)
        else:
            depth_m[depth_m > _SKY_BOX_SHARE_OF_FAR * self._far_m] = np.inf
        return view.frame(time_us, rgb, depth_m)

    def _paint_sky(self, rgb: np.ndarray, depth_m: np.ndarray, view: Viewpoint) -> None:
        """MuJoCo's own sky is a box with a depth of its own, which could pass for a wall."""
        is_sky = np.isinf(depth_m)
        rgb[is_sky] = sky_rgb(view.rays_enu(self._width, self._height)[is_sky])

    def _prepare(self, view: Viewpoint, *, quality: Quality, has_vehicle: bool) -> None:
        if self._gl is None:
            raise RuntimeError("the renderer is closed")
        self._gl.make_current()
        if quality not in self._targets:
            self._targets[quality] = self._new_target(quality)
        self._set_options(is_fine=quality == "fine", has_vehicle=has_vehicle)
        self._gather(view, is_culled=quality == "fast")

    def _set_options(self, *, is_fine: bool, has_vehicle: bool) -> None:
        groups = self._option.geomgroup
        groups[:] = 0
        groups[GeomGroup.SCENE] = groups[GeomGroup.DECOR] = 1
        groups[GeomGroup.VEHICLE_LOOKS] = has_vehicle
        flags = self._scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = is_fine
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        flags[mujoco.mjtRndFlag.mjRND_HAZE] = False
        flags[mujoco.mjtRndFlag.mjRND_FOG] = False
        flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = is_fine

    def _gather(self, view: Viewpoint, *, is_culled: bool) -> None:
        """Fill MuJoCo's scene from the model; a free camera's field of view is the model's."""
        groups = self._model.geom_group
        saved_groups, saved_fov = groups.copy(), self._model.vis.global_.fovy
        self._model.vis.global_.fovy = math.degrees(view.vertical_fov_rad)
        if is_culled:
            groups[~self._in_view(view)] = GeomGroup.CULLED
        try:
            mujoco.mjv_updateScene(
                self._model,
                self._poses.data,
                self._option,
                None,
                self._camera,
                mujoco.mjtCatBit.mjCAT_ALL,
                self._scene,
            )
        finally:
            groups[:] = saved_groups
            self._model.vis.global_.fovy = saved_fov

    def _in_view(self, view: Viewpoint) -> np.ndarray:
        """(ngeom,) bool: whether the geom's bounding sphere meets the view's pyramid."""
        radius = self._model.geom_rbound
        local = (self._poses.data.geom_xpos - view.position_enu_m) @ view.rotation_enu_from_optical
        x, y, z = np.abs(local[:, 0]), np.abs(local[:, 1]), local[:, 2]
        tan_v = math.tan(view.vertical_fov_rad / 2)
        tan_h = tan_v * self._width / self._height
        is_in = z > -radius
        is_in &= x - tan_h * z < radius * math.hypot(1.0, tan_h)
        is_in &= y - tan_v * z < radius * math.hypot(1.0, tan_v)
        # A plane has no bounding sphere.
        return is_in | (radius == 0)

    def _object_ids(self, id_colours: np.ndarray) -> np.ndarray:
        """(h, w) int32 from MuJoCo's colours for segmentation: 0 sky, else index + 1."""
        bytes_per_pixel = id_colours.astype(np.int32)
        index = bytes_per_pixel @ np.array([1, 1 << 8, 1 << 16], dtype=np.int32)
        table = np.full(self._scene.ngeom + 1, NO_OBJECT_ID, dtype=np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                table[geom.segid + 1] = self._geom_object_id[geom.objid]
        return table[index]

    def _metres(self, buffer: np.ndarray) -> np.ndarray:
        """Depth along the axis from MuJoCo's reversed depth buffer."""
        near, far = self._near_m, self._far_m
        return near * far / (near + buffer * np.float32(far - near))
