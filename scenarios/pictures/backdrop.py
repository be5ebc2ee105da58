"""Rendered views of a scene, into which paths are drawn and behind whose objects they disappear.

A path drawn over a picture would seem to float in front of everything. Each view is therefore
rendered with its depth image. A point that lies farther away than the surface at its pixel is
hidden, and drawn pale.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Vector3
from flightsim.cameras import CameraRenderer, RgbdFrame, open_camera_renderer
from flightsim.cameras.framing import frame_points
from flightsim.looks.cutting import cut_at
from flightsim.world import World

_TOP_FOV_RAD = math.radians(14.0)
"""Field of view from above, narrow so that walls hardly lean."""
_OBLIQUE_FOV_RAD = math.radians(32.0)
_OBLIQUE_ELEVATION_RAD = math.radians(36.0)
# The sun is in the south-west. Seen from there, faces are lit and shadows fall to the right.
_OBLIQUE_AZIMUTH_RAD = math.radians(-118.0)
_HIDDEN_M = 0.2
"""Distance behind the visible surface from which a point counts as hidden. A path along a wall,
which is nearer, does not flicker."""
_NEAR_M = 0.1
_OVER_THE_PATH_M = 0.4
"""Height above the highest point of a path from which structures are removed if they hide it."""


@dataclass(frozen=True, eq=False)
class Backdrop:
    """A picture of the scene, with the projection of points in space onto it."""

    frame: RgbdFrame

    @property
    def rgb(self) -> np.ndarray:
        """The picture, uint8 (height, width, 3)."""
        return self.frame.rgb

    def pixels(
        self, points_enu_m: Float[np.ndarray, "n 3"]
    ) -> tuple[Float[np.ndarray, "n 2"], Bool[np.ndarray, " n"]]:
        """Project points onto the picture.

        Args:
            points_enu_m: Points in the world.

        Returns:
            Column and row of each point, NaN behind the eye, and whether something hides it. Points
            beyond the border are compared with the nearest pixel.
        """
        frame = self.frame
        local = (points_enu_m - np.array(frame.position_enu_m)) @ frame.rotation_enu_from_optical
        depth_m = np.where(local[:, 2] > _NEAR_M, local[:, 2], np.nan)
        across, down = frame.fx * local[:, 0] / depth_m, frame.fy * local[:, 1] / depth_m
        places = np.column_stack([across + frame.cx, down + frame.cy])
        height, width = frame.depth_m.shape
        column = np.clip(np.nan_to_num(places[:, 0]), 0, width - 1).round().astype(int)
        row = np.clip(np.nan_to_num(places[:, 1]), 0, height - 1).round().astype(int)
        return places, depth_m > frame.depth_m[row, column] + _HIDDEN_M

    def pixels_per_m(self, point_enu_m: Vector3) -> float:
        """Return the scale in pixels per metre, across the line of sight at a point."""
        frame = self.frame
        away = np.array(point_enu_m) - np.array(frame.position_enu_m)
        return frame.fx / float(away @ frame.rotation_enu_from_optical[:, 2])


class Stage:
    """Takes pictures of one scene, always of one size."""

    def __init__(self, world: World, renderer: CameraRenderer, aspect: float) -> None:
        self._data = world.new_data()
        self._renderer = renderer
        self._aspect = aspect

    def from_above(self, points_enu_m: Float[np.ndarray, "n 3"], margin: float) -> Backdrop:
        """Return a view of all points from straight above, north at the top.

        Args:
            points_enu_m: Points that must be in the picture.
            margin: Factor on the extent of the points, 1 or more.
        """
        low, high = points_enu_m.min(axis=0), points_enu_m.max(axis=0)
        middle = (low + high) / 2
        half_m = margin * (high - low)[:2] / 2
        reach_m = max(float(half_m[1]), float(half_m[0]) / self._aspect)
        x, y = middle[:2].tolist()
        level_m = float(high[2])
        # The extent is measured at the highest point: lower points then lie within it as well.
        eye = (x, y, level_m + reach_m / math.tan(_TOP_FOV_RAD / 2))
        return self._view(eye, (x, y, level_m), _TOP_FOV_RAD)

    def from_aside(self, points_enu_m: Float[np.ndarray, "n 3"], margin: float) -> Backdrop:
        """Return a view of all points from above one side, of four the one that hides least.

        Args:
            points_enu_m: Points that must be in the picture.
            margin: Factor on the extent of the points, 1 or more.
        """
        backdrops = []
        for turn in (0.0, math.pi / 2, math.pi, -math.pi / 2):
            eye, target = frame_points(
                points_enu_m,
                azimuth_rad=_OBLIQUE_AZIMUTH_RAD + turn,
                elevation_rad=_OBLIQUE_ELEVATION_RAD,
                vertical_fov_rad=_OBLIQUE_FOV_RAD,
                aspect=self._aspect,
                margin=margin,
            )
            backdrop = self._view(eye, target, _OBLIQUE_FOV_RAD)
            hidden = float(backdrop.pixels(points_enu_m)[1].mean())
            # The number breaks ties, in favour of the first side, where faces are lit.
            backdrops.append((hidden, len(backdrops), backdrop))
        return min(backdrops)[2]

    def _view(self, eye_enu_m: Vector3, target_enu_m: Vector3, fov_rad: float) -> Backdrop:
        render = self._renderer.render_view
        return Backdrop(render(self._data, eye_enu_m, target_enu_m, fov_rad))


@contextmanager
def open_stage(world: World, width: int, height: int) -> Iterator[Stage]:
    """Open a stage for pictures of a size in pixels, and free its renderer at the end."""
    with closing(open_camera_renderer(world, width, height)) as renderer:
        yield Stage(world, renderer, width / height)


def opened_above(world: World, points_enu_m: Float[np.ndarray, "n 3"]) -> World:
    """Return the world without solids above all of the points, such as roofs and upper storeys.

    Args:
        world: World of the scene.
        points_enu_m: Points that should become visible from above.
    """
    top_m = float(points_enu_m[:, 2].max()) + _OVER_THE_PATH_M
    return replace(world, solids=cut_at(world.solids, top_m))


def surfaces_m(
    world: World, points_enu_m: Float[np.ndarray, "n 3"]
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return the heights of the next surfaces below and above each point, NaN if there is none.

    Args:
        world: World without a vehicle, which would be hit first.
        points_enu_m: Points from which rays are cast.
    """
    data, geom = world.new_data(), np.zeros(1, dtype=np.int32)

    def first_hit_m(point: np.ndarray, upwards: float) -> float:
        ray = np.array([0.0, 0.0, upwards])
        depth_m = mujoco.mj_ray(world.model, data, point, ray, None, 1, -1, geom)
        return math.nan if depth_m < 0 else float(point[2]) + upwards * depth_m

    points = np.ascontiguousarray(points_enu_m, dtype=float)
    below = np.array([first_hit_m(point, -1.0) for point in points])
    above = np.array([first_hit_m(point, 1.0) for point in points])
    return below, above
