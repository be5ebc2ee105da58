"""Trajectory: polynomials of degree 5 in time for position, a table of angles for yaw.

Degree 5 is the least with which position, velocity and acceleration can be chosen at both ends of a
piece. The heading is a table, because it follows the path by a filter that is no polynomial.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from autonomy.planning.corridor import Corridor
from autonomy.types import FlatReference, Vector3

DEGREE = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class YawProfile:
    """Heading on a regular grid of times, linear in between, constant beyond the end."""

    step_s: float
    yaw_rad: Float[np.ndarray, " n"]
    """Headings, unwrapped."""

    @cached_property
    def _angles(self) -> list[float]:
        return self.yaw_rad.tolist()

    def sample(self, t_s: float) -> tuple[float, float]:
        """Return the heading and its rate at a time, rad and rad/s."""
        angles = self._angles
        at = t_s / self.step_s
        index = int(at)
        if index >= len(angles) - 1:
            return angles[-1], 0.0
        rate = (angles[index + 1] - angles[index]) / self.step_s
        return angles[index] + rate * (at - index) * self.step_s, rate


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """Motion to fly from time 0 to `duration_s`; before and after that the vehicle stands still."""

    durations_s: Float[np.ndarray, " n"]
    coefficients: Float[np.ndarray, "n 6 3"]
    """Coefficients of rising powers of the time since a piece's beginning, ENU, m."""
    yaw: YawProfile
    min_clearance_m: float = field(default=float("nan"))
    """Certified distance between the vehicle's sphere and the nearest obstacle."""
    corridor: Corridor | None = None
    """Free space of the plan, one polytope for each piece; None for a plain leg."""

    @cached_property
    def ends_s(self) -> list[float]:
        """End time of each piece, s."""
        return np.cumsum(self.durations_s).tolist()

    @cached_property
    def duration_s(self) -> float:
        """End time of the last piece, s."""
        return self.ends_s[-1]

    @cached_property
    def _pieces(self) -> list[list[list[float]]]:
        """Coefficients by piece, axis and power: plain floats, because it is sampled at 50 Hz."""
        return np.swapaxes(self.coefficients, 1, 2).tolist()

    def sample(self, t_s: float) -> FlatReference:
        """Return the reference at a time.

        Outside of 0 to `duration_s` it is the nearest end, at rest.
        """
        t = min(max(t_s, 0.0), self.duration_s)
        index = min(bisect_right(self.ends_s, t), len(self.ends_s) - 1)
        since = t - (self.ends_s[index - 1] if index else 0.0)
        x, y, z = (_derivatives(axis, since) for axis in self._pieces[index])
        yaw, yaw_rate = self.yaw.sample(max(t_s, 0.0))
        is_moving = t == t_s
        return FlatReference(
            position_enu_m=(x[0], y[0], z[0]),
            velocity_enu_mps=_only_if(is_moving, x[1], y[1], z[1]),
            acceleration_enu_mps2=_only_if(is_moving, x[2], y[2], z[2]),
            jerk_enu_mps3=_only_if(is_moving, x[3], y[3], z[3]),
            yaw_rad=yaw,
            yaw_rate_radps=yaw_rate,
        )

    def positions(self, t_s: Float[np.ndarray, " k"]) -> Float[np.ndarray, "k 3"]:
        """Return the positions at many times, ENU, m."""
        return self.derivatives(t_s, 0)

    def derivatives(self, t_s: Float[np.ndarray, " k"], order: int) -> Float[np.ndarray, "k 3"]:
        """Return a time derivative of the position at many times.

        Args:
            t_s: Times, clipped to those of the trajectory.
            order: Order of the derivative, 0 to 5; 0 is the position.
        """
        t = np.clip(t_s, 0.0, self.duration_s)
        ends = np.array(self.ends_s)
        index = np.minimum(np.searchsorted(ends, t, side="right"), len(ends) - 1)
        since = t - (ends - self.durations_s)[index]
        return derivative_at(self.coefficients, index, since, order)


def rest_of(trajectory: Trajectory, at_s: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the rest of a trajectory from a time before its end on.

    Returns:
        Coefficients and durations of the remaining pieces, and the index of the first of them.
    """
    first = bisect_right(trajectory.ends_s, at_s)
    durations = trajectory.durations_s[first:].copy()
    durations[0] = trajectory.ends_s[first] - at_s
    since = trajectory.durations_s[first] - durations[0]
    coefficients = trajectory.coefficients[first:].copy()
    # Taylor's expansion about the new beginning.
    for power in range(DEGREE + 1):
        value = derivative_at(coefficients, np.zeros(1, dtype=int), np.array([since]), power)[0]
        coefficients[0, power] = value / math.factorial(power)
    return coefficients, durations, first


def derivative_at(
    coefficients: Float[np.ndarray, "n 6 3"],
    piece: Int[np.ndarray, " k"],
    since_s: Float[np.ndarray, " k"],
    order: int,
) -> Float[np.ndarray, "k 3"]:
    """Return a time derivative of position at times since the beginning of pieces.

    Args:
        coefficients: Coefficients of all pieces.
        piece: Index of the piece for each time.
        since_s: Times since the beginning of those pieces.
        order: Order of the derivative, 0 to 5.
    """
    total = np.zeros((len(since_s), 3))
    for power in range(DEGREE, order - 1, -1):
        factor = math.perm(power, order)
        total = total * since_s[:, None] + factor * coefficients[piece, power]
    return total


def squared_jerk(
    coefficients: Float[np.ndarray, "n 6 3"], durations_s: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    """Integral of the squared jerk over each piece, m^2/s^5."""
    t = durations_s[:, None]
    r, q, p = 6 * coefficients[:, 3], 24 * coefficients[:, 4] * t, 60 * coefficients[:, 5] * t**2
    square = r * r + r * q + (q * q + 2 * r * p) / 3 + q * p / 2 + p * p / 5
    return durations_s * np.sum(square, axis=1)


def _only_if(holds: bool, x: float, y: float, z: float) -> Vector3:
    return (x, y, z) if holds else (0.0, 0.0, 0.0)


def _derivatives(c: list[float], t: float) -> tuple[float, float, float, float]:
    """Value and first three derivatives of a polynomial of degree 5."""
    return (
        c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5])))),
        c[1] + t * (2 * c[2] + t * (3 * c[3] + t * (4 * c[4] + t * 5 * c[5]))),
        2 * c[2] + t * (6 * c[3] + t * (12 * c[4] + t * 20 * c[5])),
        6 * c[3] + t * (24 * c[4] + t * 60 * c[5]),
    )


def coefficients_from_nodes(
    nodes: Float[np.ndarray, "n_plus_1 3 3"], durations_s: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 6 3"]:
    """Return the polynomials that join node states in given times.

    A node state is position, velocity and acceleration.
    """
    return join_states(nodes[:-1], nodes[1:], durations_s)


def join_states(
    begins: Float[np.ndarray, "n 3 3"],
    ends: Float[np.ndarray, "n 3 3"],
    durations_s: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n 6 3"]:
    """Return the polynomials of least squared jerk that join pairs of states in given times.

    With the difference of the end from where position p0, velocity v0 and acceleration a0 lead in
    the time T by themselves,

        dp = p1 - p0 - v0 T - a0 T^2 / 2,  dv = v1 - v0 - a0 T,  da = a1 - a0,

    each axis moves by alpha t^5 / 120 + beta t^4 / 24 + gamma t^3 / 6 + a0 t^2 / 2 + v0 t + p0:

        alpha = ( 720 dp - 360 T dv + 60 T^2 da) / T^5
        beta  = (-360 dp + 168 T dv - 24 T^2 da) / T^4
        gamma = (  60 dp -  24 T dv +  3 T^2 da) / T^3

    Args:
        begins: Position, velocity and acceleration at the beginning of each, as rows.
        ends: The same at the end.
        durations_s: Times from beginning to end.

    Returns:
        Coefficients of rising powers of the time since the beginning.

    Source: Mueller, Hehn and D'Andrea 2015, section III, for an end state that is fully defined.
    """
    t = durations_s[:, None]
    (p0, v0, a0), (p1, v1, a1) = np.moveaxis(begins, 1, 0), np.moveaxis(ends, 1, 0)
    position = p1 - p0 - v0 * t - a0 * t**2 / 2
    velocity = (v1 - v0 - a0 * t) * t
    acceleration = (a1 - a0) * t**2
    return np.stack(
        [
            p0,
            v0,
            a0 / 2,
            (10 * position - 4 * velocity + acceleration / 2) / t**3,
            (-15 * position + 7 * velocity - acceleration) / t**4,
            (6 * position - 3 * velocity + acceleration / 2) / t**5,
        ],
        axis=1,
    )
