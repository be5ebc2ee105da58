"""Draw the picture of the README: a scene with a vehicle in flight, by our own renderer.

python tools/draw_scene.py --scene 42 --out docs/images/scene-42.png
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import mujoco
import tyro

from aeroscene.sources import open_scene
from flightsim.sensors.camera import open_camera_renderer
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world


@dataclass(frozen=True, kw_only=True)
class DrawCfg:
    """Draw a scene with a vehicle in flight."""

    out: Path
    """PNG file to write."""
    scene: str = "42"
    """Scene number or file."""
    vehicle: str = "iris"
    """Airframe."""
    position_enu_m: tuple[float, float, float] = (0.0, 0.0, 8.0)
    """Where the vehicle flies."""
    yaw_deg: float = 0.0
    """Its heading, counter-clockwise from east."""
    eye_offset_m: tuple[float, float, float] = (-1.6, -0.9, 0.7)
    """From the vehicle to the eye, in the vehicle's level frame."""
    look_ahead_m: tuple[float, float, float] = (6.0, 0.0, -1.2)
    """From the vehicle to the point in the picture's middle, in the same frame."""
    size_px: tuple[int, int] = (1280, 640)
    """Width and height."""


def draw(cfg: DrawCfg) -> None:
    """Render and write the picture."""
    world = build_world(open_scene(cfg.scene), airframe_by_name(cfg.vehicle))
    data = world.new_data()
    yaw = math.radians(cfg.yaw_deg)
    data.qpos[:3] = cfg.position_enu_m
    # Nose a little down, as in forward flight.
    pitch = math.radians(8.0)
    turn = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
    dip = (math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
    mujoco.mju_mulQuat(data.qpos[3:7], turn, dip)
    mujoco.mj_forward(world.model, data)

    def place(offset_m: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = offset_m
        east = cfg.position_enu_m[0] + x * math.cos(yaw) - y * math.sin(yaw)
        north = cfg.position_enu_m[1] + x * math.sin(yaw) + y * math.cos(yaw)
        return (east, north, cfg.position_enu_m[2] + z)

    renderer = open_camera_renderer(world, *cfg.size_px)
    frame = renderer.render_view(
        data,
        place(cfg.eye_offset_m),
        place(cfg.look_ahead_m),
        vertical_fov_rad=math.radians(50.0),
        quality="fine",
    )
    renderer.close()
    cfg.out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(cfg.out), cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR))


if __name__ == "__main__":
    draw(tyro.cli(DrawCfg))
