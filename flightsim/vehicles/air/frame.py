"""Drag of the airframe: fuselage, arms, legs and motors, along each body axis.

    F_i = -(rho / 2) CdA_i |v_i| v_i

A part counts by its area across the flow times its drag coefficient; a round bar at an angle alpha
to the flow has CdA = Cd d l sin^3(alpha), the cross-flow principle. Parts do not shelter others.

Source: Hoerner 1965, Fluid-Dynamic Drag, chapter 3: drag of boxes, of round bars below the critical
Reynolds number (1.1, at an angle by the cross-flow principle) and of short ones on a surface.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flightsim.environment.atmosphere import AIR_DENSITY_KGPM3
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.builder import leg_axes_flu_m, skid_axes_flu_m

_BOX_DRAG_COEFFICIENT = 1.05
_BAR_DRAG_COEFFICIENT = 1.1
_SHORT_BAR_DRAG_COEFFICIENT = 0.7


def frame_drag(airframe: Airframe, *, has_arms: bool) -> Float[np.ndarray, " 3"]:
    """Return half the density times CdA along each body axis, kg/m.

    Args:
        airframe: The vehicle.
        has_arms: True counts arms, legs and motors besides the fuselage.
    """
    x, y, z = airframe.body_size_m
    area_m2 = _BOX_DRAG_COEFFICIENT * np.array([y * z, x * z, x * y])
    if has_arms:
        for rotor in airframe.quadrotor.rotors:
            area_m2 += _arm(airframe, np.array(rotor.position_flu_m))
        for start, end in (*leg_axes_flu_m(airframe), *skid_axes_flu_m(airframe)):
            area_m2 += _bar(np.subtract(end, start), airframe.leg_radius_m)
    return 0.5 * AIR_DENSITY_KGPM3 * area_m2


def _arm(airframe: Airframe, hub_flu_m: np.ndarray) -> np.ndarray:
    """CdA of an arm outside of the fuselage and of the motor at its end, m^2."""
    half_m = 0.5 * np.array(airframe.body_size_m[:2])
    across_m = np.abs(hub_flu_m[:2])
    # A hub on an axis never leaves the box sideways: infinity is right there.
    with np.errstate(divide="ignore"):
        inside = min(1.0, float(np.min(half_m / across_m)))
    # Arms count as level; a hub above them sits on its motor.
    arm_m = np.array([*hub_flu_m[:2], 0.0]) * (1.0 - inside)
    side_m2 = 2.0 * airframe.motor_radius_m * max(float(hub_flu_m[2]), 0.0)
    motor_m2 = _SHORT_BAR_DRAG_COEFFICIENT * np.array([side_m2, side_m2, 0.0])
    return _bar(arm_m, airframe.arm_radius_m) + motor_m2


def _bar(axis_m: np.ndarray, radius_m: float) -> np.ndarray:
    """CdA along each axis of a round bar of this direction and length, m^2."""
    length_m = float(np.linalg.norm(axis_m))
    if length_m == 0.0:
        return np.zeros(3)
    # Sine of the angle between bar and flow, for a flow along each axis.
    sine = np.sqrt(np.clip(1.0 - (axis_m / length_m) ** 2, 0.0, 1.0))
    return _BAR_DRAG_COEFFICIENT * 2.0 * radius_m * length_m * sine**3
