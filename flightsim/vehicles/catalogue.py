"""Airframes that ship: 3DR Iris in two parameter sets and AscTec Hummingbird.

Lengths of legs, arms and cameras are ours, chosen to look and stand like the real machines; the
flight parameters (mass, inertia, rotors) are from the source named above each number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from autonomy.model import QuadrotorParams, RotorParams
from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe, BatteryParams, CameraMount

# ISA at sea level, kg/m^3.
_AIR_DENSITY_KGPM3 = 1.225
# Rotor figure of merit (about 0.65) times motor and controller efficiency (about 0.77), usual for
# 8 to 10 inch propellers; gives the published endurances of 9 to 14 min (Iris) and 20 min
# (Hummingbird).
_PROPULSIVE_EFFICIENCY = 0.5

_CCW, _CW = 1, -1
_Four = tuple[Vector3, Vector3, Vector3, Vector3]


def _airframe(
    quadrotor: QuadrotorParams,
    rotor_radius_m: float,
    *,
    capacity_mah: float,
    internal_resistance_ohm: float,
    avionics_power_w: float,
    **others: Any,
) -> Airframe:
    """An airframe whose collision radius and battery follow from its rotors."""
    thrust_n = quadrotor.mass_kg * GRAVITY_MPS2 / 4
    # From momentum theory, T sqrt(T / (2 rho A)) a rotor.
    disc_m2 = math.pi * rotor_radius_m**2
    induced_w = thrust_n * math.sqrt(thrust_n / (2 * _AIR_DENSITY_KGPM3 * disc_m2))
    thrust_constant = sum(rotor.thrust_constant for rotor in quadrotor.rotors)
    battery = BatteryParams(
        cells=3,
        capacity_mah=capacity_mah,
        internal_resistance_ohm=internal_resistance_ohm,
        hover_power_w=4 * induced_w / _PROPULSIVE_EFFICIENCY,
        hover_rotor_speed_radps=math.sqrt(quadrotor.mass_kg * GRAVITY_MPS2 / thrust_constant),
        avionics_power_w=avionics_power_w,
    )
    reach_m = max(math.hypot(*rotor.position_flu_m[:2]) for rotor in quadrotor.rotors)
    return Airframe(
        quadrotor=quadrotor,
        rotor_radius_m=rotor_radius_m,
        collision_radius_m=reach_m + rotor_radius_m,
        battery=battery,
        **others,
    )


def _rotors(
    kind: RotorParams, hubs_flu_m: _Four, spins: tuple[int, int, int, int]
) -> tuple[RotorParams, RotorParams, RotorParams, RotorParams]:
    """Rotors of a kind at four hubs."""
    a, b, c, d = (
        replace(kind, position_flu_m=hub, spin=spin)
        for hub, spin in zip(hubs_flu_m, spins, strict=True)
    )
    return (a, b, c, d)


def _cameras(forward_flu_m: Vector3, down_flu_m: Vector3) -> tuple[CameraMount, CameraMount]:
    """One camera ahead, pitched to see the ground in front, and one straight down."""
    return (
        CameraMount(
            name="forward",
            position_flu_m=forward_flu_m,
            pitch_down_rad=math.radians(15.0),
            # 75 degrees across at 4:3, between a D435's 69 and a D455's 86 (Intel RealSense).
            vertical_fov_rad=math.radians(60.0),
        ),
        CameraMount(
            name="down",
            position_flu_m=down_flu_m,
            pitch_down_rad=math.pi / 2,
            vertical_fov_rad=math.radians(60.0),
        ),
    )


# RotorS iris.xacro and hummingbird.xacro.
_ROTORS_ROTOR = RotorParams(
    position_flu_m=(0.0, 0.0, 0.0),
    spin=_CCW,
    thrust_constant=8.54858e-6,
    torque_per_thrust_m=0.016,
    time_constant_up_s=0.0125,
    time_constant_down_s=0.025,
    max_speed_radps=838.0,
    drag_coefficient=8.06428e-5,
    rolling_moment_coefficient=1e-6,
)
# PX4 iris.sdf, motor model plugins; it has RotorS's time constants and rolling moment.
_PX4_ROTOR = replace(
    _ROTORS_ROTOR,
    thrust_constant=5.84e-6,
    torque_per_thrust_m=0.06,
    max_speed_radps=1100.0,
    drag_coefficient=1.75e-4,
)


def _iris(name: str, title: str, inertia_flu_kgm2: Vector3, rotor: RotorParams) -> Airframe:
    # Hub positions: RotorS iris.xacro, PX4 iris.sdf; 0.023 m above the base link, less the 0.0003 m
    # by which four rotors of 0.005 kg lift the centre of mass of 1.535 kg.
    h = 0.0227
    hubs = ((0.13, -0.22, h), (-0.13, 0.20, h), (0.13, 0.22, h), (-0.13, -0.20, h))
    return _airframe(
        QuadrotorParams(
            # RotorS iris.xacro, PX4 iris.sdf: body 1.5, four rotors of 0.005, IMU 0.015.
            mass_kg=1.535,
            inertia_flu_kgm2=inertia_flu_kgm2,
            rotors=_rotors(rotor, hubs, (_CCW, _CCW, _CW, _CW)),
        ),
        # PX4 iris.sdf, rotor collision cylinder.
        rotor_radius_m=0.128,
        # A rod of RotorS's 0.005 kg over the diameter.
        rotor_inertia_kgm2=2.7e-5,
        name=name,
        title=title,
        drone_class="medium",
        body_size_m=(0.22, 0.11, 0.07),
        leg_length_m=0.11,
        leg_spread_m=0.20,
        # 3DR Iris: 3S 3500 mAh, 8C.
        capacity_mah=3500.0,
        # About 8 mOhm a cell, usual at 8C, and 10 mOhm of leads and plug.
        internal_resistance_ohm=0.034,
        avionics_power_w=6.0,
        cameras=_cameras((0.13, 0.0, 0.0), (0.04, 0.0, -0.045)),
    )


# PX4 iris.sdf, base link.
_IRIS = _iris("iris", "3DR Iris, PX4 parameters", (0.029125, 0.029125, 0.055225), _PX4_ROTOR)
# RotorS iris.xacro but for Izz: its 0.0977 exceeds Ixx + Iyy, impossible for a rigid body and
# refused by MuJoCo; this is the largest possible.
_IRIS_ROTORS = _iris(
    "iris-rotors",
    "3DR Iris, RotorS parameters",
    (0.0347563, 0.0458929, 0.0806492),
    _ROTORS_ROTOR,
)

_HUMMINGBIRD = _airframe(
    QuadrotorParams(
        # RotorS hummingbird.xacro: body 0.68, four rotors of 0.009, IMU 0.015.
        mass_kg=0.731,
        # RotorS hummingbird.xacro.
        inertia_flu_kgm2=(0.007, 0.007, 0.012),
        rotors=_rotors(
            _ROTORS_ROTOR,
            # RotorS hummingbird.xacro: arms of 0.17 m, hubs 0.01 m above the base link, less the
            # 0.0005 m by which four rotors of 0.009 kg lift the centre of mass of 0.731 kg.
            ((0.17, 0.0, 0.0095), (0.0, 0.17, 0.0095), (-0.17, 0.0, 0.0095), (0.0, -0.17, 0.0095)),
            (_CW, _CCW, _CW, _CCW),
        ),
    ),
    # RotorS hummingbird.xacro.
    rotor_radius_m=0.1,
    # A rod of RotorS's 0.009 kg over the diameter.
    rotor_inertia_kgm2=3.0e-5,
    name="hummingbird",
    title="AscTec Hummingbird, RotorS parameters",
    drone_class="small",
    body_size_m=(0.11, 0.11, 0.06),
    leg_length_m=0.08,
    leg_spread_m=0.14,
    # AscTec Hummingbird: 3S 2100 mAh.
    capacity_mah=2100.0,
    # About 10 mOhm a cell, usual for packs of this size, and 10 mOhm of leads and plug.
    internal_resistance_ohm=0.040,
    avionics_power_w=4.0,
    cameras=_cameras((0.07, 0.0, -0.02), (0.02, 0.0, -0.04)),
)

AIRFRAMES: Mapping[str, Airframe] = MappingProxyType(
    {airframe.name: airframe for airframe in (_IRIS, _IRIS_ROTORS, _HUMMINGBIRD)}
)


class AirframeError(ValueError):
    """No airframe has the requested name."""


def airframe_by_name(name: str) -> Airframe:
    """Airframe called `name`.

    Raises:
        AirframeError: Listing the valid names.
    """
    if name not in AIRFRAMES:
        raise AirframeError(f"vehicle {name!r} is unknown; valid: {', '.join(AIRFRAMES)}")
    return AIRFRAMES[name]
