"""Views of a scene: presets that suit any scene.

No fixed eye suits every scene: a house stands where the next scene has a square. So each preset
proposes many views, a small renderer draws all of them, and the one that shows most is taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from aeroscene.scene import Scene
from aeroscene.scene.catalogue import PARKING, ROOMS, WAYS
from autonomy.types import Vector3, vector3
from flightsim.cameras import CameraRenderer, RgbdFrame
from flightsim.cameras.framing import frame_points
from flightsim.world import World

Preset = Literal["overview", "top", "aerial", "street", "forward", "down", "inside", "chase"]

# The sun stands in the south-west: from there faces are lit, and shadows fall to the right.
_OVERVIEW_AZIMUTH_DEG = -118.0
_OVERVIEW_ELEVATION_DEG = 31.0
_STREET_EYE_M = 2.6  # eyes above ground: a standing person's, raised a little over cars
_FLIGHT_M = 7.0  # height of a vehicle's cameras outdoors
_INSIDE_EYE_M = 1.9  # eyes above floors
_TRIAL_YAWS = 24  # directions from each eye, fewer if there are many eyes
# Distances below which something counts as right before the lens, by preset. In the air the whole
# scene is to be seen; a vehicle in the foreground needs free air around it.
_NEAR_M, _NEAR_CHASED_M, _NEAR_IN_AIR_M = 2.4, 9.0, 17.0
_HIGH = ((13.0, 1.0), (19.0, 1.15), (24.0, 1.3))
_LOW = ((8.0, 0.75), (9.0, 0.95), (12.0, 1.1))
"""Heights of eyes in m, and their distances from the middle in halves of the scene."""


@dataclass(frozen=True)
class View:
    """A picture to take: eye, point in its middle, and vertical field of view."""

    eye_enu_m: Vector3
    target_enu_m: Vector3
    fov_deg: float


def choose_view(world: World, preset: Preset, aspect: float, trial: CameraRenderer) -> View:
    """Choose the view of a scene for a preset.

    Args:
        world: World of the scene.
        preset: Preset; "overview", "top" and "down" are computed, the others tried out.
        aspect: Width of the picture over its height.
        trial: Small renderer of the world, with which views are tried.
    """
    scene = world.scene
    if preset in ("overview", "top"):
        # Not 90: straight down, no direction would be up in the picture.
        elevation = 89.9 if preset == "top" else _OVERVIEW_ELEVATION_DEG
        azimuth = -90.0 if preset == "top" else _OVERVIEW_AZIMUTH_DEG
        eye, target = frame_points(
            _built_points(world),
            azimuth_rad=math.radians(azimuth),
            elevation_rad=math.radians(elevation),
            vertical_fov_rad=math.radians(38.0),
            aspect=aspect,
        )
        return View(eye, target, 38.0)
    if preset == "down":
        eye = _above(scene.start_position_enu_m, _hover_m(scene))
        # A millimetre to the north, so that north is up.
        return View(eye, (eye[0], eye[1] + 1e-3, eye[2] - 1.0), 62.0)
    if preset == "aerial":
        return _best(world, trial, _aerial_views(world, _HIGH, 1.5), _NEAR_IN_AIR_M)
    if preset == "chase":
        return _best(world, trial, _aerial_views(world, _LOW, 6.0), _NEAR_CHASED_M)
    if preset == "inside":
        eyes = _inside_eyes(scene)
        return _best(world, trial, _all_round(eyes, dip=0.14, fov_deg=68.0))
    rise = _STREET_EYE_M if preset == "street" else _hover_m(scene)
    eyes = [_above(scene.start_position_enu_m, rise)]
    if preset == "street":
        eyes += _street_eyes(scene)
    dip = 0.06 if preset == "street" else 0.2
    return _best(world, trial, _all_round(eyes, dip=dip, fov_deg=62.0))


def _hover_m(scene: Scene) -> float:
    # Halfway to the ceiling in low rooms.
    room_m = scene.extent_max_enu_m[2] - scene.start_position_enu_m[2]
    return min(_FLIGHT_M, 0.5 * room_m) if scene.domain == "indoor" else _FLIGHT_M


def _above(point: Vector3, rise_m: float) -> Vector3:
    return (point[0], point[1], point[2] + rise_m)


def _built_points(world: World) -> np.ndarray:
    """Corners (n, 3) of the objects that have solids, for a frame around the built scene."""
    shown = {solid.object_id for solid in world.solids}
    boxes = [obj.bbox.corners() for obj in world.scene.objects if obj.id in shown]
    points = np.concatenate(boxes)
    # Solids may have been cut away above a height, and then boxes reach beyond what is drawn.
    top = max(s.position_enu_m[2] + s.size_m[2] / 2 for s in world.solids)
    points[:, 2] = np.minimum(points[:, 2], top)
    return points


def _street_eyes(scene: Scene) -> list[Vector3]:
    """Places above roads, walks and squares: their middles, and near both ends."""
    grounds = [obj for obj in scene.objects if obj.category in WAYS | PARKING]
    eyes = []
    for ground in grounds:
        x_axis = np.array([math.cos(ground.bbox.yaw_rad), math.sin(ground.bbox.yaw_rad), 0.0])
        for share in (-0.45, 0.0, 0.45):
            middle = np.array(ground.bbox.p) + share * ground.bbox.s[0] * x_axis
            eyes.append(_above(vector3(middle), _STREET_EYE_M))
    return eyes


def _inside_eyes(scene: Scene) -> list[Vector3]:
    """Places in the eight largest rooms, near their corners; above the start without rooms."""
    rooms = sorted(
        (obj for obj in scene.objects if obj.category in ROOMS),
        key=lambda room: -room.bbox.s[0] * room.bbox.s[1],
    )
    eyes = []
    for room in rooms[:8]:
        floor_m = room.bbox.p[2] - room.bbox.s[2] / 2
        turn = room.bbox.yaw_rad
        for x, y in ((-0.4, -0.4), (0.4, -0.4), (-0.4, 0.4), (0.4, 0.4)):
            along, across = x * room.bbox.s[0], y * room.bbox.s[1]
            east = room.bbox.p[0] + along * math.cos(turn) - across * math.sin(turn)
            north = room.bbox.p[1] + along * math.sin(turn) + across * math.cos(turn)
            eyes.append((east, north, floor_m + _INSIDE_EYE_M))
    return eyes or [_above(scene.start_position_enu_m, _INSIDE_EYE_M)]


def _aerial_views(
    world: World, stands: tuple[tuple[float, float], ...], target_m: float
) -> list[View]:
    """Views from the sunny side, over the edge of the scene, onto its middle.

    Args:
        world: World of the scene.
        stands: Heights of eyes in m, and their distances from the middle in halves of the scene.
        target_m: Height of the point in the middle of the pictures.
    """
    points = _built_points(world)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    views = []
    for azimuth_deg in range(-170, -40, 10):
        azimuth = math.radians(azimuth_deg)
        reach = np.array([math.cos(azimuth), math.sin(azimuth)]) * half[:2].mean()
        for height_m, share in stands:
            east, north = middle[:2] + share * reach
            # A little on this side of the middle, so that the near half is not cut off below.
            target = (middle[0] + 0.1 * reach[0], middle[1] + 0.1 * reach[1], target_m)
            views.append(View((east, north, height_m), target, 52.0))
    return views


def _all_round(eyes: list[Vector3], *, dip: float, fov_deg: float) -> list[View]:
    """Every eye in many directions, looking a little down: by `dip` on a metre."""
    n_yaws = max(8, _TRIAL_YAWS // max(1, len(eyes) // 8))
    yaws = [2 * math.pi * k / n_yaws for k in range(n_yaws)]
    return [
        View(eye, (eye[0] + math.cos(yaw), eye[1] + math.sin(yaw), eye[2] - dip), fov_deg)
        for eye in eyes
        for yaw in yaws
    ]


def _best(world: World, trial: CameraRenderer, views: list[View], near_m: float = _NEAR_M) -> View:
    """The most interesting view, with little nearer than a distance."""
    data = world.new_data()

    def interest(view: View) -> float:
        fov_rad = math.radians(view.fov_deg)
        frame = trial.render_view(data, view.eye_enu_m, view.target_enu_m, fov_rad)
        return _interest(frame, world.scene, near_m)

    return max(views, key=interest)


def _interest(frame: RgbdFrame, scene: Scene, near_m: float) -> float:
    """Interest of a frame: much of the scene, at many distances, many edges, nothing near the lens.

    The weights were chosen by eye; what is too near counts most, because it hides the rest.
    """
    grey = frame.rgb.astype(float).mean(axis=2)
    edges = np.abs(np.diff(grey, axis=0)).mean() + np.abs(np.diff(grey, axis=1)).mean()
    seen = frame.depth_m[np.isfinite(frame.depth_m)]
    # Mostly sky.
    if len(seen) < 0.3 * frame.depth_m.size:
        return -1.0
    too_near = float((seen < near_m).mean())
    built = _share_of_scene(frame, scene)
    # Quantiles, because one pixel through a gap would count as depth.
    spread = float(np.log(np.quantile(seen, 0.9) / max(0.3, np.quantile(seen, 0.1))))
    return edges / 12 + 3.0 * built + 0.6 * spread - 6.0 * too_near


def _share_of_scene(frame: RgbdFrame, scene: Scene) -> float:
    """Share of the picture in which something of the scene stands, rather than ground or sky."""
    height, width = frame.depth_m.shape
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    # Sky lies far outside of the scene, and so counts as none of it.
    depth_m = np.where(np.isfinite(frame.depth_m), frame.depth_m, 1e5)
    x, y = (u - frame.cx) / frame.fx * depth_m, (v - frame.cy) / frame.fy * depth_m
    local = np.stack([x, y, depth_m], axis=-1)
    points = local @ frame.rotation_enu_from_optical.T + np.array(frame.position_enu_m)
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    is_inside = ((points > low) & (points < high)).all(axis=-1)
    # Above 0.3 m: lawns and paving alone make no picture.
    return float((is_inside & (points[..., 2] > 0.3)).mean())
