"""Starts of vehicles by settings.json: each stands on the first surface below its point."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autonomy.types import Quaternion, Vector3, quat_about_up
from flightsim.frames import swap_enu_ned, swap_yaw_enu_ned
from flightsim.plant import Plant
from flightsim.plant.relocation import PlaceTakenError
from flightsim.testbench import TestbenchError
from scenarios.airsim.rangers import Rangers
from scenarios.airsim.settings import VehicleSettings

_STEP_M = 0.3
"""Height above a start from which the surface is looked for, since a place is seldom exact."""
_PARKED_M, _PARKED_APART_M = 500.0, 10.0


def stand(plants: Sequence[Plant], settings: Sequence[VehicleSettings]) -> None:
    """Put vehicles to their starts, before time has passed; without any place all stay.

    Raises:
        TestbenchError: If there is no surface below a start, or something is in the way.
    """
    if not any(each.offset_ned_m or each.yaw_deg is not None for each in settings):
        return
    origin = plants[0].world.vehicles[0].stand_enu_m
    rests = [_rest(plant, each, origin) for plant, each in zip(plants, settings, strict=True)]
    # A vehicle must not stand in the way of another one that comes before it.
    for number, plant in enumerate(plants):
        x, y, z = plant.truth.position_enu_m
        parked = (x, y, z + _PARKED_M + number * _PARKED_APART_M)
        plant.put(parked, plant.truth.quat_wxyz)
    for plant, each, pose in zip(plants, settings, rests, strict=True):
        try:
            plant.put(*pose)
        except PlaceTakenError as error:
            raise _wrong(each, f"is inside of something: {error}; valid: a free place") from None


def _rest(plant: Plant, settings: VehicleSettings, origin: Vector3) -> tuple[Vector3, Quaternion]:
    """Pose in which a vehicle rests on the surface below its start."""
    before, placed = plant.truth.position_enu_m, plant.world.vehicles[plant.world.number]
    if settings.offset_ned_m is None:
        point = placed.stand_enu_m
    else:
        east, north, up = swap_enu_ned(settings.offset_ned_m)
        point = (origin[0] + east, origin[1] + north, origin[2] + up)
    eye = np.array(point) + np.array([0.0, 0.0, _STEP_M])
    depth_m = Rangers(plant, {}, {}).cast(eye, np.array([[0.0, 0.0, -1.0]]))[0]
    if not math.isfinite(depth_m):
        raise _wrong(settings, "has no surface below; valid: a point above one")
    legs_m = before[2] - placed.stand_enu_m[2]
    yaw_rad = placed.yaw_rad
    if settings.yaw_deg is not None:
        yaw_rad = swap_yaw_enu_ned(math.radians(settings.yaw_deg))
    return (point[0], point[1], float(eye[2] - depth_m) + legs_m), quat_about_up(yaw_rad)


def _wrong(settings: VehicleSettings, what: str) -> TestbenchError:
    place = settings.offset_ned_m
    return TestbenchError(f"airsim-settings: start {place} of vehicle {settings.name!r} {what}")
