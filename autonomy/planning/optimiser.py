"""Trajectory through a corridor: an inner QP at fixed times, an outer search of the times.

Optimising states and times together is not convex and slow. At fixed times the problem is a
quadratic program, which is solved reliably in milliseconds, so only the times need a search. Piece
k joins the states of node k and k + 1 (position p, velocity v, acceleration a) by a polynomial of
degree 5 in its time T_k, so it is twice differentiable everywhere by construction. Its Bezier
control points are linear in the node states at fixed times. A Bezier curve lies in the hull of its
control points, so bounds on those hold between samples.

Every T has a solution, as limits have slack at a price (see `program`). J(T), the optimum, has the
Lagrangian's gradient, and L-BFGS moves log T down it. If the flatness model then demands more than
the vehicle has (thrust, tilt, body rates, with rotor drag), the piece's accelerations are
tightened, and if a limit is still exceeded, the piece gets more time.

Source: Bezier corridor constraints as in Gao, Wu, Lin and Shen 2018; the gradient of the times as
in Sun, Tang, Hauser and Manchester 2021 (bilevel time allocation).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.planning.corridor import Corridor
from autonomy.planning.errors import LimitsError, PlanningError
from autonomy.planning.limits import MotionBounds
from autonomy.planning.solver import Solver

_STEP = 0.25
"""Approximate change of the logarithms of the times by the search's first step."""
_FIRST_END_S = 1.5  # longest first guess for the first and the last piece
# Options of SciPy's L-BFGS-B for times that are a rough guess.
COLD = {"maxiter": 40, "ftol": 5e-4}
WARM = {"maxiter": 2, "maxfun": 3, "ftol": 2e-3, "gtol": 0.2 * _STEP}
"""Settings for times that were good a moment ago. The search ends when a change of a time by one
per cent gains no more than two thousandths of a second."""
EVADING = {"maxiter": 8, "maxfun": 8, "ftol": 2e-3}
"""Settings for times that were good without the obstacle."""
_MAX_TIGHTENINGS = 5
_MAX_STRETCHES = 25
_STRICT_STRETCHES = 5
"""Number of stretches after which twice the tolerance is good enough."""
_TOLERANCE = 1e-3
"""Share by which a piece may exceed a limit."""

Excess = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Function from nodes and durations to two shares of each piece: how far it exceeds force, and how
far body rate."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Optimal trajectory through a corridor."""

    nodes: Float[np.ndarray, "n_plus_1 3 3"]
    """Position, velocity and acceleration, rows, at each end of a piece, ENU."""
    durations_s: Float[np.ndarray, " n"]
    cost: float
    """Time plus weighted squared jerk, s."""


def optimise(
    start: Float[np.ndarray, "3 3"],
    goal: Float[np.ndarray, "3 3"],
    corridor: Corridor,
    bounds: MotionBounds,
    *,
    excess: Excess | None = None,
    first_s: Float[np.ndarray, " n"] | None = None,
    search: Mapping[str, float] = COLD,
) -> Solution:
    """Optimise a trajectory within the bounds.

    Args:
        start: Position, velocity and acceleration at the beginning, rows, ENU.
        goal: The same at the end.
        corridor: One polytope for each piece; start in the first, goal in the last.
        bounds: Limits of the motion.
        excess: Demands beyond the vehicle's abilities that the bounds do not cover.
        first_s: Durations to begin from, good for nearly the same problem.
        search: Settings of the search for the best times: `COLD`, `WARM` or `EVADING`.

    Raises:
        LimitsError: If more time does not make a limit hold; names the limit.
        PlanningError: If no curve from the start stays in the corridor.
    """
    solve = Solver(start, goal, corridor, bounds)
    log_times = np.log(first_times(corridor, bounds) if first_s is None else first_s)
    log_times = np.clip(log_times, *solve.log_times_range)
    for _ in range(_MAX_TIGHTENINGS):
        log_times = _best_times(solve, log_times, search)
        if excess is None:
            break
        force, _ = excess(solve.nodes(log_times), np.exp(log_times))
        if np.all(force <= _TOLERANCE):
            break
        # By more than the excess, because only a few rounds are made.
        solve.tighten(1 + 1.3 * force)
    return _within_limits(solve, log_times, excess)


def first_times(corridor: Corridor, bounds: MotionBounds) -> Float[np.ndarray, " n"]:
    """Times at 60% of the speed limits, and short ones at the ends.

    The cost of the times has several valleys. The deep ones have short pieces for starting and
    stopping, at the ends of long ones for cruising.
    """
    ways = np.abs(np.diff(corridor.gates_enu_m, axis=0))
    horizontal = np.hypot(ways[:, 0], ways[:, 1]) / bounds.speed_horizontal_mps
    vertical = ways[:, 2] / bounds.speed_vertical_mps
    times = np.maximum(np.maximum(horizontal, vertical) / 0.6, 0.5)
    times[[0, -1]] = np.minimum(times[[0, -1]], _FIRST_END_S)
    return times


def _best_times(solve: Solver, log_times: np.ndarray, options: Mapping[str, float]) -> np.ndarray:
    from scipy.optimize import minimize

    # The search runs over log T / _STEP, so that its first step of length 1 is a sensible one.
    low, high = solve.log_times_range
    worst, gradient = solve.cost_and_gradient(log_times)

    def cost_and_gradient(steps: np.ndarray) -> tuple[float, np.ndarray]:
        # With moving planes some times have no solution; a high cost makes the line search leave
        # them.
        try:
            cost, slope = solve.cost_and_gradient(_STEP * steps)
        except PlanningError:
            return 10 * worst, -_STEP * gradient
        return cost, _STEP * slope

    steps = minimize(
        cost_and_gradient,
        log_times / _STEP,
        jac=True,
        method="L-BFGS-B",
        bounds=list(zip(low / _STEP, high / _STEP, strict=True)),
        options=dict(options),
    ).x
    return np.clip(_STEP * steps, low, high)


def _within_limits(solve: Solver, log_times: np.ndarray, excess: Excess | None) -> Solution:
    """Stretch the pieces that exceed a limit until none does.

    If more time makes the first piece worse, it gets less: its velocity at the start leads on for
    longer.
    """
    first, before = 1.0, math.inf
    for n in range(_MAX_STRETCHES):
        nodes, slack, cost = solve.nodes(log_times), solve.slack(log_times), solve.cost(log_times)
        granted = _TOLERANCE if n < _STRICT_STRETCHES else 2 * _TOLERANCE
        beyond = np.where(slack > 0.5 * granted, slack + 0.5 * granted, 0.0)
        if excess is not None:
            force, rate = excess(nodes, np.exp(log_times))
            beyond = np.maximum(beyond, np.maximum(force, rate) - granted)
        if np.all(beyond <= 0):
            return Solution(nodes=nodes, durations_s=np.exp(log_times), cost=cost)
        first = -first if beyond[0] > max(before, 0.0) else first
        before = beyond[0]
        stretch = np.log1p(np.maximum(beyond, 0.0))
        stretch[0] *= first
        log_times = np.clip(log_times + stretch, *solve.log_times_range)
    if excess is None or np.max(solve.slack(log_times)) > 2 * _TOLERANCE:
        raise LimitsError(solve.name_worst(log_times))
    force, rate = excess(solve.nodes(log_times), np.exp(log_times))
    name = "body rate" if np.max(rate) > np.max(force) else "thrust or tilt, with rotor drag,"
    raise LimitsError(
        f"{name} stays {max(np.max(force), np.max(rate)):.0%} beyond its limit however slow the "
        "flight; valid: a higher limit, or a start nearer to hover"
    )
