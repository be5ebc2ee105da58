"""Inner problem of a corridor at fixed times: its optimum, and the gradient by the times.

The outer search asks for cost, gradient, nodes and slack of the same times in turn. The last
solution is kept, so that one solve serves them all.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autonomy.planning.bezier import control_points
from autonomy.planning.corridor import Corridor
from autonomy.planning.errors import LimitsError, PlanningError
from autonomy.planning.limits import MotionBounds
from autonomy.planning.program import PLANES, build

MIN_PIECE_S, MAX_PIECE_S = 0.05, 60.0
_INSIDE_M = 1e-3  # tolerance of a start on the border of its polytope


class Solver:
    """Inner problem of one corridor; it keeps its last solution.

    Args of methods: `log_times` are the natural logarithms of the pieces' durations in seconds.

    Raises `LimitsError` or `PlanningError` on creation if the start leads out of its polytope.
    """

    def __init__(
        self, start: np.ndarray, goal: np.ndarray, corridor: Corridor, bounds: MotionBounds
    ) -> None:
        n = self._n = len(corridor)
        used = int(np.max(np.count_nonzero(np.any(corridor.planes[:, :, :3] != 0, 2), axis=1)))
        # The program of the next size: CasADi builds one for each number of planes.
        self._planes = next(size for size in PLANES if size >= used)
        self._program = build(n, self._planes)
        self._bounds, self._ends = bounds, (start, goal)
        self._share = np.ones(n)
        self._solved: tuple[bytes, dict[str, Any]] = (b"", {})
        planes = np.concatenate([corridor.planes, corridor.rates_mps[:, :, None]], axis=2)
        self._fixed = np.concatenate(
            [start.ravel(), goal.ravel(), _filled(planes, self._planes).ravel(), bounds.as_array()]
        )
        low, high = np.full(n, math.log(MIN_PIECE_S)), np.full(n, math.log(MAX_PIECE_S))
        high[0] = math.log(_longest_first_piece_s(start, corridor))
        self.log_times_range = low, high

    def tighten(self, factor: np.ndarray) -> None:
        """Lower the accelerations that pieces may use, by factors of 1 or more."""
        self._share = self._share / factor
        self._solved = (b"", {})

    def cost_and_gradient(self, log_times: np.ndarray) -> tuple[float, np.ndarray]:
        """Optimum at fixed times, and its gradient with respect to their logarithms."""
        solution = self._solve(log_times)
        parameters = self._parameters(log_times)
        gradient = self._program.gradient(solution["x"], parameters, solution["lam_g"])
        return float(solution["f"]), np.array(gradient).ravel()

    def cost(self, log_times: np.ndarray) -> float:
        """Optimum at fixed times, s."""
        return float(self._solve(log_times)["f"])

    def nodes(self, log_times: np.ndarray) -> np.ndarray:
        """Node states (n + 1, 3, 3): position, velocity and acceleration of each node, ENU."""
        x = np.array(self._solve(log_times)["x"]).ravel()
        inner = x[: 9 * (self._n - 1)].reshape(self._n - 1, 3, 3)
        tau = np.exp((log_times[:-1] + log_times[1:]) / 2)
        scale = np.stack([np.ones_like(tau), tau, tau**2], axis=1)
        start, goal = self._ends
        return np.concatenate([start[None], inner / scale[:, :, None], goal[None]])

    def slack(self, log_times: np.ndarray) -> np.ndarray:
        """Share of its limits by which each piece exceeds them."""
        return np.array(self._solve(log_times)["x"]).ravel()[9 * (self._n - 1) :]

    def name_worst(self, log_times: np.ndarray) -> str:
        """Describe the limit that is exceeded most, by how much and where."""
        nodes, times, b = self.nodes(log_times), np.exp(log_times), self._bounds
        worst = (-math.inf, "")
        for k in range(self._n):
            _, velocity, acceleration, _ = control_points(
                tuple(nodes[k]), tuple(nodes[k + 1]), times[k]
            )
            v, a = np.array(velocity), np.array(acceleration) / self._share[k]
            across, up = b.acceleration_horizontal_mps2, b.acceleration_vertical_mps2
            x, y, z = nodes[k, 0]
            for name, value, limit in (
                ("horizontal speed", np.hypot(v[:, 0], v[:, 1]), b.speed_horizontal_mps),
                ("vertical speed", abs(v[:, 2]), b.speed_vertical_mps),
                ("horizontal acceleration", np.hypot(a[:, 0], a[:, 1]), across),
                ("vertical acceleration", abs(a[:, 2]), up),
            ):
                share = float(np.max(value)) / limit
                where = f"after ({x:.1f}, {y:.1f}, {z:.1f}) m"
                text = f"{name} needs {share * limit:.2f} {where}, however slow the flight; "
                worst = max(worst, (share, f"{text}valid: at most {limit:.2f}"))
        return worst[1] + ", or a start that can stop in the free space ahead of it"

    def _parameters(self, log_times: np.ndarray) -> np.ndarray:
        return np.concatenate([log_times, self._fixed, self._share])

    def _solve(self, log_times: np.ndarray) -> dict[str, Any]:
        key = log_times.tobytes()
        if self._solved[0] == key:
            return self._solved[1]
        solve = self._program.solve
        solution = solve(p=self._parameters(log_times), lbg=-math.inf, ubg=0.0)
        stats = solve.stats()
        if not stats["success"]:
            raise PlanningError(
                f"no curve of {self._n} pieces stays in the free space about the path "
                f"({stats.get('return_status')}); "
                "valid: a start that can stop in the free space ahead of it"
            )
        self._solved = (key, solution)
        return solution


def _filled(planes: np.ndarray, size: int) -> np.ndarray:
    """Return polytopes filled up to a size with planes that bound nothing."""
    filled = np.zeros((len(planes), size, 5))
    filled[:, :, 3] = 1.0
    kept = min(size, planes.shape[1])
    filled[:, :kept] = planes[:, :kept]
    return filled


def _longest_first_piece_s(start: np.ndarray, corridor: Corridor) -> float:
    """Longest first piece whose control points that the start fixes lie in its polytope.

    Raises:
        PlanningError: If the start itself is outside its polytope.
        LimitsError: If not even the shortest piece is short enough.
    """
    p, v, a = start
    normals, offsets = corridor.planes[0, :, :3], corridor.planes[0, :, 3]
    rates = corridor.rates_mps[0]
    times = np.geomspace(MIN_PIECE_S, MAX_PIECE_S, 120)[:, None]
    second, third = p + v * times / 5, p + 2 * v * times / 5 + a * times**2 / 20
    inside = np.all(second @ normals.T <= offsets + rates * times / 5, axis=1)
    inside &= np.all(third @ normals.T <= offsets + rates * 2 * times / 5, axis=1)
    n_inside = len(times) if inside.all() else int(np.argmin(inside))
    if np.any(normals @ p > offsets + _INSIDE_M):
        x, y, z = p
        raise PlanningError(
            f"start ({x:.2f}, {y:.2f}, {z:.2f}) m is outside the free space about the path; "
            "valid: a start on it, or a new search"
        )
    if n_inside == 0:
        speed = float(np.linalg.norm(v))
        raise LimitsError(
            f"start's velocity of {speed:.2f} m/s leads out of the free space within "
            f"{MIN_PIECE_S} s; valid: a start that can stop in the free space ahead of it"
        )
    return float(times[n_inside - 1, 0])
