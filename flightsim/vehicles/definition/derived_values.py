"""Values that an airframe's file may leave out: they follow from mass, rotors and geometry."""

from __future__ import annotations

import math

from aeroscene.areas.needs import NEEDS
from aeroscene.scene import DroneClass
from autonomy.model import QuadrotorParams
from autonomy.model.quadrotor import GRAVITY_MPS2

# ISA at sea level, kg/m^3.
_AIR_DENSITY_KGPM3 = 1.225
# Rotor figure of merit (about 0.65) times motor and controller efficiency (about 0.77), usual for
# 8 to 10 inch propellers; gives the published endurances of 9 to 14 min (Iris) and 20 min
# (Hummingbird).
PROPULSIVE_EFFICIENCY = 0.5
# A propeller of the Iris's share of the mass, 0.005 kg of 1.535, as a rod over the diameter.
_PROPELLER_MASS = 0.0035
# Rotor and bell of 2 % of the vehicle's mass, balanced to G 32 (ISO 21940-11).
_ROTOR_MASS = 0.02
_BALANCE_MPS = 0.032
# The no-load current of a brushless motor is some 5 % of that in hover.
_FRICTION = 0.05
_SCATTER_M = 0.15
"""Room that a landing takes besides the vehicle itself."""


def hover_power_w(quadrotor: QuadrotorParams, radius_m: float, efficiency: float) -> float:
    """Electrical power of all motors in hover, by momentum theory: T sqrt(T / 2 rho A) a rotor.

    Args:
        quadrotor: Mass and rotors.
        radius_m: Radius of a rotor.
        efficiency: Induced power over electrical power, 0 to 1.
    """
    n = len(quadrotor.rotors)
    thrust_n = quadrotor.mass_kg * GRAVITY_MPS2 / n
    disc_m2 = math.pi * radius_m**2
    induced_w = thrust_n * math.sqrt(thrust_n / (2 * _AIR_DENSITY_KGPM3 * disc_m2))
    return n * induced_w / efficiency


def rotor_inertia_kgm2(quadrotor: QuadrotorParams, radius_m: float) -> float:
    """Return the moment of inertia of a rotor about its axis, kg m^2: that of a rod, m d^2 / 12.

    Args:
        quadrotor: Vehicle, whose mass gives that of a propeller.
        radius_m: Radius of a rotor, half of the rod.
    """
    return _PROPELLER_MASS * quadrotor.mass_kg * (2.0 * radius_m) ** 2 / 12.0


def rotor_imbalance_kgm(quadrotor: QuadrotorParams) -> float:
    """Return the imbalance of a rotor, kg m.

    A balance grade G is the speed e w of the centre of mass, so the imbalance is G m / w at hover
    speed.
    """
    return _BALANCE_MPS / quadrotor.hover_speed_radps * _ROTOR_MASS * quadrotor.mass_kg


def rotor_friction_nm(quadrotor: QuadrotorParams) -> float:
    """Return the friction of a motor, N m: a share of the least torque in hover."""
    least_m = min(rotor.torque_per_thrust_m for rotor in quadrotor.rotors)
    thrust_n = quadrotor.mass_kg * GRAVITY_MPS2 / len(quadrotor.rotors)
    return _FRICTION * least_m * thrust_n


def reach_m(quadrotor: QuadrotorParams) -> float:
    """Return the greatest horizontal distance of a hub from the centre of mass, m."""
    return max(math.hypot(*rotor.position_flu_m[:2]) for rotor in quadrotor.rotors)


def drone_class(collision_radius_m: float) -> DroneClass | None:
    """Return the smallest class whose areas have room for a vehicle.

    Args:
        collision_radius_m: Radius of the upright cylinder around the vehicle.

    Returns:
        The class; None if the vehicle is too large for any.
    """
    for name in ("small", "medium", "large"):
        if collision_radius_m <= NEEDS[name].flight_radius_m - _SCATTER_M:
            return name
    return None


def largest_radius_m() -> float:
    """Return the greatest radius of a vehicle that has a class, m."""
    return NEEDS["large"].flight_radius_m - _SCATTER_M
