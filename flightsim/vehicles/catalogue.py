"""Airframes that ship: 3DR Iris in two parameter sets and AscTec Hummingbird.

Lengths of legs, arms and cameras are ours, chosen to look and stand like the real machines; the
flight parameters (mass, inertia, rotors) are from the source named above each number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

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


def hover_rotor_speed_radps(quadrotor: QuadrotorParams) -> float:
    """Rotor speed at which four equal rotors carry the weight."""
    thrust_constant = sum(r.thrust_constant for r in quadrotor.rotors)
    return math.sqrt(quadrotor.mass_kg * GRAVITY_MPS2 / thrust_constant)


def hover_power_w(mass_kg: float, rotor_radius_m: float) -> float:
    """Electrical power of four motors in hover, from momentum theory: T sqrt(T / (2 rho A))."""
    thrust_n = mass_kg * GRAVITY_MPS2 / 4
    disc_m2 = math.pi * rotor_radius_m**2
    induced_w = thrust_n * math.sqrt(thrust_n / (2 * _AIR_DENSITY_KGPM3 * disc_m2))
    return 4 * induced_w / _PROPULSIVE_EFFICIENCY


def _rotors(
    hubs_flu_m: tuple[Vector3, Vector3, Vector3, Vector3],
    spins: tuple[int, int, int, int],
    *,
    thrust_constant: float,
    torque_per_thrust_m: float,
    max_speed_radps: float,
    drag_coefficient: float,
) -> tuple[RotorParams, RotorParams, RotorParams, RotorParams]:
    def rotor(i: int) -> RotorParams:
        return RotorParams(
            position_flu_m=hubs_flu_m[i],
            spin=spins[i],
            thrust_constant=thrust_constant,
            torque_per_thrust_m=torque_per_thrust_m,
            # RotorS iris.xacro and hummingbird.xacro; PX4 iris.sdf has the same.
            time_constant_up_s=0.0125,
            time_constant_down_s=0.025,
            max_speed_radps=max_speed_radps,
            drag_coefficient=drag_coefficient,
            # RotorS iris.xacro and hummingbird.xacro; PX4 iris.sdf has the same.
            rolling_moment_coefficient=1e-6,
        )

    return (rotor(0), rotor(1), rotor(2), rotor(3))


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


# Hub positions: RotorS iris.xacro, PX4 iris.sdf; 0.023 m above the base link, less the 0.0003 m by
# which four rotors of 0.005 kg lift the centre of mass of 1.535 kg.
_IRIS_HUBS_FLU_M: tuple[Vector3, Vector3, Vector3, Vector3] = (
    (0.13, -0.22, 0.0227),
    (-0.13, 0.20, 0.0227),
    (0.13, 0.22, 0.0227),
    (-0.13, -0.20, 0.0227),
)
_IRIS_SPINS = (_CCW, _CCW, _CW, _CW)
# RotorS iris.xacro, PX4 iris.sdf: body 1.5, four rotors of 0.005, IMU 0.015.
_IRIS_MASS_KG = 1.535
# PX4 iris.sdf, rotor collision cylinder.
_IRIS_ROTOR_RADIUS_M = 0.128


def _iris(name: str, title: str, quadrotor: QuadrotorParams) -> Airframe:
    return Airframe(
        name=name,
        title=title,
        drone_class="medium",
        quadrotor=quadrotor,
        body_size_m=(0.22, 0.11, 0.07),
        rotor_radius_m=_IRIS_ROTOR_RADIUS_M,
        leg_length_m=0.11,
        leg_spread_m=0.20,
        # Hub of a front rotor at hypot(0.13, 0.22), plus the disc.
        collision_radius_m=math.hypot(0.13, 0.22) + _IRIS_ROTOR_RADIUS_M,
        battery=BatteryParams(
            cells=3,
            # 3DR Iris: 3S 3500 mAh, 8C.
            capacity_mah=3500.0,
            # About 8 mOhm a cell, usual at 8C, and 10 mOhm of leads and plug.
            internal_resistance_ohm=0.034,
            hover_power_w=hover_power_w(quadrotor.mass_kg, _IRIS_ROTOR_RADIUS_M),
            hover_rotor_speed_radps=hover_rotor_speed_radps(quadrotor),
            avionics_power_w=6.0,
        ),
        cameras=_cameras((0.13, 0.0, 0.0), (0.04, 0.0, -0.045)),
    )


_IRIS = _iris(
    "iris",
    "3DR Iris, PX4 parameters",
    QuadrotorParams(
        mass_kg=_IRIS_MASS_KG,
        # PX4 iris.sdf, base link.
        inertia_flu_kgm2=(0.029125, 0.029125, 0.055225),
        rotors=_rotors(
            _IRIS_HUBS_FLU_M,
            _IRIS_SPINS,
            # PX4 iris.sdf, motor model plugins.
            thrust_constant=5.84e-6,
            torque_per_thrust_m=0.06,
            max_speed_radps=1100.0,
            drag_coefficient=1.75e-4,
        ),
    ),
)

_IRIS_ROTORS = _iris(
    "iris-rotors",
    "3DR Iris, RotorS parameters",
    QuadrotorParams(
        mass_kg=_IRIS_MASS_KG,
        # RotorS iris.xacro but for Izz: its 0.0977 exceeds Ixx + Iyy, impossible for a rigid body
        # and refused by MuJoCo; this is the largest possible.
        inertia_flu_kgm2=(0.0347563, 0.0458929, 0.0806492),
        rotors=_rotors(
            _IRIS_HUBS_FLU_M,
            _IRIS_SPINS,
            # RotorS iris.xacro.
            thrust_constant=8.54858e-6,
            torque_per_thrust_m=0.016,
            max_speed_radps=838.0,
            drag_coefficient=8.06428e-5,
        ),
    ),
)

_HUMMINGBIRD_QUADROTOR = QuadrotorParams(
    # RotorS hummingbird.xacro: body 0.68, four rotors of 0.009, IMU 0.015.
    mass_kg=0.731,
    # RotorS hummingbird.xacro.
    inertia_flu_kgm2=(0.007, 0.007, 0.012),
    rotors=_rotors(
        # RotorS hummingbird.xacro: arms of 0.17 m, hubs 0.01 m above the base link, less 0.0005 m
        # by which four rotors of 0.009 kg lift the centre of mass of 0.731 kg.
        ((0.17, 0.0, 0.0095), (0.0, 0.17, 0.0095), (-0.17, 0.0, 0.0095), (0.0, -0.17, 0.0095)),
        (_CW, _CCW, _CW, _CCW),
        # RotorS hummingbird.xacro.
        thrust_constant=8.54858e-6,
        torque_per_thrust_m=0.016,
        max_speed_radps=838.0,
        drag_coefficient=8.06428e-5,
    ),
)
# RotorS hummingbird.xacro.
_HUMMINGBIRD_ROTOR_RADIUS_M = 0.1

_HUMMINGBIRD = Airframe(
    name="hummingbird",
    title="AscTec Hummingbird, RotorS parameters",
    drone_class="small",
    quadrotor=_HUMMINGBIRD_QUADROTOR,
    body_size_m=(0.11, 0.11, 0.06),
    rotor_radius_m=_HUMMINGBIRD_ROTOR_RADIUS_M,
    leg_length_m=0.08,
    leg_spread_m=0.14,
    collision_radius_m=0.17 + _HUMMINGBIRD_ROTOR_RADIUS_M,
    battery=BatteryParams(
        cells=3,
        # AscTec Hummingbird: 3S 2100 mAh.
        capacity_mah=2100.0,
        # About 10 mOhm a cell, usual for packs of this size, and 10 mOhm of leads and plug.
        internal_resistance_ohm=0.040,
        hover_power_w=hover_power_w(_HUMMINGBIRD_QUADROTOR.mass_kg, _HUMMINGBIRD_ROTOR_RADIUS_M),
        hover_rotor_speed_radps=hover_rotor_speed_radps(_HUMMINGBIRD_QUADROTOR),
        avionics_power_w=4.0,
    ),
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
    try:
        return AIRFRAMES[name]
    except KeyError:
        raise AirframeError(f"vehicle {name!r} is unknown; valid: {', '.join(AIRFRAMES)}") from None
