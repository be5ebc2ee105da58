"""Rest of a plan, and its candidate paths around moving obstacles.

A moving obstacle makes free space non-convex: the vehicle can pass on several sides, and an
optimiser with planes finds only the side that its planes allow. So the side is chosen first. A
plane in each piece keeps a nearby obstacle on one side, namely the side of a guessed path: the plan
itself if that is clear, else one bent to either side, above or below.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from autonomy.planning.corridor import Corridor, refine
from autonomy.planning.moving_obstacles import MovingObstacles
from autonomy.planning.program import pieces_to_fill
from autonomy.planning.trajectory import Trajectory, rest_of

_NEAR_M = 3.0
"""Distance beyond which an obstacle needs no plane."""
_MOST_NEAR = 4
"""Number of nearest obstacles that get planes; the proof includes all."""
_STEP_S = 0.1
_PIECE_S = 0.8
"""Duration to which pieces near a moving obstacle are cut, so that they can bend around it."""
_LEAST_PIECE_S = 0.08  # a shorter first piece is merged with the next
_MAX_PIECES = 20
_EASE_M = 0.02
"""Distance beyond the demanded one, so that the proof has some slack."""
_SLOW_SHARES = (0.6, 0.3)
"""Shares of the plan's speed at which waiting for an obstacle to pass is tried."""


def remainder(
    previous: Trajectory, corridor: Corridor, at_s: float
) -> tuple[np.ndarray, np.ndarray, Corridor]:
    """Return coefficients, times and corridor of the rest of a plan as it is.

    The rest is proved already except against moving obstacles.
    """
    coefficients, durations_s, first = rest_of(previous, at_s)
    gates = corridor.gates_enu_m[first:].copy()
    gates[0] = coefficients[0, 0]
    return coefficients, durations_s, Corridor(planes=corridor.planes[first:], gates_enu_m=gates)


def no_nearer(
    moving: MovingObstacles, point_enu_m: Float[np.ndarray, " 3"], keep_m: float
) -> MovingObstacles:
    """Return predictions whose radii are cut so that the start keeps the demanded distance.

    Otherwise nothing could be proved from a start that is too near, not even the way out. The proof
    is then that the vehicle comes no nearer than it is.
    """
    distance_m = moving.distances(point_enu_m[None], np.zeros(1))[0][:, 0]
    lacking_m = np.maximum(keep_m + _EASE_M - distance_m, 0.0)
    if not np.any(lacking_m > 0.0):
        return moving
    return dataclasses.replace(moving, radius_m=moving.radius_m - lacking_m, growth_mps=0.0)


class Rest:
    """Rest of a plan: free space and times, with shorter pieces near moving obstacles.

    Args:
        previous: Plan in flight.
        corridor: Corridor of that plan.
        at_s: Time of the plan at which the rest begins.
        moving: Moving obstacles, predicted from that time on.
    """

    def __init__(
        self, previous: Trajectory, corridor: Corridor, at_s: float, moving: MovingObstacles
    ) -> None:
        _, times, left = remainder(previous, corridor, at_s)
        gates, planes = left.gates_enu_m, left.planes
        self.goal_enu_m = gates[-1].copy()
        if times[0] < _LEAST_PIECE_S and len(times) > 1 and _contains(planes[1], gates[0]):
            # The piece is too short to steer in, and the next free space already contains its
            # beginning.
            times = np.concatenate([[times[0] + times[1]], times[2:]])
            gates, planes = np.delete(gates, 1, axis=0), planes[1:]
        self._moving, self._previous, self._since = moving, previous, at_s
        self._at = np.arange(0.0, min(moving.horizon_s, times.sum()) + _STEP_S, _STEP_S)
        self._path = previous.positions(at_s + self._at)
        self._distance, _ = moving.distances(self._path, self._at)
        self.duration_s = float(times.sum())
        fine = Corridor(planes=planes, gates_enu_m=gates)
        # First the pieces near movers, then as many as a program is built for.
        for cut in (self._counts, pieces_to_fill):
            counts = cut(times)
            fine, times = refine(fine, counts), np.repeat(times / counts, counts)
        self.durations_s = times
        self._gates, self.planes = fine.gates_enu_m, fine.planes

    def problems(self, keep_m: float) -> Iterator[tuple[Corridor, np.ndarray]]:
        """Yield free space with planes against moving obstacles, and times, choice by choice.

        Args:
            keep_m: Distance to aim at from the centre of the vehicle to moving obstacles.
        """
        nearest = self._distance.min(axis=1, initial=math.inf)
        order = np.argsort(nearest, kind="stable")[:_MOST_NEAR].tolist()
        near = [i for i in order if nearest[i] < keep_m + _NEAR_M]
        if not near:
            yield Corridor(planes=self.planes, gates_enu_m=self._gates), self.durations_s
            return
        hits = [i for i in near if self._distance[i].min() < keep_m]
        # The obstacle met first is evaded; past the others the side follows from this evasion.
        hit = min(hits, key=lambda i: int(np.argmax(self._distance[i] < keep_m)), default=None)
        guesses = [(self._path, 1.0)] if hit is None else self._evasions(hit, keep_m)
        for path, speed_share in guesses:
            times = self.durations_s / speed_share
            yield self._parted(path, times, near, keep_m), times

    def _counts(self, times: np.ndarray) -> np.ndarray:
        """Return the number of parts into which each piece is cut."""
        counts = np.ones(len(times), dtype=np.int64)
        if len(self._moving) and self._distance.min() < 2 * _NEAR_M:
            since = np.cumsum(times) - times
            within = np.clip(self._moving.horizon_s - since, 0.0, times)
            counts = np.maximum(1, np.round(within / _PIECE_S)).astype(np.int64)
        while counts.sum() > max(_MAX_PIECES, len(times)):
            counts[np.argmax(counts)] -= 1
        return counts

    def _evasions(self, hit: int, keep_m: float) -> list[tuple[np.ndarray, float]]:
        """Return paths bent past an obstacle in the way, least bend first, and slow ones.

        Each path comes with its share of the plan's speed.
        """
        worst = int(np.argmin(self._distance[hit]))
        at, velocity = self._at, self._moving.velocity_enu_mps[hit]
        centers = self._moving.position_enu_m[hit] + velocity * at[:, None]
        relative = self._path - centers
        ahead, behind = min(worst + 3, len(at) - 1), max(worst - 3, 0)
        # Motion relative to the obstacle, from samples around the closest approach: sides are seen
        # along it.
        along = relative[ahead] - relative[behind]
        along = along / max(float(np.linalg.norm(along)), 1e-6)
        left = np.cross((0.0, 0.0, 1.0), along)
        norm = float(np.linalg.norm(left))
        left = left / norm if norm > 1e-3 else np.array([1.0, 0.0, 0.0])
        up = np.cross(along, left)
        half_s = max(at[worst], 1.0)
        # Bent most where the obstacle is nearest, and back on the plan before and after it.
        bump = np.cos(np.clip((at - at[worst]) / half_s, -1.0, 1.0) * math.pi / 2) ** 2
        growth = self._moving.growth_mps * at[worst]
        bent = []
        for side in (left, -left, up, -up):
            need = self._moving.reach_m(hit, side) + growth + keep_m - relative[worst] @ side
            shift = max(need, 0.0)
            # A guess is bent a tenth further than needed.
            bent.append((shift, self._path + (1.1 * shift * bump)[:, None] * side))
        bent.sort(key=lambda pair: pair[0])
        slow = [
            (self._previous.positions(self._since + share * at), share) for share in _SLOW_SHARES
        ]
        return [(path, 1.0) for _, path in bent] + slow

    def _parted(
        self, path: np.ndarray, durations_s: np.ndarray, near: list[int], keep_m: float
    ) -> Corridor:
        """Return the corridor with a plane between a path and each obstacle nearby."""
        # Room for moving planes; unused ones are (0, 0, 0, 1).
        spare = np.zeros((len(self.planes), _MOST_NEAR, 4))
        spare[:, :, 3] = 1.0
        planes = np.concatenate([self.planes, spare], axis=1)
        rates = np.zeros(planes.shape[:2])
        distance, away = self._moving.distances(path, self._at)
        since = np.cumsum(durations_s) - durations_s
        for k, (begin, time) in enumerate(zip(since, durations_s, strict=True)):
            in_piece = np.flatnonzero((self._at >= begin - _STEP_S) & (self._at <= begin + time))
            for i in near:
                if not len(in_piece) or distance[i, in_piece].min() > keep_m + _NEAR_M:
                    continue
                nearest = in_piece[np.argmin(distance[i, in_piece])]
                free = int(np.argmin(np.any(planes[k, :, :3] != 0, axis=1)))
                normal = away[i, nearest]
                # The first piece keeps no more distance than the start itself has.
                kept = min(keep_m, max(float(self._distance[i, 0]), 0.0)) if k == 0 else keep_m
                offset = self._moving.reach_m(i, normal) + kept
                offset += float(normal @ self._moving.position_enu_m[i])
                # Minus twice: the plane's inside is away from the obstacle, and its offset grows
                # towards the vehicle as the obstacle's radius does.
                planes[k, free] = [*-normal, -offset]
                rates[k, free] = -float(normal @ self._moving.velocity_enu_mps[i])
                rates[k, free] -= self._moving.growth_mps
        return Corridor(planes=planes, gates_enu_m=self._gates, moving_mps=rates)


def _contains(planes: Float[np.ndarray, "planes 4"], point: np.ndarray) -> bool:
    return bool(np.all(planes[:, :3] @ point <= planes[:, 3]))
