"""Short motions that only serve to look: a turn on the spot, and a nod.

A camera that looks ahead and down sees little of the space above. A multirotor that sets out
backwards tilts and looks up by as much, so that a short motion back or forth shows what is higher
up.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.mapping.task import Task
from autonomy.planning.errors import PlanningError
from autonomy.planning.planner import as_node
from autonomy.planning.trajectory import Trajectory, YawProfile, coefficients_from_nodes
from autonomy.planning.yaw import STEP_S
from autonomy.types import ZERO3, Vector3

NOD_RAD = math.radians(11.0)
"""Angle by which a nod sees higher for at least half a second."""
_NOD_MPS2 = 2.7
"""Greatest acceleration of a nod, which tilts the vehicle by 15 degrees."""
_NOD_LENGTHS_M = (1.5, 1.0)
"""Lengths of a nod; the shorter one is for places without room for the longer."""
_STAY_S = 0.4
"""Shortest duration of a turn, even of one by nothing."""
_TRIES = 5
"""Number of durations that a turn tries, each longer by `_STRETCH`."""
_STRETCH = 1.5
_RATE_SHARE, _SLOPE_SHARE = 0.9, 0.65
"""Shares of the limits for a turn; the rest is for the present motion of the vehicle."""


def turn(task: Task, turn_rad: float) -> Trajectory:
    """Plan to come to rest on the spot while turning.

    Args:
        task: Vehicle and map.
        turn_rad: Angle to turn by, positive to the left.

    Raises:
        PlanningError: If the vehicle cannot stop here.
    """
    limits, start = task.craft.limits, task.start
    rate_radps = _RATE_SHARE * limits.yaw_rate_radps
    slope_radps2 = _SLOPE_SHARE * limits.yaw_acceleration_radps2
    shortest_s = _STAY_S
    for tries_left in reversed(range(_TRIES)):
        way = _ramped(abs(turn_rad), rate_radps, slope_radps2, shortest_s)
        yaw = start.yaw_rad + math.copysign(1.0, turn_rad) * way + _run_out(task, len(way))
        try:
            return task.proved(_motion(task, ZERO3, yaw))
        except PlanningError:
            if not tries_left:
                raise
        # What fails is the stop from the present motion, which more time makes gentler.
        shortest_s *= _STRETCH
    raise AssertionError


def nod(task: Task, *, backwards_first: bool) -> Trajectory:
    """Plan a short straight leg that tilts the camera upwards, away from its target or towards it.

    A leg backwards looks up as it sets out, one forwards as it brakes.

    Args:
        task: Vehicle at rest that faces the target.
        backwards_first: True to try the leg backwards before the one forwards.

    Raises:
        PlanningError: If there is room for neither direction.
    """
    start = task.start
    ahead = np.array([math.cos(start.yaw_rad), math.sin(start.yaw_rad), 0.0])
    reason: PlanningError | None = None
    for length_m in _NOD_LENGTHS_M:
        # A polynomial of degree 5 from rest to rest accelerates by 10 / sqrt(3) length / time^2.
        duration_s = math.sqrt(10 / math.sqrt(3) * length_m / _NOD_MPS2)
        # A whole number of steps of the heading, so the motion may last a little longer.
        yaw = start.yaw_rad + _run_out(task, math.ceil(duration_s / STEP_S) + 1)
        for sign in (-1, 1) if backwards_first else (1, -1):
            try:
                motion = _motion(task, sign * length_m * ahead, yaw)
                return task.proved(motion, task.craft.cfg.min_margin_m)
            except PlanningError as error:
                reason = error
    assert reason is not None
    raise reason


def _motion(
    task: Task, way: Vector3 | Float[np.ndarray, " 3"], yaw_rad: Float[np.ndarray, " n"]
) -> Trajectory:
    """Return one polynomial piece from the vehicle's state to rest at a displacement from it.

    Args:
        task: Vehicle and its state.
        way: Displacement from the vehicle's position to the end, ENU, m.
        yaw_rad: Heading at steps of `STEP_S`, which also sets the duration.
    """
    end = np.add(task.start.position_enu_m, way)
    durations_s = np.array([STEP_S * (len(yaw_rad) - 1)])
    nodes = np.array([as_node(task.start), [end, ZERO3, ZERO3]])
    return Trajectory(
        durations_s=durations_s,
        coefficients=coefficients_from_nodes(nodes, durations_s),
        yaw=YawProfile(step_s=STEP_S, yaw_rad=yaw_rad),
    )


def _ramped(
    angle_rad: float, rate_radps: float, slope_radps2: float, shortest_s: float
) -> Float[np.ndarray, " n"]:
    """Return angles, `STEP_S` apart, from 0 to a final one with bounded rate and acceleration."""
    # A short turn never reaches the greatest rate: it speeds up half of the way.
    rate_radps = min(rate_radps, math.sqrt(angle_rad * slope_radps2))
    ramp_s = rate_radps / slope_radps2
    duration_s = ramp_s + (angle_rad / rate_radps if rate_radps > 0.0 else 0.0)
    times = STEP_S * np.arange(math.ceil(max(duration_s, shortest_s) / STEP_S) + 1)
    into = np.clip(times, 0.0, ramp_s)
    out = np.clip(duration_s - times, 0.0, ramp_s)
    level = np.clip(times, ramp_s, max(duration_s - ramp_s, ramp_s)) - ramp_s
    half = slope_radps2 / 2
    return half * into**2 + rate_radps * level + half * (ramp_s**2 - out**2)


def _run_out(task: Task, n: int) -> Float[np.ndarray, " n"]:
    """Return the angle that the vehicle still turns while its present yaw rate fades."""
    s = np.linspace(0.0, 1.0, n)
    rate = task.start.yaw_rate_radps * STEP_S * (n - 1)
    # The polynomial of degree 5 with this rate at the beginning, no acceleration at either end, and
    # neither angle nor rate at the end.
    return rate * (s - 6 * s**3 + 8 * s**4 - 3 * s**5)
