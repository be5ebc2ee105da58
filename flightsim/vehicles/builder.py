"""MuJoCo body of an airframe: inertia, collision shape, looks and cameras.

The collision shape is what can hit something: fuselage, arms, legs, and each rotor disc as a thin
cylinder. It has no mass and is invisible; the looks are separate and without contacts.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from autonomy.types import Vector3, quat_about_up
from flightsim.looks.geom_groups import GeomGroup
from flightsim.vehicles.airframe import Airframe, CameraMount

VEHICLE_BODY = "vehicle"

_BOX = mujoco.mjtGeom.mjGEOM_BOX
_CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
_ELLIPSOID = mujoco.mjtGeom.mjGEOM_ELLIPSOID

_DISC_HALF_THICKNESS_M = 0.005
LEG_RADIUS_M = 0.009
ARM_RADIUS_M = 0.010
MOTOR_RADIUS_M = 0.018

# Contact of the vehicle with anything, chosen by dropping it from 0.3 m on slopes of 0 to 8 degrees
# (tests/flightsim/vehicles/test_builder.py): overdamped legs rebound at 5 % of the impact's speed,
# where critical damping gave 14 %, and give 21 mm; friction lets it creep 0.04 mm/s at 8 degrees.
_CONTACT: dict[str, Any] = {
    "contype": 1,
    "conaffinity": 1,
    "condim": 4,
    "friction": (0.9, 0.02, 0.001),
    "solref": (0.02, 2.0),
    "solimp": (0.9, 0.97, 0.004, 0.5, 2.0),
    "solmix": 1.0,
    "group": int(GeomGroup.VEHICLE_SHAPE),
    "mass": 0.0,
}
_LOOKS: dict[str, Any] = {
    "contype": 0,
    "conaffinity": 0,
    "group": int(GeomGroup.VEHICLE_LOOKS),
    "mass": 0.0,
}

_CARBON = (0.13, 0.13, 0.15, 1.0)
_SHELL = (0.92, 0.92, 0.94, 1.0)
_METAL = (0.55, 0.56, 0.60, 1.0)
_LENS = (0.05, 0.06, 0.12, 1.0)
_FRONT = (0.95, 0.33, 0.05, 1.0)
_DISC_FRONT = (0.95, 0.40, 0.10, 0.28)
_DISC_REAR = (0.20, 0.22, 0.26, 0.25)


def add_vehicle(
    spec: mujoco.MjSpec, airframe: Airframe, position_enu_m: Vector3, yaw_rad: float
) -> None:
    """Add body "vehicle" with a free joint, its origin (the centre of mass) at a position.

    Its cameras have the names of `airframe.cameras`.
    """
    body = spec.worldbody.add_body(
        name=VEHICLE_BODY,
        pos=position_enu_m,
        quat=quat_about_up(yaw_rad),
        explicitinertial=True,
        mass=airframe.quadrotor.mass_kg,
        ipos=(0.0, 0.0, 0.0),
        iquat=(1.0, 0.0, 0.0, 0.0),
        inertia=airframe.quadrotor.inertia_flu_kgm2,
    )
    body.add_freejoint(name=VEHICLE_BODY)
    _add_collision_shape(body, airframe)
    _add_fuselage_looks(body, airframe)
    for rotor in airframe.quadrotor.rotors:
        _add_rotor_looks(body, airframe, rotor.position_flu_m, rotor.spin)
    for mount in airframe.cameras:
        body.add_camera(
            name=mount.name,
            pos=mount.position_flu_m,
            quat=camera_quat_wxyz(mount),
            fovy=math.degrees(mount.vertical_fov_rad),
        )


def camera_quat_wxyz(mount: CameraMount) -> tuple[float, float, float, float]:
    """Attitude of MuJoCo's camera axes (x right, y up, z backwards) in the body frame."""
    s, c = math.sin(mount.pitch_down_rad), math.cos(mount.pitch_down_rad)
    rotation_flu_from_camera = np.array([[0.0, s, -c], [-1.0, 0.0, 0.0], [0.0, c, s]])
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rotation_flu_from_camera.ravel())
    w, x, y, z = quat.tolist()
    return (w, x, y, z)


def sole_positions_flu_m(airframe: Airframe) -> tuple[Vector3, ...]:
    """Contact points of the four legs on level ground, in the body frame."""
    soles = []
    for rotor in airframe.quadrotor.rotors:
        x, y, _ = rotor.position_flu_m
        scale = airframe.leg_spread_m / math.hypot(x, y)
        soles.append((x * scale, y * scale, -airframe.leg_length_m))
    return tuple(soles)


def leg_axes_flu_m(airframe: Airframe) -> list[tuple[Vector3, Vector3]]:
    """Ends of each leg's axis in the body frame: at the arm, and one leg radius above the sole."""
    return [
        ((0.7 * x, 0.7 * y, 0.0), (x, y, z + LEG_RADIUS_M))
        for x, y, z in sole_positions_flu_m(airframe)
    ]


def _add_collision_shape(body: Any, airframe: Airframe) -> None:
    length, width, height = airframe.body_size_m
    body.add_geom(name="fuselage", type=_BOX, size=(length / 2, width / 2, height / 2), **_CONTACT)
    for i, (rotor, leg) in enumerate(
        zip(airframe.quadrotor.rotors, leg_axes_flu_m(airframe), strict=True)
    ):
        hub = rotor.position_flu_m
        disc = (airframe.rotor_radius_m, _DISC_HALF_THICKNESS_M, 0.0)
        body.add_geom(name=f"disc{i}", type=_CYLINDER, pos=hub, size=disc, **_CONTACT)
        for name, ends, radius_m in (
            (f"arm{i}", (0.0, 0.0, 0.0, hub[0], hub[1], 0.0), ARM_RADIUS_M),
            (f"leg{i}", (*leg[0], *leg[1]), LEG_RADIUS_M),
        ):
            size = (radius_m, 0.0, 0.0)
            body.add_geom(name=name, type=_CAPSULE, fromto=ends, size=size, **_CONTACT)


def _add_fuselage_looks(body: Any, airframe: Airframe) -> None:
    x, y, z = airframe.body_size_m
    _show(body, _BOX, (0.46 * x, 0.42 * y, 0.22 * z), _CARBON)
    _show(body, _ELLIPSOID, (0.52 * x, 0.5 * y, 0.55 * z), _SHELL, (-0.02 * x, 0.0, 0.15 * z))
    _show(body, _ELLIPSOID, (0.27 * x, 0.42 * y, 0.48 * z), _FRONT, (0.27 * x, 0.0, 0.17 * z))
    _show(body, _BOX, (0.32 * x, 0.3 * y, 0.16 * z), _METAL, (-0.08 * x, 0.0, -0.36 * z))
    # The mast and puck of the GNSS antenna.
    _show(body, _CYLINDER, (0.22 * y, 0.09 * z, 0.0), _CARBON, (-0.25 * x, 0.0, 0.85 * z))
    for mount in airframe.cameras:
        _show(body, _ELLIPSOID, (0.014, 0.014, 0.014), _LENS, mount.position_flu_m)
    for ends in leg_axes_flu_m(airframe):
        _show_tube(body, *ends, LEG_RADIUS_M, _CARBON)


def _add_rotor_looks(body: Any, airframe: Airframe, hub_flu_m: Vector3, spin: int) -> None:
    x, y, z = hub_flu_m
    is_front = x > 0.05
    radius = airframe.rotor_radius_m
    arm_rgba = _FRONT if is_front else _SHELL
    _show_tube(body, (0.0, 0.0, 0.0), (x, y, 0.0), ARM_RADIUS_M, arm_rgba)
    # The motor ends just below the disc.
    motor_half_m = (z + 0.012) / 2
    middle_flu_m = (x, y, z - motor_half_m - 0.002)
    _show(body, _CYLINDER, (MOTOR_RADIUS_M, motor_half_m, 0.0), _METAL, middle_flu_m)
    blades = quat_about_up(math.atan2(y, x) + spin * math.radians(50.0))
    _show(body, _BOX, (0.97 * radius, 0.010, 0.0015), _CARBON, hub_flu_m, quat=blades)
    disc_rgba = _DISC_FRONT if is_front else _DISC_REAR
    _show(body, _CYLINDER, (radius, 0.003, 0.0), disc_rgba, hub_flu_m)


def _show(
    body: Any,
    shape: mujoco.mjtGeom,
    size_m: Vector3,
    rgba: tuple[float, ...],
    middle_flu_m: Vector3 = (0.0, 0.0, 0.0),
    **more: Any,
) -> None:
    body.add_geom(type=shape, pos=middle_flu_m, size=size_m, rgba=rgba, **more, **_LOOKS)


def _show_tube(
    body: Any, start_flu_m: Vector3, end_flu_m: Vector3, radius_m: float, rgba: tuple[float, ...]
) -> None:
    ends, size = (*start_flu_m, *end_flu_m), (radius_m, 0.0, 0.0)
    body.add_geom(type=_CAPSULE, fromto=ends, size=size, rgba=rgba, **_LOOKS)
