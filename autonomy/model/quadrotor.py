"""Physical parameters of a multirotor, shared by control, planning and simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autonomy.types import Vector3

GRAVITY_MPS2 = 9.81
MAX_ROTORS = 12
"""Most rotors of a vehicle. Records of the kernels have fixed sizes, with room for this many."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RotorParams:
    """One rotor: its position and its coefficients.

    Coefficients follow the rotor model of Furrer et al. 2016 (RotorS): forces grow with the square
    of the rotor speed w in rad/s, and drag with w and the speed across the axis.
    """

    position_flu_m: Vector3
    """Position of the hub in the body frame, relative to the centre of mass."""
    spin: int
    """+1 turns counter-clockwise seen from above, -1 clockwise."""
    thrust_constant: float
    """kf in N s^2/rad^2: thrust = kf w^2 along its axis."""
    torque_per_thrust_m: float
    """Reaction torque about its axis = -spin x thrust x this."""
    # Lags of first order; a rotor spins down more slowly, because only the air brakes it.
    time_constant_up_s: float
    time_constant_down_s: float
    max_speed_radps: float
    drag_coefficient: float
    """Drag force = -|w| x this x v_perp, v relative to the wind."""
    rolling_moment_coefficient: float
    """Rolling moment = -|w| x this x v_perp."""
    axis_flu: Vector3 = (0.0, 0.0, 1.0)
    """Unit vector along which the rotor pulls: up, unless the rotor is canted."""


@dataclass(frozen=True, kw_only=True, slots=True)
class QuadrotorParams:
    """A rigid body with usually four rotors, origin in its centre of mass, FLU axes."""

    mass_kg: float
    inertia_flu_kgm2: Vector3
    """Principal moments Ixx, Iyy, Izz."""
    rotors: tuple[RotorParams, ...]
    """At most `MAX_ROTORS`; `autonomy.model.layout` says which layouts can be flown."""

    @property
    def max_thrust_n(self) -> float:
        """Collective thrust along body z with all rotors at full speed, N."""
        return sum(r.thrust_constant * r.max_speed_radps**2 * r.axis_flu[2] for r in self.rotors)

    @property
    def hover_speed_radps(self) -> float:
        """Speed at which the rotors, all turning alike, carry the weight, rad/s."""
        lift = sum(r.thrust_constant * r.axis_flu[2] for r in self.rotors)
        return math.sqrt(self.mass_kg * GRAVITY_MPS2 / lift)

    @property
    def hover_thrust_fraction(self) -> float:
        """Weight over maximum thrust, 0 to 1; a setpoint with this `thrust` hovers."""
        return self.mass_kg * GRAVITY_MPS2 / self.max_thrust_n
