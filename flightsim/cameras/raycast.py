"""RGB-D renderer by ray casting with Embree, for machines without OpenGL.

Depth and object ids equal those of the OpenGL renderer, colours nearly: the paints, light and sky
are the same, with coarser texture far away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from aeroscene.neighbourhood import neighbours_of
from autonomy.types import Vector3
from flightsim.cameras.air import Air
from flightsim.cameras.fine_picture import SAMPLES, FineLight, vehicle_triangles
from flightsim.cameras.mates import MateShapes
from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.cameras.raycast_paint import PaintedMesh
from flightsim.cameras.view import (
    NO_OBJECT_ID,
    PoseCopy,
    PosedDepth,
    Quality,
    RgbdFrame,
    Viewpoint,
    look_at,
)
from flightsim.looks.bake import lit
from flightsim.looks.drawing import drawn_mesh
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.light import Light
from flightsim.looks.mesh import WorldMesh
from flightsim.looks.rays import RayScene
from flightsim.looks.surfaces import FAST, FINE
from flightsim.world import World

_MIN_OPACITY = 0.5


@dataclass(frozen=True, eq=False)
class _Picture:
    """For each ray: depth along the axis (inf for nothing), colour 0 to 1 with or without light."""

    depth_m: np.ndarray
    rgb: np.ndarray


class RaycastCameraRenderer:
    """Frames by Embree; see `CameraRenderer`."""

    backend: Literal["gl", "raycast"] = "raycast"

    def __init__(self, world: World, width: int, height: int, reason: str) -> None:
        self.reason = reason
        self._world = world
        self._width, self._height = width, height
        self._model = world.as_seen()
        self._poses = PoseCopy(self._model, world.camera_name)
        self._mates = MateShapes(world, self._model)
        light = world.light
        mesh = drawn_mesh(world.scene, world.solids, FAST, light)
        solids = (*world.solids, *neighbours_of(world.scene))
        whole = lit(mesh, solids, world.scene.relief, light)
        far_m = _far_m(world.model)
        self._fast = _Stage(whole.surfaces, far_m, light, is_lit=True, layers=whole.layers)
        self._air = Air(world)
        self._fine: tuple[_Stage, FineLight] | None = None
        self._ids: _Ids | None = None

    def render(self, data: mujoco.MjData, camera_name: str, time_us: int) -> RgbdFrame:
        """Return a frame of an on-board camera; see `CameraRenderer`."""
        self._poses.update(data)
        view = self._poses.viewpoint(camera_name)
        return self._frame(view, time_us, self._cast(view, has_vehicle=False))

    def render_from(self, data: mujoco.MjData, view: Viewpoint, time_us: int) -> RgbdFrame:
        """Return a frame from a viewpoint; see `CameraRenderer`."""
        self._poses.update(data)
        return self._frame(view, time_us, self._cast(view, has_vehicle=False))

    def render_depth(self, data: mujoco.MjData, camera_name: str, time_us: int) -> PosedDepth:
        """Return depth alone; see `CameraRenderer`."""
        self._poses.update(data)
        view = self._poses.viewpoint(camera_name)
        depth_m = self._cast(view, has_vehicle=False).depth_m
        return view.depth_frame(time_us, depth_m.reshape(self._height, self._width))

    def render_ids(self, data: mujoco.MjData, camera_name: str) -> np.ndarray:
        """Return object ids; see `CameraRenderer`."""
        self._poses.update(data)
        return self._ids_from(self._poses.viewpoint(camera_name))

    def render_ids_from(self, data: mujoco.MjData, view: Viewpoint) -> np.ndarray:
        """See `CameraRenderer`."""
        self._poses.update(data)
        return self._ids_from(view)

    def _ids_from(self, view: Viewpoint) -> np.ndarray:
        if self._ids is None:
            self._ids = _Ids(self._world, self._poses.data, self._mates)
        rays = view.rays_enu(self._width, self._height)
        moving_enu_m, _ = self._moving(has_vehicle=False)
        ids = self._ids.seen(view.position_enu_m, rays.reshape(-1, 3), moving_enu_m)
        return ids.reshape(self._height, self._width)

    def render_view(
        self,
        data: mujoco.MjData,
        eye_enu_m: Vector3,
        target_enu_m: Vector3,
        vertical_fov_rad: float = math.radians(50.0),
        quality: Quality = "fast",
    ) -> RgbdFrame:
        """Return a picture from anywhere; see `CameraRenderer`."""
        self._poses.update(data)
        view = look_at(eye_enu_m, target_enu_m, vertical_fov_rad)
        time_us = round(data.time * 1e6)
        if quality == "fast":
            return self._frame(view, time_us, self._cast(view, has_vehicle=True))
        if self._fine is None:
            mesh = drawn_mesh(self._world.scene, self._world.solids, FINE, self._world.light)
            self._fine = (
                _Stage(mesh, _far_m(self._world.model), self._world.light, is_lit=False),
                FineLight(self._world, self._air),
            )
        stage, light = self._fine
        width, height = SAMPLES * self._width, SAMPLES * self._height
        picture = stage.cast(view, width, height)
        moving_enu_m, moving_rgb = self._moving(has_vehicle=True)
        picture = _with_moving(picture, view, width, height, moving_enu_m, moving_rgb)
        shape = (height, width)
        colours, depth_m = picture.rgb.reshape(*shape, 3), picture.depth_m.reshape(shape)
        return light.frame(view, time_us, colours, depth_m, moving_enu_m)

    def close(self) -> None:
        """Drop what was prepared for fine pictures and ids; see `CameraRenderer`."""
        self._fine = self._ids = None

    def _cast(self, view: Viewpoint, *, has_vehicle: bool) -> _Picture:
        picture = self._fast.cast(view, self._width, self._height)
        corners, rgb = self._moving(has_vehicle=has_vehicle)
        if not len(corners):
            return picture
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
        # Moving surfaces are lit by sun and sky everywhere: shadows on them would cost rays.
        everywhere = np.ones(len(normals))
        light = self._world.light
        lit_rgb = rgb * light.rgb(light.surface(normals, everywhere, everywhere))
        return _with_moving(picture, view, self._width, self._height, corners, lit_rgb)

    def _moving(self, *, has_vehicle: bool) -> tuple[np.ndarray, np.ndarray]:
        """Triangles of movers, of other vehicles and perhaps of this one, and their colours."""
        data = self._poses.data
        parts = [self._world.movers.triangles_enu(data), self._mates.triangles_enu(data)]
        if has_vehicle:
            parts.insert(0, vehicle_triangles(self._model, data))
        corners, rgb = zip(*parts, strict=True)
        return np.concatenate(corners), np.concatenate(rgb)

    def _frame(self, view: Viewpoint, time_us: int, picture: _Picture) -> RgbdFrame:
        shape = (self._height, self._width)
        rgb = (255.0 * np.minimum(picture.rgb, 1.0) + 0.5).astype(np.uint8).reshape(*shape, 3)
        depth_m = picture.depth_m.reshape(shape)
        self._air.paint(rgb, depth_m, view, time_us)
        return view.frame(time_us, rgb, depth_m)


class _Stage:
    """A painted mesh, and how far it is drawn."""

    def __init__(
        self,
        mesh: WorldMesh,
        far_m: float,
        light: Light,
        *,
        is_lit: bool,
        layers: WorldMesh | None = None,
    ) -> None:
        self._mesh = PaintedMesh(mesh, light, is_lit=is_lit)
        self._layers = None
        if layers is not None and len(layers.triangles) > 0:
            self._layers = PaintedMesh(layers, light, is_lit=is_lit)
        self._far_m = far_m

    def cast(self, view: Viewpoint, width: int, height: int) -> _Picture:
        """Return the first hits of unit-depth rays through all pixels."""
        eye, focal_px = view.position_enu_m, view.focal_px(height)
        rays = view.rays_enu(width, height).reshape(-1, 3)
        hits = self._mesh.hits(eye, rays).within(self._far_m)
        rgb = np.zeros((len(rays), 3), dtype=np.float32)
        met, colours = self._mesh.colours(hits, focal_px)
        rgb[met] = colours
        if self._layers is not None:
            # Layers lie just before their surfaces, and only colours have them.
            met, colours = self._layers.colours(
                self._layers.hits(eye, rays).within(hits.distance), focal_px
            )
            rgb[met] = colours
        return _Picture(hits.distance.astype(np.float32), rgb)


def _with_moving(
    picture: _Picture,
    view: Viewpoint,
    width: int,
    height: int,
    corners_enu_m: np.ndarray,
    rgb: np.ndarray,
) -> _Picture:
    """Return the picture with triangles of one colour each drawn over it."""
    rays = view.rays_enu(width, height).reshape(-1, 3)
    hits = RayScene(corners_enu_m).first_hits(view.position_enu_m, rays)
    is_nearer = hits.distance < picture.depth_m
    colours = picture.rgb.copy()
    colours[is_nearer] = rgb[hits.triangle[is_nearer]]
    return _Picture(np.minimum(hits.distance, picture.depth_m).astype(np.float32), colours)


class _Ids:
    """Solids of the physics, for the object of each surface."""

    def __init__(self, world: World, data: mujoco.MjData, mates: MateShapes) -> None:
        model = world.model
        shown = (model.geom_group == GeomGroup.SCENE) | (model.geom_group == GeomGroup.DECOR)
        # Glass panes and foliage are looked through, as in the OpenGL renderer.
        geom_ids = np.flatnonzero(shown & (model.geom_rgba[:, 3] >= _MIN_OPACITY))
        parts = [
            geom_triangles(model, g) @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g]
            for g in geom_ids.tolist()
        ]
        counts = [len(part) for part in parts]
        # The last entry is for Embree's "nothing", -1.
        self._id = np.append(
            np.repeat(world.geom_object_id[geom_ids], counts), NO_OBJECT_ID
        ).astype(np.int32)
        is_mover = model.geom_group == GeomGroup.MOVING
        mover_id = np.repeat(world.geom_object_id[is_mover], world.movers.triangle_counts())
        self._moving_id = np.append(mover_id, world.geom_object_id[mates.geoms]).astype(np.int32)
        self._rays = RayScene(np.concatenate(parts))
        self._far_m = _far_m(model)

    def seen(
        self, eye_enu_m: np.ndarray, rays_enu: np.ndarray, moving_enu_m: np.ndarray
    ) -> np.ndarray:
        """Return the object id (n,) int32 of each ray's first hit.

        Args:
            eye_enu_m: Origin of all rays.
            rays_enu: Directions, (n, 3).
            moving_enu_m: Triangles of movers and other vehicles where they are now, (t, 3, 3).
        """
        hits = self._rays.first_hits(eye_enu_m, rays_enu).within(self._far_m)
        ids = self._id[hits.triangle]
        if len(moving_enu_m):
            moving = RayScene(moving_enu_m).first_hits(eye_enu_m, rays_enu)
            is_nearer = moving.distance < hits.distance
            ids[is_nearer] = self._moving_id[moving.triangle[is_nearer]]
        return ids


def _far_m(model: mujoco.MjModel) -> float:
    """Depth up to which OpenGL draws, m."""
    return float(model.vis.map.zfar * model.stat.extent)
