"""Baseline planner: motion primitives of least jerk, sampled, tested and strung together.

It is the planner of the AeroScene paper, kept to compare ours with. A primitive joins two full
states in a given time with the least integral of squared jerk: a polynomial of degree 5 in closed
form (`join_states`). From each state many are drawn that end on the path ahead, at several
distances, speeds and durations. The best one by cost and estimated cost to go is taken that the
vehicle can fly (`feasibility`) and that touches nothing. If none is left, the last choice is
undone.

Source: Mueller, Hehn and D'Andrea 2015, "A computationally efficient motion primitive for
quadrocopter trajectory generation": the primitives of section III, the tests of section IV. They
leave to others which end states to try, and plan no path around obstacles; here the primitives
follow the path that the search found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.planning.craft import Craft
from autonomy.planning.errors import CertificateError
from autonomy.planning.feasibility import allowances, first_feasible
from autonomy.planning.limits import MotionBounds
from autonomy.planning.moving_obstacles import NOTHING_MOVES
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.program import JERK_WEIGHT_M2PS5
from autonomy.planning.trajectory import join_states, squared_jerk

# Drawn ends: distances along the path, shares of the fastest speed there, factors on the least
# duration.
_REACHES_M = (1.0, 2.0, 4.0, 7.0, 11.0, 16.0, 24.0)
_SPEED_SHARES = (0.0, 0.35, 0.7, 0.95)
_STRETCHES = (1.05, 1.25, 1.5, 1.9, 2.5, 3.5)
_CRUISE_SHARE = 0.7
"""Share of the speed limit that is assumed as the average over the rest of the path."""
_RESERVE = 0.98  # of the limits: the certificate's samples may see a little more
_MAX_EXPANSIONS = 400  # of the search with undoing, so that it ends


@dataclass(frozen=True, kw_only=True, eq=False)
class _Candidate:
    """A state that was reached, and the primitives left to try from it."""

    coefficients: np.ndarray
    durations_s: np.ndarray
    ends: np.ndarray
    ends_along_m: np.ndarray
    order: np.ndarray


def fly_primitives(
    start: Float[np.ndarray, "3 3"],
    way_enu_m: Float[np.ndarray, "m 3"],
    obstacles: Obstacles,
    bounds: MotionBounds,
    craft: Craft,
) -> tuple[Float[np.ndarray, "n 6 3"], Float[np.ndarray, " n"]]:
    """Find coefficients and durations of primitives from a state to rest at the end of a path.

    Args:
        start: Position, velocity and acceleration, ENU, as rows.
        way_enu_m: Free polyline from there to the goal.
        obstacles: Static obstacles.
        bounds: Speeds and accelerations to keep; the craft's limits of thrust, tilt and body rate
            hold too.
        craft: Vehicle that flies.

    Raises:
        CertificateError: If every choice of primitives ends where none goes on.
    """
    way = _Way(way_enu_m)
    allowed = allowances(bounds, craft.limits, craft.quadrotor, _RESERVE)
    stack = [_expand(start, 0.0, way, bounds)]
    taken: list[tuple[np.ndarray, float]] = []
    for _ in range(_MAX_EXPANSIONS):
        last = stack[-1]
        at = first_feasible(
            last.order,
            last.coefficients,
            last.durations_s,
            allowed,
            obstacles.solids,
            NOTHING_MOVES.movers,
            craft.keep_m,
        )
        if at < 0:
            stack.pop()
            if not stack:
                break
            taken.pop()
            continue
        choice = int(last.order[at])
        # Neither this one nor the worse ones before it are tried again after an undo.
        last.order[: at + 1] = -1
        taken.append((last.coefficients[choice], float(last.durations_s[choice])))
        along_m = float(last.ends_along_m[choice])
        if along_m >= way.length_m:
            return np.array([c for c, _ in taken]), np.array([t for _, t in taken])
        stack.append(_expand(last.ends[choice], along_m, way, bounds))
    x, y, z = start[0]
    raise CertificateError(
        f"no string of motion primitives from ({x:.1f}, {y:.1f}, {z:.1f}) m keeps "
        f"{craft.keep_m:.2f} m from obstacles and the limits; valid: more room, or method "
        "'optimise'"
    )


class _Way:
    """Polyline, parametrised by the distance along it."""

    def __init__(self, vertices: np.ndarray) -> None:
        self._vertices = vertices
        legs = np.diff(vertices, axis=0)
        lengths = np.maximum(np.linalg.norm(legs, axis=1), 1e-9)
        self._directions = legs / lengths[:, None]
        self._ends = np.cumsum(lengths)
        self.length_m = float(self._ends[-1])

    def point(self, along_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return positions, and directions halfway between those before and after each."""
        leg = np.minimum(np.searchsorted(self._ends, along_m), len(self._ends) - 1)
        back = (self._ends[leg] - along_m)[:, None]
        before = self._directions[leg]
        after = self._directions[np.minimum(leg + 1, len(self._ends) - 1)]
        mean = np.where(back < 0.5, before + after, before)
        norm = np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-6)
        return self._vertices[leg + 1] - before * back, mean / norm

    def vertices_after(self, along_m: float) -> list[float]:
        """Return the distances along the path of the next two corners."""
        return [float(end) for end in self._ends[:-1] if end > along_m + 0.3][:2]


def _expand(node: np.ndarray, along_m: float, way: _Way, bounds: MotionBounds) -> _Candidate:
    """Draw all primitives from a state, cheapest first."""
    ahead = {along_m + reach for reach in _REACHES_M} | set(way.vertices_after(along_m))
    ahead = {min(distance, way.length_m) for distance in ahead}
    along = np.array(sorted(ahead))
    points, directions = way.point(along)
    fastest = np.minimum(
        bounds.speed_horizontal_mps
        / np.maximum(np.hypot(directions[:, 0], directions[:, 1]), 1e-6),
        bounds.speed_vertical_mps / np.maximum(np.abs(directions[:, 2]), 1e-6),
    )
    end, share, stretch = np.meshgrid(
        np.arange(len(along)), np.array(_SPEED_SHARES), np.array(_STRETCHES), indexing="ij"
    )
    end, share, stretch = end.ravel(), share.ravel(), stretch.ravel()
    # At the end of the path only rest makes sense.
    keep = (along[end] < way.length_m) | (share == 0)
    end, share, stretch = end[keep], share[keep], stretch[keep]
    ends = np.zeros((len(end), 3, 3))
    ends[:, 0] = points[end]
    ends[:, 1] = directions[end] * (fastest[end] * share)[:, None]
    least = _least_durations(node, ends, bounds)
    durations = least * stretch
    coefficients = join_states(np.broadcast_to(node, ends.shape), ends, durations)
    to_go = (way.length_m - along[end]) / (_CRUISE_SHARE * bounds.speed_horizontal_mps)
    # Speed that the state already has need not be gained again.
    to_go = to_go + np.where(to_go > 0, 1 - share, 0.0)
    cost = squared_jerk(coefficients, durations) / JERK_WEIGHT_M2PS5 + durations + to_go
    return _Candidate(
        coefficients=coefficients,
        durations_s=durations,
        ends=ends,
        ends_along_m=along[end],
        order=np.argsort(cost, kind="stable"),
    )


def _least_durations(node: np.ndarray, ends: np.ndarray, bounds: MotionBounds) -> np.ndarray:
    """Approximate shortest durations in which the bounds can be kept, s."""
    way = np.abs(ends[:, 0] - node[0])
    turn = np.abs(ends[:, 1] - node[1])
    across, up = np.hypot(way[:, 0], way[:, 1]), way[:, 2]
    change = np.hypot(turn[:, 0], turn[:, 1]) / bounds.acceleration_horizontal_mps2
    return np.maximum.reduce(
        [
            across / bounds.speed_horizontal_mps,
            up / bounds.speed_vertical_mps,
            np.sqrt(across / bounds.acceleration_horizontal_mps2),
            np.sqrt(up / bounds.acceleration_vertical_mps2),
            change,
            np.full(len(ends), 0.3),
        ]
    )
