"""Cameras as options of a command: NAME,fov=90,pitch=15,yaw=0,x=0.1,y=0,z=0.02."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from flightsim.vehicles.airframe import Airframe, AirframeError, CameraMount

_FARTHEST_M = 5.0
_VALID = {
    "fov": (10.0, 120.0, "degrees from top to bottom"),
    "pitch": (-90.0, 90.0, "degrees down"),
    "yaw": (-180.0, 180.0, "degrees to the left"),
    "x": (-_FARTHEST_M, _FARTHEST_M, "m forward"),
    "y": (-_FARTHEST_M, _FARTHEST_M, "m to the left"),
    "z": (-_FARTHEST_M, _FARTHEST_M, "m up"),
}


def with_cameras(airframe: Airframe, options: Sequence[str]) -> Airframe:
    """Return the same vehicle with cameras changed, or with more of them.

    Args:
        airframe: The vehicle; its centre of mass is the origin of x, y and z.
        options: One camera each. A setting that is missing stays as it was. A new camera looks
            level ahead from the place of the first camera, with a field of view of 60 degrees.

    Raises:
        AirframeError: Naming the option, the field and its value, and what would be valid.
    """
    mounts = {mount.name: mount for mount in airframe.cameras}
    for option in options:
        name, *settings = option.split(",")
        if not name.isidentifier():
            raise AirframeError(
                f"camera {option!r} begins with {name!r}; valid: a name, such as forward, down or "
                "one of your own, then settings, such as forward,fov=90,pitch=10"
            )
        mount = mounts.get(name) or _new_mount(airframe, name)
        mounts[name] = _changed(mount, option, settings, -airframe.leg_length_m)
    return replace(airframe, cameras=tuple(mounts.values()))


def _new_mount(airframe: Airframe, name: str) -> CameraMount:
    place = airframe.cameras[0].position_flu_m if airframe.cameras else (0.0, 0.0, 0.0)
    return CameraMount(
        name=name, position_flu_m=place, pitch_down_rad=0.0, vertical_fov_rad=math.radians(60.0)
    )


def _changed(
    mount: CameraMount, option: str, settings: Sequence[str], ground_m: float
) -> CameraMount:
    numbers = dict(_number(option, setting) for setting in settings)
    x, y, z = (
        numbers.get(axis, old) for axis, old in zip("xyz", mount.position_flu_m, strict=True)
    )
    # The sole is the ground for a vehicle that stands: a camera below it would be inside.
    if z <= ground_m:
        raise AirframeError(
            f"camera {option!r}: z is {z:g}; valid: above the ground, more than {ground_m:g} m"
        )
    angles: dict[str, Any] = {
        field: math.radians(numbers[key])
        for key, field in (
            ("fov", "vertical_fov_rad"),
            ("pitch", "pitch_down_rad"),
            ("yaw", "yaw_rad"),
        )
        if key in numbers
    }
    return replace(mount, position_flu_m=(x, y, z), **angles)


def _number(option: str, setting: str) -> tuple[str, float]:
    key, _, text = setting.partition("=")
    if key not in _VALID:
        raise AirframeError(
            f"camera {option!r}: {setting!r} is unknown; valid: {'=, '.join(_VALID)}= and a number"
        )
    low, high, unit = _VALID[key]
    try:
        value = float(text)
    except ValueError:
        # NaN fails the comparison below and gets the same message as a number out of range.
        value = math.nan
    if not low <= value <= high:
        raise AirframeError(
            f"camera {option!r}: {key} is {text!r}; valid: {low:g} to {high:g} {unit}"
        )
    return key, value
