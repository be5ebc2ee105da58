"""Trajectory through a corridor: a QP at fixed times inside, the times outside.

Piece k joins the states of node k and k + 1 (position p, velocity v, acceleration a) by a
polynomial of degree 5 in its time T_k, so it is twice differentiable everywhere by construction.
Its Bezier control points are linear in the node states at fixed times; a Bezier curve lies in the
hull of its control points, so bounds on those hold between samples:

    position points   in polytope k                                (hard)
    velocity points   within the speed limits, times 1 + s_k  (soft)
    acceleration      within the limits, times 1 + s_k        (soft)

minimise  sum_k  int |jerk|^2 dt / jerk_weight  +  T_k  +  SLACK_PRICE T_k s_k^2

Horizontal limits are octagons inside the circle. As the speed limits are soft, every T has a
solution (one that stops at every gate, for a start at rest); J(T), the optimum, has the
Lagrangian's gradient, and L-BFGS moves log T down it. Pieces that still exceed a limit are then
given more time and the QP is solved again.

Node states are made dimensionless by the times beside them, (p, v tau, a tau^2) with tau the
geometric mean: in plain SI units the QP is too badly scaled for any solver in CasADi's wheel. The
interior point solver piqp needed 2 ms for 4 pieces and 9 ms for 16, the active-set daqp .6 and 30.

Source: Bezier corridor constraints as in Gao, Wu, Lin and Shen 2018; the gradient of the times as
in Sun, Tang, Hauser and Manchester 2021 (bilevel time allocation).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from autonomy.planning.corridor import MAX_PLANES, Corridor
from autonomy.planning.errors import LimitsError, PlanningError

SLACK_PRICE = 20.0
"""Seconds that a piece of one second may cost to halve its excess over a limit, roughly."""
_JERK_WEIGHT_M2PS5 = 40.0
"""How much squared jerk, integrated, is worth one second."""
_DIRECTIONS = [(math.cos(n * math.pi / 4), math.sin(n * math.pi / 4)) for n in range(8)]
_OCTAGON = math.cos(math.pi / 8)
_MIN_PIECE_S, _MAX_PIECE_S = 0.2, 60.0
_BEST_TIMES = {"maxiter": 30, "ftol": 2e-3}
_MAX_STRETCHES = 25
# The QP aims this share below its limits and may use it up: a soft limit always gives a little.
_RESERVE = 0.03


@dataclass(frozen=True, kw_only=True, slots=True)
class MotionBounds:
    """Speeds and accelerations that a trajectory may reach."""

    speed_horizontal_mps: float
    speed_vertical_mps: float
    acceleration_horizontal_mps2: float
    acceleration_vertical_mps2: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _Program:
    """CasADi's functions for one number of pieces."""

    solve: Any
    gradient: Any
    """Of the optimum with respect to log T, from primal and dual solution."""


def optimise(
    start: Float[np.ndarray, "3 3"],
    goal: Float[np.ndarray, "3 3"],
    corridor: Corridor,
    bounds: MotionBounds,
) -> tuple[Float[np.ndarray, "n_plus_1 3 3"], Float[np.ndarray, " n"]]:
    """Node states and durations of a good trajectory within the bounds.

    Args:
        start: Position, velocity and acceleration at the beginning, rows, ENU.
        goal: The same at the end.
        corridor: One polytope for each piece; start in the first, goal in the last.
        bounds: Limits of the motion.

    Raises:
        LimitsError: If more time does not make the limits hold, or the start's velocity leads out
            of the corridor.
    """
    from scipy.optimize import minimize  # noqa: PLC0415 - loads half of scipy

    solve = _Solver(start, goal, corridor, bounds)
    best = minimize(
        solve.cost_and_gradient,
        np.log(_first_times(corridor, bounds)),
        jac=True,
        method="L-BFGS-B",
        bounds=[(math.log(_MIN_PIECE_S), math.log(_MAX_PIECE_S))] * len(corridor),
        options=_BEST_TIMES,
    )
    log_times, excess = best.x, np.zeros(1)
    for _ in range(_MAX_STRETCHES):
        nodes, excess = solve.nodes_and_excess(log_times)
        if np.all(excess <= _RESERVE):
            return nodes, np.exp(log_times)
        log_times = log_times + np.log1p(np.maximum(excess, 0.0))
    raise LimitsError(
        f"{max(excess):.0%} beyond the limits on speed and acceleration remain however slow the "
        "flight; valid: a start that can stop in the free space ahead of it"
    )


class _Solver:
    """The inner problem of one corridor."""

    def __init__(
        self, start: np.ndarray, goal: np.ndarray, corridor: Corridor, bounds: MotionBounds
    ) -> None:
        self._n = len(corridor)
        self._program = _program(self._n)
        self._ends = start, goal
        self._fixed = np.concatenate(
            [
                start.ravel(),
                goal.ravel(),
                corridor.planes.ravel(),
                np.array(
                    [
                        bounds.speed_horizontal_mps * _OCTAGON,
                        bounds.speed_vertical_mps,
                        bounds.acceleration_horizontal_mps2 * _OCTAGON,
                        bounds.acceleration_vertical_mps2,
                    ]
                )
                / (1 + _RESERVE),
            ]
        )

    def cost_and_gradient(self, log_times: np.ndarray) -> tuple[float, np.ndarray]:
        """Optimum at fixed times, and its gradient with respect to their logarithms."""
        parameters = np.concatenate([log_times, self._fixed])
        solution = self._solve(parameters)
        gradient = self._program.gradient(solution["x"], parameters, solution["lam_g"])
        return float(solution["f"]), np.array(gradient).ravel()

    def nodes_and_excess(self, log_times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Node states, and by what share of its limits each piece exceeds them."""
        solution = self._solve(np.concatenate([log_times, self._fixed]))
        x = np.array(solution["x"]).ravel()
        inner = x[: 9 * (self._n - 1)].reshape(self._n - 1, 3, 3)
        tau = np.exp((log_times[:-1] + log_times[1:]) / 2)
        scale = np.stack([np.ones_like(tau), tau, tau**2], axis=1)
        start, goal = self._ends
        nodes = np.concatenate([start[None], inner / scale[:, :, None], goal[None]])
        return nodes, x[9 * (self._n - 1) :]

    def _solve(self, parameters: np.ndarray) -> dict[str, Any]:
        solution = self._program.solve(p=parameters, lbg=-math.inf, ubg=0.0)
        stats = self._program.solve.stats()
        if not stats["success"]:
            raise PlanningError(
                f"the quadratic program of {self._n} pieces was not solved "
                f"({stats.get('return_status')}); "
                "valid: a start that can stop in the free space ahead of it"
            )
        return solution


def _first_times(corridor: Corridor, bounds: MotionBounds) -> np.ndarray:
    """Times at 60% of the speed limits, with what starting and stopping takes on top."""
    ways = np.abs(np.diff(corridor.gates_enu_m, axis=0))
    horizontal = np.hypot(ways[:, 0], ways[:, 1]) / bounds.speed_horizontal_mps
    vertical = ways[:, 2] / bounds.speed_vertical_mps
    times = np.maximum(np.maximum(horizontal, vertical) / 0.6, 0.5)
    times[[0, -1]] += 0.5 * bounds.speed_horizontal_mps / bounds.acceleration_horizontal_mps2
    return times


@functools.cache
def _program(n: int) -> _Program:
    """Build the QP for a number of pieces, once in a process."""
    import casadi as ca  # noqa: PLC0415 - loads only where something is planned

    log_t = ca.SX.sym("log_t", n)
    ends = ca.SX.sym("ends", 18)
    planes = ca.SX.sym("planes", 4 * MAX_PLANES * n)
    bounds = ca.SX.sym("bounds", 4)
    v_limits, a_limits = (bounds[0], bounds[1]), (bounds[2], bounds[3])
    inner = ca.SX.sym("inner", 9 * (n - 1))
    slack = ca.SX.sym("slack", n)

    nodes = [(ends[:3], ends[3:6], ends[6:9])]
    for k in range(n - 1):
        tau = ca.exp((log_t[k] + log_t[k + 1]) / 2)
        y = inner[9 * k : 9 * k + 9]
        nodes.append((y[:3], y[3:6] / tau, y[6:] / tau**2))
    nodes.append((ends[9:12], ends[12:15], ends[15:]))

    cost, rows = ca.SX(0), []
    for k in range(n):
        t = ca.exp(log_t[k])
        position, velocity, acceleration, jerk = _control_points(nodes[k], nodes[k + 1], t)
        cost += _integral_of_square(jerk, t) / _JERK_WEIGHT_M2PS5 + t
        cost += SLACK_PRICE * t * slack[k] ** 2
        size = 4 * MAX_PLANES
        polytope = ca.reshape(planes[size * k : size * (k + 1)], 4, MAX_PLANES)
        rows += [polytope[:3, :].T @ point - polytope[3, :].T for point in position]
        # A piece's first points of velocity and acceleration are the last ones of the piece before.
        for points, across, up in ((velocity, *v_limits), (acceleration, *a_limits)):
            for x, y, z in (ca.vertsplit(point) for point in points[1:]):
                rows += [(c * x + s * y) / across - 1 - slack[k] for c, s in _DIRECTIONS]
                rows += [sign * z / up - 1 - slack[k] for sign in (-1, 1)]
    unknowns, rows = ca.vertcat(inner, slack), ca.vertcat(*rows)
    parameters = ca.vertcat(log_t, ends, planes, bounds)
    multipliers = ca.SX.sym("multipliers", rows.shape[0])
    lagrangian = cost + ca.dot(multipliers, rows)
    return _Program(
        solve=ca.qpsol(
            "corridor",
            "piqp",
            {"x": unknowns, "p": parameters, "f": cost, "g": rows},
            {"error_on_fail": False},
        ),
        gradient=ca.Function(
            "gradient",
            [unknowns, parameters, multipliers],
            [ca.gradient(lagrangian, log_t)],
        ),
    )


def _control_points(a: tuple[Any, Any, Any], b: tuple[Any, Any, Any], t: Any) -> list[list[Any]]:
    """Bezier control points of position (6), velocity (5), acceleration (4) and jerk (3)."""
    p0, v0, a0 = a
    p1, v1, a1 = b
    points = [
        p0,
        p0 + v0 * t / 5,
        p0 + 2 * v0 * t / 5 + a0 * t**2 / 20,
        p1 - 2 * v1 * t / 5 + a1 * t**2 / 20,
        p1 - v1 * t / 5,
        p1,
    ]
    derivatives = [points]
    for degree in (5, 4, 3):
        last = derivatives[-1]
        derivatives.append([degree / t * (last[i + 1] - last[i]) for i in range(degree)])
    return derivatives


def _integral_of_square(points: list[Any], t: Any) -> Any:
    """Integral over a piece of the squared norm of a Bezier curve of degree 2."""
    degree = len(points) - 1
    total = 0
    for i, a in enumerate(points):
        for j, b in enumerate(points):
            share = math.comb(degree, i) * math.comb(degree, j) / math.comb(2 * degree, i + j)
            total += share * (a.T @ b)
    return t * total / (2 * degree + 1)
