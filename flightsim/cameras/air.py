"""The air in a picture: the sky, haze and fog by depth, rain and snow in front of the lens.

Everything here is painted over a finished picture from its depth, so that both renderers share it
and the depth itself has no haze. A depth camera in the real world sees less in fog; use
`--depth-camera` for errors of depth.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from flightsim.cameras.view import Viewpoint
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.sky import fill_sky
from flightsim.world import World

_CONTRAST = 0.02
"""Contrast that is left at the visibility: Koschmieder's definition, which weather reports use."""
_LAYER_SHARE, _LEAST_LAYER_M, _MOST_LAYER_M = 0.5, 40.0, 150.0
"""Thickness of the layer of haze, as a share of the visibility, and its bounds: one sees the sky
above fog sooner than the other side of the street."""
_ROOM_M = 10.0
"""Air that is clear about a camera under a roof."""
_DROPS_PER_PIXEL = {"rain": 1 / 320, "snow": 1 / 420}
_RAIN_LENGTH, _SNOW_RADIUS = 0.05, 0.004
"""Length of streaks and radius of the nearest flakes, as shares of the picture's height."""
_RAIN_ALPHA, _SNOW_ALPHA = 0.28, 0.85


class Air:
    """Paints the air of a world into pictures."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._light = world.light
        self._has_roofs: mujoco.MjData | None = None

    def paint(self, rgb: np.ndarray, depth_m: np.ndarray, view: Viewpoint, time_us: int) -> None:
        """Paint sky, haze and what falls into a picture, in place.

        Args:
            rgb: Colours of the surfaces, uint8 (h, w, 3).
            depth_m: Depth (h, w), inf in the sky.
            view: Viewpoint of the picture.
            time_us: Time of the picture, which places the drops.
        """
        turn, focal_px = view.rotation_enu_from_optical, view.focal_px(len(depth_m))
        fill_sky(rgb, depth_m, turn, focal_px, self._light.sky)
        if self._light.visibility_m is not None:
            rgb[:] = self.hazed(rgb.astype(np.float32), depth_m, view, 255.0)
        self.let_fall(rgb, depth_m, view, time_us)

    def hazed(
        self, rgb: np.ndarray, depth_m: np.ndarray, view: Viewpoint, white: float
    ) -> np.ndarray:
        """A picture behind haze.

        Args:
            rgb: Colours, float32 (h, w, 3).
            depth_m: Depth (h, w), inf in the sky.
            view: Viewpoint of the picture.
            white: Value of white in `rgb`.
        """
        visibility_m = self._light.visibility_m
        if visibility_m is None:
            return rgb
        extinction = np.float32(-math.log(_CONTRAST) / visibility_m)
        height, width = depth_m.shape
        rays = view.rays_enu(width, height)
        length = np.sqrt(np.einsum("hwi,hwi->hw", rays, rays))
        layer_m = min(max(_LAYER_SHARE * visibility_m, _LEAST_LAYER_M), _MOST_LAYER_M)
        sine = np.maximum(rays[..., 2] / length, 1e-3)
        through_m = np.where(np.isinf(depth_m), layer_m / sine, depth_m * length)
        if self._is_under_roof(view):
            through_m = np.maximum(through_m - _ROOM_M, 0.0)
        clear = np.exp(-extinction * through_m)[..., None].astype(np.float32)
        haze = white * np.array(self._light.sky.horizon_rgb, dtype=np.float32)
        return haze + clear * (rgb - haze)

    def let_fall(self, rgb: np.ndarray, depth_m: np.ndarray, view: Viewpoint, time_us: int) -> None:
        """Paint rain or snow into a picture, uint8, in place; no drop falls under a roof."""
        falling = self._light.falling
        if falling == "dry" or self._is_under_roof(view):
            return
        # Only pictures of rain and snow need it.
        import cv2

        height, width = depth_m.shape
        rng = np.random.default_rng([time_us, falling == "snow"])
        n = round(_DROPS_PER_PIXEL[falling] * height * width)
        places = rng.uniform((0.0, 0.0), (width, height), (n, 2))
        # Nearness: few drops are near the lens, where they look large and fast.
        near = rng.uniform(0.15, 1.0, n) ** 2
        cover = np.zeros((height, width), dtype=np.uint8)
        if falling == "rain":
            down = view.rotation_enu_from_optical.T @ np.array([0.03, 0.0, -1.0])
            steps = np.outer(near, _RAIN_LENGTH * height * down[:2])
            for (x, y), (dx, dy) in zip(places, steps, strict=True):
                ends = (round(x), round(y)), (round(x + dx), round(y + dy))
                cv2.line(cover, *ends, 255, 1, cv2.LINE_AA)
            alpha = _RAIN_ALPHA
        else:
            for (x, y), share in zip(places, near, strict=True):
                radius = max(1, round(_SNOW_RADIUS * height * share))
                cv2.circle(cover, (round(x), round(y)), radius, 255, -1, cv2.LINE_AA)
            alpha = _SNOW_ALPHA
        # Few pixels have a drop before them, and the others stay as they are.
        rows, columns = np.nonzero(cover)
        share = (alpha / 255) * cover[rows, columns].astype(np.float32)[:, None]
        colour = 255.0 * np.minimum(1.0, self._light.rgb(np.array([0.7]))[0]).astype(np.float32)
        behind = rgb[rows, columns]
        rgb[rows, columns] = (behind + share * (colour - behind) + 0.5).astype(np.uint8)

    def _is_under_roof(self, view: Viewpoint) -> bool:
        """Return True if something of the scene is above the eye."""
        if self._has_roofs is None:
            self._has_roofs = self._world.new_data()
        groups = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        groups[int(GeomGroup.SCENE)] = 1
        up, geom = np.array([0.0, 0.0, 1.0]), np.zeros(1, dtype=np.int32)
        eye = np.array(view.position_enu_m, dtype=float)
        model = self._world.model
        return mujoco.mj_ray(model, self._has_roofs, eye, up, groups, 1, -1, geom) >= 0
