"""Differential flatness with rotor drag: the demands of a trajectory on a quadrotor.

Thrust, tilt and body rates of a quadrotor follow from its trajectory by algebra. The planner can
therefore limit them without simulating the vehicle. Rotor drag is included, because it tilts a fast
vehicle further.

    symbol  name                                              unit
    v a j   velocity, acceleration, jerk of the flat output   m/s, m/s^2, m/s^3
    z       direction of the rotors' thrust
    c       collective thrust over mass                       m/s^2
    d       rotor drag over mass and speed across z           1/s
    h       a + g e_3 + d v

From  a = -g e_3 + c z - d (v - (v.z) z)  follows  (c + d v.z) z = h,  so  z = h / |h|  and c = |h|
- d v.z. The drag of a rotor grows with its speed, so d = k sqrt(c) for four rotors that share the
thrust; the fixed point is reached in a few steps.

The same algebra accepts numpy arrays and CasADi expressions.

Source: Faessler, Franchi and Scaramuzza 2018, "Differential flatness of quadrotor dynamics subject
to rotor drag"; their drag is constant, ours follows the rotor model of Furrer et al. 2016.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams

# A fixed number of steps, so that the same code is an expression of CasADi's.
_FIXED_POINT_STEPS = 4
_LEAST_SQUARE = 1e-6  # of |h|: in free fall the attitude is undefined


@dataclass(frozen=True, kw_only=True, slots=True)
class Effort:
    """Demands of a trajectory at one point or, as arrays, at many."""

    specific_thrust_mps2: Any
    """Collective thrust over mass."""
    cos_tilt: Any
    """Cosine of the angle between thrust and the vertical."""
    tilt_rate_radps: Any
    """Body rate about the axes across the thrust, roll and pitch together."""
    force_mps2: Any
    """|h|: thrust and rotor drag over mass."""
    drag_per_s: Any
    """Rotor drag d over mass and speed."""


def drag_constant(quadrotor: QuadrotorParams) -> float:
    """Return the constant k in d = k sqrt(c), in s^-1 / (m/s^2)^(1/2).

    It follows from d = sum(drag_i w) / m and c m = sum(kf_i w^2) for rotors that all turn at w.
    """
    thrust = sum(rotor.thrust_constant for rotor in quadrotor.rotors)
    drag = sum(rotor.drag_coefficient for rotor in quadrotor.rotors)
    return drag / math.sqrt(quadrotor.mass_kg * thrust)


def hover_drag_per_s(quadrotor: QuadrotorParams) -> float:
    """Rotor drag d in hover, 1/s."""
    return drag_constant(quadrotor) * math.sqrt(GRAVITY_MPS2)


def effort(velocity: Any, acceleration: Any, jerk: Any, quadrotor: QuadrotorParams) -> Effort:
    """Return the thrust, tilt and tilt rate along a trajectory in still air.

    Args:
        velocity: Three components, each a number, an array or a CasADi expression; m/s, ENU.
        acceleration: Acceleration in the same form.
        jerk: Jerk in the same form.
        quadrotor: Mass, thrust and drag of the vehicle.
    """
    k = drag_constant(quadrotor)
    thrust = GRAVITY_MPS2 + 0 * acceleration[2]
    for _ in range(_FIXED_POINT_STEPS):
        drag = k * thrust**0.5
        h = _force(velocity, acceleration, drag)
        norm = (_dot(h, h) + _LEAST_SQUARE) ** 0.5
        along = _dot(velocity, h) / norm
        # Never below a small share of |h|: a fast climb with little thrust has no fixed point.
        surplus = 0.9 * norm - drag * along
        # A smooth maximum with zero: the optimiser needs derivatives everywhere.
        thrust = 0.1 * norm + 0.5 * (surplus + (surplus**2 + _LEAST_SQUARE) ** 0.5)
    drag = k * thrust**0.5
    h = _force(velocity, acceleration, drag)
    norm = (_dot(h, h) + _LEAST_SQUARE) ** 0.5
    turn = [j + drag * a for j, a in zip(jerk, acceleration, strict=True)]
    # d follows the thrust: d' = d c' / (2 c).
    swell = drag * _dot(turn, h) / norm / (2 * thrust)
    turn = [t + swell * v for t, v in zip(turn, velocity, strict=True)]
    across = _dot(turn, turn) - (_dot(turn, h) / norm) ** 2
    return Effort(
        specific_thrust_mps2=thrust,
        cos_tilt=h[2] / norm,
        # Rounding makes a square slightly negative; `max` has no form that both numpy and CasADi
        # accept.
        tilt_rate_radps=(across * (across > 0) + _LEAST_SQUARE) ** 0.5 / norm,
        force_mps2=norm,
        drag_per_s=drag,
    )


def _force(velocity: Any, acceleration: Any, drag: Any) -> list[Any]:
    h = [a + drag * v for v, a in zip(velocity, acceleration, strict=True)]
    return [h[0], h[1], h[2] + GRAVITY_MPS2]


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
