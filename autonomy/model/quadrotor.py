"""Physical parameters of a quadrotor, shared by control, planning and simulation."""

from __future__ import annotations

from dataclasses import dataclass

from autonomy.types import Vector3

GRAVITY_MPS2 = 9.81


@dataclass(frozen=True, kw_only=True, slots=True)
class RotorParams:
    """One rotor: where it sits and what it makes of its speed."""

    position_flu_m: Vector3
    """Hub in the body frame, relative to the centre of mass."""
    spin: int
    """+1 turns counter-clockwise seen from above, -1 clockwise."""
    thrust_constant: float
    """kf in N s^2/rad^2: thrust = kf w^2 along body z."""
    torque_per_thrust_m: float
    """Reaction torque about body z = -spin x thrust x this."""
    time_constant_up_s: float
    time_constant_down_s: float
    max_speed_radps: float
    drag_coefficient: float
    """Drag force = -|w| x this x v_perp, v relative to the wind."""
    rolling_moment_coefficient: float
    """Rolling moment = -|w| x this x v_perp."""


@dataclass(frozen=True, kw_only=True, slots=True)
class QuadrotorParams:
    """A rigid body with four rotors, origin in its centre of mass, FLU axes."""

    mass_kg: float
    inertia_flu_kgm2: Vector3
    """Principal moments Ixx, Iyy, Izz."""
    rotors: tuple[RotorParams, RotorParams, RotorParams, RotorParams]

    @property
    def max_thrust_n(self) -> float:
        """Collective thrust with all rotors at full speed, N."""
        return sum(r.thrust_constant * r.max_speed_radps**2 for r in self.rotors)

    @property
    def hover_thrust_fraction(self) -> float:
        """Weight over maximum thrust."""
        return self.mass_kg * GRAVITY_MPS2 / self.max_thrust_n
