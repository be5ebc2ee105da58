"""Fine pictures: colours by either renderer, light by rays, four samples per pixel."""

from __future__ import annotations

import mujoco
import numpy as np

from flightsim.cameras.air import Air
from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.cameras.view import RgbdFrame, Viewpoint
from flightsim.looks.bake import open_lamps
from flightsim.looks.drawing import drawn_mesh
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.pixel_light import PixelLight
from flightsim.looks.sky import painted_sky
from flightsim.looks.surfaces import FINE
from flightsim.world import World

SAMPLES = 2
"""Samples per pixel along each axis."""
_MIN_OPACITY = 0.5  # discs of spinning rotors are more transparent, and are left out
_ONE_SURFACE = 1.1
"""Depth ratio up to which samples of a pixel are on one surface."""


class FineLight:
    """Light of a world, for pictures of one size with four samples per pixel."""

    def __init__(self, world: World, air: Air) -> None:
        light = world.light
        mesh = drawn_mesh(world.scene, world.solids, FINE, light)
        lamps = open_lamps(mesh, world.solids, world.scene.relief) if light.is_dark else None
        self._light = PixelLight(mesh, light, lamps)
        self._air, self._sky = air, light.sky

    def frame(
        self,
        view: Viewpoint,
        time_us: int,
        colours: np.ndarray,
        depth_m: np.ndarray,
        moving_enu_m: np.ndarray,
    ) -> RgbdFrame:
        """Light a picture and reduce it to its size.

        Args:
            view: Viewpoint of the picture.
            time_us: Time of the picture.
            colours: Colours (2 h, 2 w, 3) of the surfaces in plain white light, 0 to 1.
            depth_m: Depth (2 h, 2 w), inf in the sky.
            moving_enu_m: Triangles of the vehicle and of movers, (t, 3, 3).
        """
        height, width = depth_m.shape
        rays = view.rays_enu(width, height)
        seen = self._light.light(view.position_enu_m, rays, moving_enu_m)
        rgb = colours * seen.rgb
        is_sky = np.isinf(depth_m)
        towards = rays[is_sky]
        towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
        rgb[is_sky] = painted_sky(towards, self._sky)
        rgb = self._air.hazed(rgb, depth_m, view, 1.0)
        rgb = np.clip(_squares(rgb).mean(axis=(1, 3)), 0.0, 1.0)
        picture, depth_m = (255.0 * rgb + 0.5).astype(np.uint8), _pixel_depth(depth_m)
        self._air.let_fall(picture, depth_m, view, time_us)
        return view.frame(time_us, picture, depth_m)


def vehicle_triangles(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
    """Return the visible surface of the vehicle in its pose, without its spinning discs.

    Args:
        model: Model that is drawn.
        data: Its state.

    Returns:
        Triangles (t, 3, 3), ENU, and their colours (t, 3), 0 to 1.
    """
    is_shown = (model.geom_group == GeomGroup.VEHICLE_LOOKS) & (
        model.geom_rgba[:, 3] >= _MIN_OPACITY
    )
    parts, colours = [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    for g in np.flatnonzero(is_shown).tolist():
        turn = data.geom_xmat[g].reshape(3, 3)
        parts.append(geom_triangles(model, g) @ turn.T + data.geom_xpos[g])
        colours.append(np.tile(model.geom_rgba[g, :3], (len(parts[-1]), 1)))
    return np.concatenate(parts), np.concatenate(colours)


def _pixel_depth(depth_m: np.ndarray) -> np.ndarray:
    """Depth at pixel centres from samples: exact on planes, the nearest at edges."""
    samples = _squares(depth_m[..., None])
    nearest, farthest = samples.min(axis=(1, 3)), samples.max(axis=(1, 3))
    # The inverse of depth is linear in the image of a plane.
    inverse = (1.0 / samples).mean(axis=(1, 3))
    is_one = farthest < _ONE_SURFACE * nearest
    # A pixel of sky has infinite samples, whose inverse is 0.
    return np.where(is_one, 1.0 / np.where(is_one, inverse, 1.0), nearest)[..., 0]


def _squares(values: np.ndarray) -> np.ndarray:
    """Values with the samples of each pixel on axes 1 and 3."""
    height, width, channels = values.shape
    return values.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES, channels)
