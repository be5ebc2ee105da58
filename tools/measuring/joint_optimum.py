"""Reference for the optimiser: states and times of a corridor problem solved jointly by ipopt.

Our optimiser splits the problem into inner states for given times and the times themselves, and
keeps limits by certificates. Ipopt, which takes some seconds for a problem, solves all of it at
once, so that the difference in cost is the price of the split.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

from autonomy.model.flatness import effort
from autonomy.model.quadrotor import QuadrotorParams
from autonomy.planning.bezier import control_points
from autonomy.planning.corridor import Corridor
from autonomy.planning.limits import FlightLimits
from autonomy.planning.optimiser import Solution, first_times
from autonomy.planning.program import symbols

_N_SAMPLES = 4
"""Samples per piece at which flatness limits are kept."""
_IPOPT = {
    "ipopt.print_level": 0,
    "print_time": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-4,
    "ipopt.dual_inf_tol": 1e-2,
    "ipopt.compl_inf_tol": 1e-4,
    "ipopt.constr_viol_tol": 1e-5,
    "ipopt.max_iter": 300,
    "error_on_fail": False,
}


def joint_optimum(
    corridor: Corridor,
    start: np.ndarray,
    goal: np.ndarray,
    limits: FlightLimits,
    quadrotor: QuadrotorParams,
    near: Solution | None = None,
) -> float | None:
    """Least cost in s with every limit kept exactly; None if ipopt fails.

    Args:
        corridor: Corridor to fly in.
        start: Rows of position, velocity and acceleration at the start.
        goal: The same at the goal.
        limits: Limits of the motion; by flatness with drag at samples.
        quadrotor: Parameters of the vehicle.
        near: Initial guess; None for straight ways between the gates.
    """
    n, planes = corridor.planes.shape[:2]
    bounds = limits.motion_bounds(quadrotor)
    times = first_times(corridor, bounds) if near is None else near.durations_s
    nodes = np.zeros((n + 1, 3, 3))
    nodes[:, 0] = corridor.gates_enu_m
    # From rest to rest through the middles of the gates, or from the given solution.
    if near is not None:
        nodes = near.nodes
    # Derivatives at a node are scaled by the times about it, which makes all unknowns of one size.
    tau = np.sqrt(times[:-1] * times[1:])[:, None, None]
    inner = nodes[1:-1] * tau ** np.arange(3)[None, :, None]
    table = np.concatenate([corridor.planes, corridor.rates_mps[:, :, None]], axis=2)
    fixed = [start.ravel(), goal.ravel(), table.ravel(), bounds.as_array(), np.ones(n)]
    # Bounds: all times and states are free; the last n unknowns would relax limits, and stay 0.
    free = math.inf * np.ones(10 * n - 9)
    solve = _solver(n, planes, limits, quadrotor)
    solution = solve(
        x0=np.concatenate([np.log(times), inner.ravel(), np.zeros(n)]),
        p=np.concatenate(fixed),
        lbx=np.concatenate([-free, np.zeros(n)]),
        ubx=np.concatenate([free, np.zeros(n)]),
        lbg=-math.inf,
        ubg=0.0,
    )
    return float(solution["f"]) if solve.stats()["success"] else None


@functools.cache
def _solver(n: int, planes: int, limits: FlightLimits, quadrotor: QuadrotorParams) -> Any:
    import casadi as ca

    s = symbols(n, planes)
    rows = [s.rows]
    tangent = math.tan(limits.tilt_rad)
    for k in range(n):
        _, *points = control_points(s.nodes[k], s.nodes[k + 1], ca.exp(s.log_t[k]))
        for i in range(1, _N_SAMPLES + 1):
            v, a, j = (_at(curve, i / _N_SAMPLES) for curve in points)
            asked = effort(ca.vertsplit(v), ca.vertsplit(a), ca.vertsplit(j), quadrotor)
            # Tilt as a polynomial: cos^2 (1 + tan^2) is 1 at the limit, and more below it.
            upright = asked.cos_tilt
            rows.append(asked.specific_thrust_mps2 / limits.max_specific_thrust_mps2(quadrotor) - 1)
            rows.append(1 - upright**2 * (1 + tangent**2))
            rows.append(asked.tilt_rate_radps / limits.body_rate_radps - 1)
    return ca.nlpsol(
        "joint",
        "ipopt",
        {"x": ca.vertcat(s.log_t, s.unknowns), "p": s.fixed, "f": s.cost, "g": ca.vertcat(*rows)},
        _IPOPT,
    )


def _at(points: list[Any], share: float) -> Any:
    """Value of a Bezier curve at a share of its length, by the Bernstein polynomials."""
    n = len(points) - 1
    return sum(
        math.comb(n, i) * share**i * (1 - share) ** (n - i) * point
        for i, point in enumerate(points)
    )
