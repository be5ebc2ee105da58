"""MuJoCo body of an airframe: inertia, collision shape, looks and cameras.

The collision shape contains everything that can hit an obstacle: fuselage, arms, legs, and each
rotor disc as a thin cylinder. It has no mass and is invisible. The looks are separate and without
contacts, so that they may be as detailed as they like.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from autonomy.model import RotorParams
from autonomy.types import Vector3, quat_about_up
from flightsim.looks.geom_groups import GeomGroup
from flightsim.vehicles.airframe import Airframe, BodyMesh, CameraMount
from flightsim.vehicles.body_file import add_parts, read_body_file
from flightsim.vehicles.mesh_file import mesh_source

VEHICLE_BODY = "vehicle"

_BOX = mujoco.mjtGeom.mjGEOM_BOX
_CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
_ELLIPSOID = mujoco.mjtGeom.mjGEOM_ELLIPSOID

_MOST_DISC_HALF_THICKNESS_M = 0.005  # small rotors have thinner discs
_FRONT_SHARE = 0.4
"""Share of a rotor's radius: one that lies farther ahead of the centre has the front's colour."""

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


def vehicle_name(number: int) -> str:
    """Return the name of the body of a vehicle by its number in its world, 0 for the first."""
    return VEHICLE_BODY if number == 0 else f"{VEHICLE_BODY}_{number + 1}"


def part_name(number: int, part: str) -> str:
    """Return the name of a vehicle's part or camera; those of the first vehicle have no prefix."""
    return part if number == 0 else f"{vehicle_name(number)}/{part}"


def add_vehicle(
    spec: mujoco.MjSpec,
    airframe: Airframe,
    position_enu_m: Vector3,
    yaw_rad: float,
    *,
    number: int = 0,
) -> None:
    """Add a body with a free joint, its origin (the centre of mass) at a position.

    Its cameras have the names of `airframe.cameras`, as `part_name` forms them.

    Args:
        spec: World to add it to.
        airframe: The vehicle.
        position_enu_m: Position of its centre of mass.
        yaw_rad: Its heading, counter-clockwise from east.
        number: Number among several vehicles, 0 for the first, whose body is "vehicle".
    """
    name = vehicle_name(number)
    body = spec.worldbody.add_body(
        name=name,
        pos=position_enu_m,
        quat=quat_about_up(yaw_rad),
        # Explicit: the geoms have no mass, and inertia comes from the airframe alone.
        explicitinertial=True,
        mass=airframe.quadrotor.mass_kg,
        ipos=(0.0, 0.0, 0.0),
        iquat=(1.0, 0.0, 0.0, 0.0),
        inertia=airframe.quadrotor.inertia_flu_kgm2,
    )
    body.add_freejoint(name=name)
    _add_collision_shape(spec, body, airframe, number)
    if airframe.model is not None:
        looks = read_body_file(Path(airframe.model.path)).looks
        add_parts(spec, body, looks, airframe.model.position_flu_m, f"{name}/look", _LOOKS)
    elif airframe.mesh is not None:
        _add_mesh(spec, body, airframe.mesh, name)
    else:
        _add_fuselage_looks(body, airframe)
    _add_gear_looks(body, airframe)
    for rotor in airframe.quadrotor.rotors:
        _add_rotor_looks(body, airframe, rotor)
    for mount in airframe.cameras:
        body.add_camera(
            name=part_name(number, mount.name),
            pos=mount.position_flu_m,
            quat=camera_quat_wxyz(mount),
            fovy=math.degrees(mount.vertical_fov_rad),
        )


def camera_quat_wxyz(mount: CameraMount) -> tuple[float, float, float, float]:
    """Return the attitude of MuJoCo's camera axes (x right, y up, z back) in the body frame."""
    # The optical frame has y down and z forward: both are flipped.
    rotation_flu_from_camera = mount.rotation_flu_from_optical * np.array([1.0, -1.0, -1.0])
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rotation_flu_from_camera.ravel())
    w, x, y, z = quat.tolist()
    return (w, x, y, z)


def leg_axes_flu_m(airframe: Airframe) -> list[tuple[Vector3, Vector3]]:
    """Return the ends of each leg's axis in the body frame: at the body, and above the sole.

    The lower end lies one leg radius above the sole, so that the capsule's surface touches the
    ground.
    """
    return [
        ((0.7 * x, 0.7 * y, 0.0), (x, y, z + airframe.leg_radius_m))
        for x, y, z in airframe.soles_flu_m
    ]


def skid_axes_flu_m(airframe: Airframe) -> list[tuple[Vector3, Vector3]]:
    """Return the ends of the axis of each skid in the body frame; none without skids."""
    if not airframe.has_skids:
        return []
    a, b, c, d = (foot for _, foot in leg_axes_flu_m(airframe))
    return [(a, b), (c, d)]


def _add_collision_shape(spec: mujoco.MjSpec, body: Any, airframe: Airframe, number: int) -> None:
    length, width, height = airframe.body_size_m
    name = part_name(number, "fuselage")
    if airframe.model is not None and airframe.model.hits_things:
        solids = read_body_file(Path(airframe.model.path)).solids
        add_parts(spec, body, solids, airframe.model.position_flu_m, name, _CONTACT)
    else:
        body.add_geom(name=name, type=_BOX, size=(length / 2, width / 2, height / 2), **_CONTACT)
    # A leg belongs to the arm of the same number; further legs follow without an arm.
    legs = leg_axes_flu_m(airframe)
    for i, rotor in enumerate(airframe.quadrotor.rotors):
        hub = rotor.position_flu_m
        disc = (airframe.rotor_radius_m, _disc_half_thickness_m(airframe), 0.0)
        turn = _tilt(rotor.axis_flu)
        name = part_name(number, f"disc{i}")
        body.add_geom(name=name, type=_CYLINDER, pos=hub, size=disc, quat=turn, **_CONTACT)
        arm = ((0.0, 0.0, 0.0), (hub[0], hub[1], 0.0))
        _add_bar(body, part_name(number, f"arm{i}"), *arm, airframe.arm_radius_m)
        if i < len(legs):
            _add_bar(body, part_name(number, f"leg{i}"), *legs[i], airframe.leg_radius_m)
    for i in range(len(airframe.quadrotor.rotors), len(legs)):
        _add_bar(body, part_name(number, f"leg{i}"), *legs[i], airframe.leg_radius_m)
    for i, ends in enumerate(skid_axes_flu_m(airframe)):
        _add_bar(body, part_name(number, f"skid{i}"), *ends, airframe.leg_radius_m)


def _add_bar(
    body: Any, name: str, start_flu_m: Vector3, end_flu_m: Vector3, radius_m: float
) -> None:
    ends, size = (*start_flu_m, *end_flu_m), (radius_m, 0.0, 0.0)
    body.add_geom(name=name, type=_CAPSULE, fromto=ends, size=size, **_CONTACT)


def _disc_half_thickness_m(airframe: Airframe) -> float:
    return min(_MOST_DISC_HALF_THICKNESS_M, 0.05 * airframe.rotor_radius_m)


def _tilt(axis_flu: Vector3) -> tuple[float, float, float, float]:
    """Rotation wxyz by the shortest way from body z to an axis."""
    quat = np.empty(4)
    mujoco.mju_quatZ2Vec(quat, np.array(axis_flu))
    w, x, y, z = quat.tolist()
    return (w, x, y, z)


def _add_fuselage_looks(body: Any, airframe: Airframe) -> None:
    x, y, z = airframe.body_size_m
    _show(body, _BOX, (0.46 * x, 0.42 * y, 0.22 * z), _CARBON)
    _show(body, _ELLIPSOID, (0.52 * x, 0.5 * y, 0.55 * z), _SHELL, (-0.02 * x, 0.0, 0.15 * z))
    _show(body, _ELLIPSOID, (0.27 * x, 0.42 * y, 0.48 * z), _FRONT, (0.27 * x, 0.0, 0.17 * z))
    _show(body, _BOX, (0.32 * x, 0.3 * y, 0.16 * z), _METAL, (-0.08 * x, 0.0, -0.36 * z))
    # The mast and puck of the GNSS antenna.
    _show(body, _CYLINDER, (0.22 * y, 0.09 * z, 0.0), _CARBON, (-0.25 * x, 0.0, 0.85 * z))


def _add_rotor_looks(body: Any, airframe: Airframe, rotor: RotorParams) -> None:
    x, y, z = rotor.position_flu_m
    is_front = x > _FRONT_SHARE * airframe.rotor_radius_m
    radius, arm_m = airframe.rotor_radius_m, airframe.arm_radius_m
    arm_rgba = _FRONT if is_front else _SHELL
    _show_tube(body, (0.0, 0.0, 0.0), (x, y, 0.0), arm_m, arm_rgba)
    # The motor ends just below the disc.
    motor_half_m = max((z + 1.2 * arm_m) / 2, 0.5 * arm_m)
    middle_flu_m = (x, y, z - motor_half_m - 0.2 * arm_m)
    _show(body, _CYLINDER, (airframe.motor_radius_m, motor_half_m, 0.0), _METAL, middle_flu_m)
    turn, blades = _tilt(rotor.axis_flu), np.empty(4)
    mujoco.mju_mulQuat(
        blades,
        np.array(turn),
        # Blades stand at an angle to the arm, so that both are visible.
        np.array(quat_about_up(math.atan2(y, x) + rotor.spin * math.radians(50.0))),
    )
    size_m = (0.97 * radius, arm_m, 0.15 * arm_m)
    _show(body, _BOX, size_m, _CARBON, rotor.position_flu_m, quat=blades)
    disc_rgba = _DISC_FRONT if is_front else _DISC_REAR
    disc_m = (radius, 0.3 * arm_m, 0.0)
    _show(body, _CYLINDER, disc_m, disc_rgba, rotor.position_flu_m, quat=turn)


def _add_mesh(spec: mujoco.MjSpec, body: Any, mesh: BodyMesh, name: str) -> None:
    # Only its surface is looked at: it need not be closed, and its mass is not asked for.
    spec.add_mesh(
        name=name,
        **mesh_source(mesh.path),
        scale=(mesh.scale, mesh.scale, mesh.scale),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        pos=mesh.position_flu_m,
        rgba=_SHELL,
        **_LOOKS,
    )


def _add_gear_looks(body: Any, airframe: Airframe) -> None:
    """Add the lenses, the legs and the skids to the looks."""
    lens_m = 1.4 * airframe.arm_radius_m
    for mount in airframe.cameras:
        _show(body, _ELLIPSOID, (lens_m, lens_m, lens_m), _LENS, mount.position_flu_m)
    for ends in (*leg_axes_flu_m(airframe), *skid_axes_flu_m(airframe)):
        _show_tube(body, *ends, airframe.leg_radius_m, _CARBON)


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
