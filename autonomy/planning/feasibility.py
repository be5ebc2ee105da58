"""Feasibility of a motion primitive: thrust, body rate, speed, tilt and room, compiled.

A planner by sampling tests thousands of primitives, so a test must be cheap, and samples of thrust
would miss peaks. With acceleration a, jerk j and gravity g the thrust over mass is f = |a + g e3|,
and the body rate across it at most |j| / f. On a section of time each axis of a lies between a_low
and a_high, each axis of j within j_most, so

    f^2 <= sum over axes of max(a_low^2, a_high^2), g added to the vertical one
    f^2 >= the same with the least squares in place of the largest, 0 where the axis changes sign
    rate^2 <= sum of j_most^2 / least f^2

If these bounds prove a section, it is done; any other is halved, down to 20 ms.

Source: Mueller, Hehn and D'Andrea 2015, "A computationally efficient motion primitive for
quadrocopter trajectory generation", section IV, the recursive test of input feasibility. Speed,
acceleration and tilt, which they do not bound, are tested at samples, and obstacles as in our
certificate.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.model.flatness import hover_drag_per_s
from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams
from autonomy.planning.clearance import clearance_along
from autonomy.planning.limits import FlightLimits, MotionBounds
from autonomy.planning.moving_obstacles import Movers
from autonomy.planning.solids import Solids

_N_SAMPLES = 24
_LEAST_SECTION_S = 0.02


def allowances(
    bounds: MotionBounds, limits: FlightLimits, quadrotor: QuadrotorParams, share: float
) -> Float[np.ndarray, " 8"]:
    """Return bounds for `first_feasible`, as a share of the limits.

    Args:
        bounds: Speeds and accelerations of the motion.
        limits: Limits of thrust, body rate and tilt.
        quadrotor: Mass, thrust and drag of the vehicle.
        share: Factor on every limit, for example 0.98 to leave a reserve.
    """
    return np.array(
        [
            *(share * bounds.as_array()),
            share * limits.max_specific_thrust_mps2(quadrotor),
            share * limits.body_rate_radps,
            math.tan(share * limits.tilt_rad),
            hover_drag_per_s(quadrotor),
        ]
    )


@kernel
def first_feasible(
    order: Int[np.ndarray, " m"],
    coefficients: Float[np.ndarray, "m 6 3"],
    durations: Float[np.ndarray, " m"],
    allowed: Float[np.ndarray, " 8"],
    solids: Solids,
    movers: Movers,
    radius: float,
) -> int:
    """Return the first index into `order` whose primitive can be flown and is clear; -1 if none.

    Args:
        order: Primitives to try, best first; -1 for those that were tried.
        coefficients: Coefficients of all primitives.
        durations: Durations of all primitives, s.
        allowed: Horizontal and vertical speed and acceleration, thrust over mass, body rate,
            tangent of the tilt, rotor drag per speed.
        solids: Static obstacles.
        movers: Moving obstacles.
        radius: Distance to keep, m.
    """
    speeds = np.array([math.hypot(allowed[0], allowed[1])])
    for n in range(len(order)):
        i = order[n]
        if i < 0:
            continue
        c, t = coefficients[i], float(durations[i])
        # Cheapest test first; the march along obstacles is the dearest.
        if not is_input_feasible(c, 0.0, t, allowed[4], allowed[5]):
            continue
        if not _within_bounds(c, t, allowed):
            continue
        one = coefficients[i : i + 1]
        if clearance_along(durations[i : i + 1], one, speeds, solids, movers, radius)[0] > radius:
            return n
    return -1


@kernel
def is_input_feasible(
    c: Float[np.ndarray, "6 3"], begin: float, end: float, thrust: float, rate: float
) -> bool:
    """Return whether thrust over mass and body rate stay within limits: bounds on halves of halves.

    On a section each axis of the acceleration lies between its extremes, so thrust is bounded from
    both sides, and the body rate by the largest jerk over the least thrust. False also means that a
    section of 20 ms could not be proved.
    """
    begins, ends = [begin], [end]
    while len(begins) > 0:
        a, b = begins.pop(), ends.pop()
        least, most, jerk = 0.0, 0.0, 0.0
        for axis in range(3):
            low, high = _extremes(c, axis, a, b)
            if axis == 2:
                low, high = low + GRAVITY_MPS2, high + GRAVITY_MPS2
            most += max(low * low, high * high)
            least += 0.0 if low < 0.0 < high else min(low * low, high * high)
            largest = _largest_jerk(c, axis, a, b)
            jerk += largest * largest
        if most <= thrust * thrust and jerk <= rate * rate * least:
            continue
        # The ends of the section are exact: a failure there is one of the primitive.
        if least > thrust * thrust or b - a < _LEAST_SECTION_S:
            return False
        middle = 0.5 * (a + b)
        begins.append(a)
        ends.append(middle)
        begins.append(middle)
        ends.append(b)
    return True


@kernel
def _extremes(c: Float[np.ndarray, "6 3"], axis: int, a: float, b: float) -> tuple[float, float]:
    """Least and largest acceleration on a section: at its ends or where the jerk is zero."""
    at_a, at_b = _acceleration(c, axis, a), _acceleration(c, axis, b)
    low, high = min(at_a, at_b), max(at_a, at_b)
    p, q, r = 60.0 * c[5, axis], 24.0 * c[4, axis], 6.0 * c[3, axis]
    square = q * q - 4.0 * p * r
    if square < 0.0:
        return low, high
    root = math.sqrt(square)
    for sign in (-1.0, 1.0):
        # Roots of p t^2 + q t + r without cancellation: q and the root are added with equal signs.
        over = -(q + (root if q >= 0.0 else -root)) / 2.0
        t = over / p if sign > 0.0 and p != 0.0 else (r / over if over != 0.0 else a)
        if a < t < b:
            value = _acceleration(c, axis, t)
            low, high = min(low, value), max(high, value)
    return low, high


@kernel
def _acceleration(c: Float[np.ndarray, "6 3"], axis: int, t: float) -> float:
    return 2.0 * c[2, axis] + t * (
        6.0 * c[3, axis] + t * (12.0 * c[4, axis] + t * 20.0 * c[5, axis])
    )


@kernel
def _jerk(c: Float[np.ndarray, "6 3"], axis: int, t: float) -> float:
    return 6.0 * c[3, axis] + t * (24.0 * c[4, axis] + t * 60.0 * c[5, axis])


@kernel
def _largest_jerk(c: Float[np.ndarray, "6 3"], axis: int, a: float, b: float) -> float:
    """Largest jerk on a section, a parabola: at the section's ends or at its vertex."""
    largest = max(abs(_jerk(c, axis, a)), abs(_jerk(c, axis, b)))
    if c[5, axis] != 0.0:
        t = -24.0 * c[4, axis] / (120.0 * c[5, axis])
        if a < t < b:
            largest = max(largest, abs(_jerk(c, axis, t)))
    return largest


@kernel
def _within_bounds(
    c: Float[np.ndarray, "6 3"], duration: float, allowed: Float[np.ndarray, " 8"]
) -> bool:
    """Return whether speed, acceleration and tilt with drag keep their bounds at samples."""
    for n in range(_N_SAMPLES + 1):
        t = duration * n / _N_SAMPLES
        v, h = np.empty(3), np.empty(3)
        for axis in range(3):
            v[axis] = c[1, axis] + t * (
                2.0 * c[2, axis]
                + t * (3.0 * c[3, axis] + t * (4.0 * c[4, axis] + t * 5.0 * c[5, axis]))
            )
            h[axis] = _acceleration(c, axis, t)
        if math.hypot(v[0], v[1]) > allowed[0] or abs(v[2]) > allowed[1]:
            return False
        if math.hypot(h[0], h[1]) > allowed[2] or abs(h[2]) > allowed[3]:
            return False
        h += allowed[7] * v
        if math.hypot(h[0], h[1]) > allowed[6] * (h[2] + GRAVITY_MPS2):
            return False
    return True
