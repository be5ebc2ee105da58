"""An unpowered vehicle in a compiled scene, released above a landing area."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from aeroscene.scene import InteractionArea, Scene
from aeroscene.scene.polygon import distance_inside
from autonomy.types import quat_about_up
from flightsim.vehicles.airframe import Airframe
from flightsim.world import build_world

HEIGHT_M = 0.3
"""Height of the soles above the centroid at the start of the fall."""
LONGEST_S = 5.0
_LOOK_S = 0.05
_REST_S = 0.3
"""Time without notable motion that counts as rest."""
_REST_SPEED_MPS = 0.01
_REST_RATE_RADPS = 0.05


@dataclass(frozen=True, kw_only=True, slots=True)
class Fall:
    """Final position of a vehicle: at rest, or at the end of the time limit."""

    rested: bool
    inside_m: float
    """Distance of the vehicle's centre from the area's border, from above; negative outside."""
    height_m: float
    """Height of the soles above the area's plane."""
    tilt_rad: float


class FallingVehicle:
    """One scene with one vehicle, compiled once for many falls."""

    def __init__(self, scene: Scene, airframe: Airframe) -> None:
        """Compile the scene.

        Args:
            scene: Scene whose areas are tested.
            airframe: Vehicle that falls.

        Raises:
            WorldError: If the vehicle cannot stand at the scene's start.
        """
        self._airframe = airframe
        self._model = build_world(scene, airframe).model
        self._data = mujoco.MjData(self._model)

    def fall(self, area: InteractionArea, yaw_rad: float) -> Fall:
        """Release the vehicle above the area's centroid, and wait until it rests or 5 s are over.

        Args:
            area: Landing area of the scene.
            yaw_rad: Heading of the vehicle, counter-clockwise from east.
        """
        data = self._data
        mujoco.mj_resetData(self._model, data)
        data.qpos[:3] = area.centroid
        # Positions are of the body, whose soles are a leg's length below it.
        data.qpos[2] += HEIGHT_M + self._airframe.leg_length_m
        data.qpos[3:7] = quat_about_up(yaw_rad)
        rested = self._wait_for_rest()
        east, north, up = data.qpos[:3].tolist()
        plane_up, slope_rad = _plane_at(area, east, north)
        _, x, y, _ = data.qpos[3:7].tolist()
        return Fall(
            rested=rested,
            inside_m=distance_inside([(px, py) for px, py, _ in area.polygon], east, north),
            # The cosine turns the vertical distance into that perpendicular to the plane.
            height_m=(up - plane_up) * math.cos(slope_rad) - self._airframe.leg_length_m,
            # The vertical part of the body's z axis is the cosine of the tilt.
            tilt_rad=math.acos(max(-1.0, 1.0 - 2.0 * (x * x + y * y))),
        )

    def _wait_for_rest(self) -> bool:
        n_steps = round(_LOOK_S / self._model.opt.timestep)
        still_s = 0.0
        while self._data.time < LONGEST_S:
            mujoco.mj_step(self._model, self._data, nstep=n_steps)
            speed_mps, rate_radps = (np.abs(v).max() for v in np.split(self._data.qvel[:6], 2))
            is_still = speed_mps < _REST_SPEED_MPS and rate_radps < _REST_RATE_RADPS
            # At the top of a bounce it hardly moves either, but only briefly, so rest must last.
            still_s = still_s + _LOOK_S if is_still else 0.0
            if still_s >= _REST_S:
                return True
        return False


def _plane_at(area: InteractionArea, east: float, north: float) -> tuple[float, float]:
    """Return height in m and slope in rad of the polygon's plane at a point."""
    # A least-squares fit, because more than three corners need not lie in one plane exactly.
    corners = np.array(area.polygon) - area.centroid
    east_slope, north_slope, rise = np.linalg.lstsq(
        np.column_stack([corners[:, :2], np.ones(len(corners))]), corners[:, 2]
    )[0].tolist()
    x, y, z = area.centroid
    up = z + rise + east_slope * (east - x) + north_slope * (north - y)
    return up, math.atan(math.hypot(east_slope, north_slope))
