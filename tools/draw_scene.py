"""Draw a picture of a scene by our own renderer.

python tools/draw_scene.py --scene 42 --view overview --out scene-42.png
python tools/draw_scene.py --scene 44 --view overview --cut-height-m 2.6 --areas --out plan.png

With a vehicle in flight:

python tools/draw_scene.py --scene 42 --view chase --size-px 1120 560 --out chase.png
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import tyro
from drawing.area_overlay import with_areas
from drawing.views import Preset, View, choose_view
from PIL import Image

from aeroscene.scene import Vector3
from aeroscene.sources import load_scene
from autonomy.types import quat_about_up
from flightsim.cameras import RgbdFrame, look_at, open_camera_renderer
from flightsim.cameras.view import Quality
from flightsim.looks.cutting import cut_at
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world

_TRIAL_PX = (96, 64)  # enough to compare views, and fast
_JPEG_QUALITY = 85
_CHASED_M = (-0.5, 0.2, 1.7)
"""Position of the vehicle in the picture: right, down and forward of the eye."""
_CHASED_YAW_RAD = 0.5  # turned aside, so that one sees its length


@dataclass(frozen=True, kw_only=True)
class DrawCfg:
    """Draw a scene."""

    out: Path
    """PNG or JPEG file to write."""
    scene: str = "42"
    """Scene number or file."""
    view: Preset = "overview"
    """View: all of it, straight above, low over its edge, the street, a vehicle's forward or
    down camera, inside a room, or behind a vehicle in flight."""
    eye_enu_m: Vector3 | None = None
    """Look from here instead; needs a target."""
    target_enu_m: Vector3 | None = None
    """Point in the middle of the picture, if an eye is given."""
    cut_height_m: float | None = None
    """Take away what is above this height."""
    areas: bool = False
    """Draw landing areas (small blue, medium green, large orange) and perching areas (violet)."""
    size_px: tuple[int, int] = (1280, 720)
    """Width and height."""
    quality: Quality = "fine"
    """"fast" is what on-board cameras see."""
    vehicle: str = "iris"
    """Airframe of the chase view."""


def draw(cfg: DrawCfg) -> None:
    """Render the picture that is asked for, and write it to its file."""
    frame, rgb = picture(cfg)
    del frame
    save(rgb, cfg.out)


def picture(cfg: DrawCfg) -> tuple[RgbdFrame, np.ndarray]:
    """Render a picture, with areas over it if they are asked for.

    Returns:
        The frame without areas, with its depth and camera, and rgb (h, w, 3) uint8 of the picture.
    """
    has_vehicle = cfg.view == "chase" and cfg.eye_enu_m is None
    scene = load_scene(cfg.scene)
    airframes = [airframe_by_name(cfg.vehicle)] if has_vehicle else []
    world = build_world(scene, *airframes)
    if cfg.cut_height_m is not None:
        # Only what is drawn is cut: the scene itself, and so the choice of a view, stays whole.
        world = replace(world, solids=cut_at(world.solids, cfg.cut_height_m))
    data = world.new_data()
    view = _view(cfg, world)
    if has_vehicle:
        _fly(world, data, view)
    renderer = open_camera_renderer(world, *cfg.size_px)
    frame = renderer.render_view(
        data, view.eye_enu_m, view.target_enu_m, math.radians(view.fov_deg), cfg.quality
    )
    renderer.close()
    if not cfg.areas:
        return frame, frame.rgb
    # Areas on furniture or a roof that was cut away would hang in the air.
    highest_m = math.inf if cfg.cut_height_m is None else cfg.cut_height_m
    areas = [area for area in scene.interaction_areas if area.centroid[2] <= highest_m]
    return frame, with_areas(frame, areas)


def save(rgb: np.ndarray, path: Path) -> None:
    """Write a picture in the format of its name, PNG or JPEG.

    The folder is made if it is missing.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    is_png = path.suffix == ".png"
    options: dict[str, Any] = {} if is_png else {"quality": _JPEG_QUALITY, "progressive": True}
    Image.fromarray(rgb).save(path, optimize=True, **options)


def _view(cfg: DrawCfg, world: World) -> View:
    # An eye without a target is no view, so that the preset holds.
    if cfg.eye_enu_m is not None and cfg.target_enu_m is not None:
        return View(cfg.eye_enu_m, cfg.target_enu_m, 55.0)
    trial = open_camera_renderer(world, *_TRIAL_PX)
    view = choose_view(world, cfg.view, cfg.size_px[0] / cfg.size_px[1], trial)
    trial.close()
    return view


def _fly(world: World, data: mujoco.MjData, view: View) -> None:
    """Put the vehicle into the view, close before the eye, flying where it looks."""
    looks = look_at(view.eye_enu_m, view.target_enu_m, math.radians(view.fov_deg))
    data.qpos[:3] = looks.position_enu_m + looks.rotation_enu_from_optical @ _CHASED_M
    x, y, _ = looks.rotation_enu_from_optical[:, 2].tolist()
    yaw = math.atan2(y, x) + _CHASED_YAW_RAD
    # Nose a little down, as in forward flight.
    pitch = math.radians(8.0)
    turn = quat_about_up(yaw)
    dip = (math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
    mujoco.mju_mulQuat(data.qpos[3:7], turn, dip)
    mujoco.mj_forward(world.model, data)


if __name__ == "__main__":
    draw(tyro.cli(DrawCfg))
