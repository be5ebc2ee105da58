"""RGB-D renderer by MuJoCo's OpenGL, colour and depth in one pass.

MuJoCo itself culls nothing: while the scene is gathered, geoms whose bounding sphere is outside the
view are moved to an invisible group. Each kind of picture has a stage of its own, whose model suits
it: images of depth alone need no textures, which cost more than everything else.

Layers of light, which are shadows and pools of lamplight, have colours but no depth: MuJoCo draws
translucent geoms after all others and without depth, and the layers are translucent enough to count
as such. The discs of rotors are translucent too, and MuJoCo would draw some of them before a layer
that lies behind them. While a disc is in view, layers are therefore drawn opaque, and depth is
drawn apart.
"""

from __future__ import annotations

import math
from typing import Literal

import mujoco
import numpy as np

from autonomy.types import Vector3
from flightsim.cameras.air import Air
from flightsim.cameras.fine_picture import SAMPLES, FineLight, vehicle_triangles
from flightsim.cameras.gl_target import GlTarget, GlUnavailableError, new_gl_context
from flightsim.cameras.mates import MateShapes
from flightsim.cameras.view import (
    NO_OBJECT_ID,
    PoseCopy,
    PosedDepth,
    Quality,
    RgbdFrame,
    Viewpoint,
    look_at,
)
from flightsim.looks.drawing import LAYER_OPACITY
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.surfaces import BARE, FAST, FINE
from flightsim.world import World

# Geoms besides the model's own: none today; MuJoCo warns when its buffer is too small.
_SPARE_GEOMS = 16
_Kind = Literal["fast", "fine", "depth", "ids"]
"""Kind of picture that a stage draws."""
_TRANSLUCENT_BELOW = 0.995
"""Opacity below which MuJoCo draws a geom after the others and without depth."""
_LEVEL = 1e-6
"""Sine of a roll that no picture shows."""
_ID_FLAGS = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)


class GlCameraRenderer:
    """Frames by OpenGL; see `CameraRenderer`."""

    backend: Literal["gl", "raycast"] = "gl"

    def __init__(self, world: World, width: int, height: int) -> None:
        self.reason = "OpenGL loads"
        self._world = world
        self._size = (width, height)
        self._gl = new_gl_context(width, height)
        self._stages: dict[str, _Stage] = {}
        self._fine_light: FineLight | None = None
        self._air = Air(world)
        try:
            self._stage("depth")
        except mujoco.FatalError as error:
            # A context opened, but not one that MuJoCo can draw with.
            raise GlUnavailableError(f"MuJoCo: {error}") from error

    def render(self, data: mujoco.MjData, camera_name: str, time_us: int) -> RgbdFrame:
        """Return a frame of an on-board camera; see `CameraRenderer`."""
        stage = self._stage("fast")
        stage.poses.update(data)
        return self._fast(stage, stage.poses.viewpoint(camera_name), time_us, has_vehicle=False)

    def render_from(self, data: mujoco.MjData, view: Viewpoint, time_us: int) -> RgbdFrame:
        """Return a frame from a viewpoint; see `CameraRenderer`."""
        stage = self._stage("fast")
        stage.poses.update(data)
        return self._fast(stage, view, time_us, has_vehicle=False)

    def render_depth(self, data: mujoco.MjData, camera_name: str, time_us: int) -> PosedDepth:
        """Return depth alone; see `CameraRenderer`.

        It is drawn without a sky and without textures, which cost more than everything else.
        """
        stage = self._stage("depth")
        stage.poses.update(data)
        view = stage.poses.viewpoint(camera_name)
        return view.depth_frame(time_us, stage.draw_depth(view, has_vehicle=False))

    def render_ids(self, data: mujoco.MjData, camera_name: str) -> np.ndarray:
        """Return object ids; see `CameraRenderer`.

        They are drawn from the solids of the physics, each of which belongs to one object.
        """
        stage = self._stage("ids")
        stage.poses.update(data)
        return self._ids(stage, stage.poses.viewpoint(camera_name))

    def render_ids_from(self, data: mujoco.MjData, view: Viewpoint) -> np.ndarray:
        """Return object ids from a viewpoint; see `CameraRenderer`."""
        stage = self._stage("ids")
        stage.poses.update(data)
        return self._ids(stage, view)

    def _ids(self, stage: _Stage, view: Viewpoint) -> np.ndarray:
        colours, _ = stage.draw(view, has_vehicle=False)
        # MuJoCo draws numbers as colours, red first.
        index = colours.astype(np.int32) @ np.array([1, 1 << 8, 1 << 16], dtype=np.int32)
        return stage.object_ids(self._world.geom_object_id)[index]

    def render_view(
        self,
        data: mujoco.MjData,
        eye_enu_m: Vector3,
        target_enu_m: Vector3,
        vertical_fov_rad: float = math.radians(50.0),
        quality: Quality = "fast",
    ) -> RgbdFrame:
        """Return a picture from anywhere; see `CameraRenderer`."""
        view = look_at(eye_enu_m, target_enu_m, vertical_fov_rad)
        stage = self._stage(quality)
        stage.poses.update(data)
        time_us = round(data.time * 1e6)
        if quality == "fine":
            rgb, depth_m = stage.draw(view, has_vehicle=True)
            return self._lit(view, time_us, rgb, depth_m, stage)
        return self._fast(stage, view, time_us, has_vehicle=True)

    def _fast(
        self, stage: _Stage, view: Viewpoint, time_us: int, *, has_vehicle: bool
    ) -> RgbdFrame:
        rgb, depth_m = stage.draw(view, has_vehicle=has_vehicle)
        if stage.has_opaque_layers:
            bare = self._stage("depth")
            bare.poses.update(stage.poses.data)
            depth_m = bare.draw_depth(view, has_vehicle=has_vehicle)
        self._air.paint(rgb, depth_m, view, time_us)
        return view.frame(time_us, rgb, depth_m)

    def _lit(
        self, view: Viewpoint, time_us: int, rgb: np.ndarray, depth_m: np.ndarray, stage: _Stage
    ) -> RgbdFrame:
        if self._fine_light is None:
            self._fine_light = FineLight(self._world, self._air)
        colours = rgb.astype(np.float32) / 255
        movers_enu_m, _ = self._world.movers.triangles_enu(stage.poses.data)
        moving_enu_m = np.concatenate([stage.vehicles_enu_m(), movers_enu_m])
        return self._fine_light.frame(view, time_us, colours, depth_m, moving_enu_m)

    def close(self) -> None:
        """Release buffers and context; see `CameraRenderer`. Closing twice is fine."""
        if self._gl is None:
            return
        self._gl.make_current()
        for stage in self._stages.values():
            stage.target.free()
        self._stages.clear()
        self._gl.free()
        self._gl = None

    def _stage(self, kind: _Kind) -> _Stage:
        """Stage for a kind of picture, created on first use, with its context made current."""
        if self._gl is None:
            raise RuntimeError("the renderer is closed")
        self._gl.make_current()
        if kind not in self._stages:
            width, height = self._size
            if kind == "fine":
                width, height = SAMPLES * width, SAMPLES * height
            self._stages[kind] = _Stage(self._world, kind, width, height)
        return self._stages[kind]


def _drawn_model(world: World, kind: _Kind) -> mujoco.MjModel:
    """Model for a kind of picture."""
    if kind == "ids":
        return world.as_seen()
    if kind == "depth":
        return world.new_looks(BARE)
    if kind == "fast":
        return world.new_looks(FAST)
    model = world.new_looks(FINE)
    # Plain colours: rays light them.
    model.vis.headlight.ambient[:] = 1.0
    model.light_diffuse[:] = 0.0
    model.light_specular[:] = 0.0
    model.vis.quality.numslices, model.vis.quality.numstacks = FINE.slices, FINE.stacks
    return model


class _Stage:
    """A model with its poses, scene and buffer for drawing.

    Attributes:
        has_opaque_layers: True if the last picture has layers of light in its depth, because a disc
            was in view.
    """

    def __init__(self, world: World, kind: _Kind, width: int, height: int) -> None:
        self._model = model = _drawn_model(world, kind)
        self._name_in_model = world.camera_name
        self._is_ids = kind == "ids"
        self._aspect = width / height
        self.poses = PoseCopy(model, world.camera_name)
        self._mates = MateShapes(world, model)
        self.target = GlTarget(model, width, height)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + _SPARE_GEOMS)
        self._option = mujoco.MjvOption()
        self.has_opaque_layers = False
        self._is_layer_paint = model.mat_rgba[:, 3] == np.float32(LAYER_OPACITY)
        self._is_disc = (model.geom_matid < 0) & (model.geom_rgba[:, 3] < _TRANSLUCENT_BELOW)
        self._camera = mujoco.MjvCamera()
        # Clip planes in metres, as MuJoCo computes them.
        self._near_m = float(model.vis.map.znear * model.stat.extent)
        self._far_m = float(model.vis.map.zfar * model.stat.extent)
        flags = self._scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        # The caller paints the sky: MuJoCo's is a box whose depth could pass for a wall.
        flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = False
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        flags[mujoco.mjtRndFlag.mjRND_HAZE] = False
        flags[mujoco.mjtRndFlag.mjRND_FOG] = False

    def draw(self, view: Viewpoint, *, has_vehicle: bool) -> tuple[np.ndarray, np.ndarray]:
        """Return colour (h, w, 3) and depth in m (h, w), inf in the sky."""
        self._arrange(view, has_vehicle=has_vehicle)
        rgb, buffer = self.target.read(self._scene)
        return rgb, self._depth_m(buffer)

    def draw_depth(self, view: Viewpoint, *, has_vehicle: bool) -> np.ndarray:
        """Return the depth of `draw`."""
        self._arrange(view, has_vehicle=has_vehicle)
        return self._depth_m(self.target.read_depth(self._scene))

    def _arrange(self, view: Viewpoint, *, has_vehicle: bool) -> None:
        """Fill MuJoCo's scene with the geoms that the view shows."""
        self._aim(view)
        groups = self._option.geomgroup
        groups[:] = 0
        groups[GeomGroup.SCENE] = groups[GeomGroup.DECOR] = groups[GeomGroup.MOVING] = 1
        groups[GeomGroup.VEHICLE_LOOKS] = has_vehicle
        is_in_view = self._in_view(view)
        is_disc = self._is_disc & is_in_view & (groups[self._model.geom_group] > 0)
        self.has_opaque_layers = bool(is_disc.any() and self._is_layer_paint.any())
        opacity = 1.0 if self.has_opaque_layers else LAYER_OPACITY
        self._model.mat_rgba[self._is_layer_paint, 3] = opacity
        self._gather(view, is_in_view)
        # MuJoCo resets these flags after each picture.
        for flag in _ID_FLAGS:
            self._scene.flags[flag] = self._is_ids

    def _depth_m(self, buffer: np.ndarray) -> np.ndarray:
        """Depth of a depth buffer, m."""
        near, far = self._near_m, self._far_m
        # The buffer is 1 at the near and 0 at the far plane, and linear in the inverse of depth.
        depth_m = near * far / (near + buffer * np.float32(far - near))
        depth_m[buffer <= 0] = np.inf
        return depth_m

    def vehicles_enu_m(self) -> np.ndarray:
        """Return the triangles of all vehicles in their poses."""
        own_enu_m, _ = vehicle_triangles(self._model, self.poses.data)
        mates_enu_m, _ = self._mates.triangles_enu(self.poses.data)
        return np.concatenate([own_enu_m, mates_enu_m])

    def object_ids(self, geom_object_id: np.ndarray) -> np.ndarray:
        """Return object ids from the colours of the last picture: 0 is sky, else index + 1."""
        table = np.full(self._scene.ngeom + 1, NO_OBJECT_ID, dtype=np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                table[geom.segid + 1] = geom_object_id[geom.objid]
        return table

    def _aim(self, view: Viewpoint) -> None:
        """Aim MuJoCo's free camera, or use the fixed one of the view's name."""
        name = self._name_in_model(view.name)
        camera_id = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_CAMERA, name)
        if camera_id >= 0:
            self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
            self._camera.fixedcamid = camera_id
            return
        right, _, forward = view.rotation_enu_from_optical.T
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        self._camera.distance = 1.0
        self._camera.lookat[:] = view.position_enu_m + forward
        self._camera.elevation = math.degrees(math.asin(max(-1.0, min(1.0, forward[2]))))
        # Straight down only the right side has an azimuth. If the camera is rolled, only the axis
        # has the right one, and it is not vertical then.
        north, east = (right[0], -right[1]) if abs(right[2]) < _LEVEL else (forward[1], forward[0])
        self._camera.azimuth = math.degrees(math.atan2(north, east))

    def _gather(self, view: Viewpoint, is_in_view: np.ndarray) -> None:
        """Fill MuJoCo's scene from the model; a free camera's field of view is the model's."""
        groups = self._model.geom_group
        saved_groups, saved_fov = groups.copy(), self._model.vis.global_.fovy
        self._model.vis.global_.fovy = math.degrees(view.vertical_fov_rad)
        groups[~is_in_view] = GeomGroup.CULLED
        try:
            mujoco.mjv_updateScene(
                self._model,
                self.poses.data,
                self._option,
                None,
                self._camera,
                mujoco.mjtCatBit.mjCAT_ALL,
                self._scene,
            )
        # Restored even after an error: the model is used for every picture.
        finally:
            groups[:] = saved_groups
            self._model.vis.global_.fovy = saved_fov
        if self._camera.type == mujoco.mjtCamera.mjCAMERA_FREE:
            self._roll(view)

    def _roll(self, view: Viewpoint) -> None:
        """Turn the picture about its axis: MuJoCo's free camera keeps its right side level."""
        right, down, _ = view.rotation_enu_from_optical.T
        if abs(right[2]) < _LEVEL and down[2] <= 0.0:
            return
        for eye in self._scene.camera:
            eye.up[:] = -down

    def _in_view(self, view: Viewpoint) -> np.ndarray:
        """Return true for geoms whose bounding sphere meets the view's pyramid, (ngeom,) bool."""
        radius = self._model.geom_rbound
        local = (self.poses.data.geom_xpos - view.position_enu_m) @ view.rotation_enu_from_optical
        x, y, z = np.abs(local[:, 0]), np.abs(local[:, 1]), local[:, 2]
        tan_v = math.tan(view.vertical_fov_rad / 2)
        tan_h = tan_v * self._aspect
        is_in = z > -radius
        # Distance from a side of the pyramid: the hypotenuse is the length of its normal.
        is_in &= x - tan_h * z < radius * math.hypot(1.0, tan_h)
        is_in &= y - tan_v * z < radius * math.hypot(1.0, tan_v)
        # A plane has no bounding sphere.
        return is_in | (radius == 0)
