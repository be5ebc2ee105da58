"""Movers that meet a vehicle in flight, from ahead, from the side, from above and from below.

A mover knows nothing of the vehicle. It is drawn so that it would be at the vehicle's place at the
drawn time if the vehicle flew as in the rehearsal, and that its way is free of the scene.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import vector3
from flightsim.environment.motion import new_movers, place_mover
from flightsim.environment.movers import MOVER_KINDS, MovingObstacle
from flightsim.environment.paths import smooth_path

Direction = Literal["ahead", "side", "above", "below"]
DIRECTIONS: tuple[Direction, ...] = get_args(Direction)
SPEED_MPS = (1.0, 3.0)

_LEVEL_DEG = {"ahead": (150.0, 210.0), "side": (60.0, 120.0)}
"""Angles between both motions seen from above; 180 is head on."""
_STEEP_DEG = {
    "ahead": (-10.0, 10.0),
    "side": (-10.0, 10.0),
    "above": (25.0, 60.0),
    "below": (-60.0, -25.0),
}
"""Angles above the horizon at which the mover is seen as it comes."""
# The way of a mover: free before the meeting, straight on a little after it, then level, for so
# long that it does not come back at once.
_COMES_FOR_S = 5.0
"""Time before the meeting in which the mover's way is free."""
_PASSES_M = 1.0
"""Length of its way straight on after the meeting."""
_LEAVES_FOR_S = 5.0
"""Time for which it then flies level, so that it does not come back at once."""
_TURNS_M = 0.5
"""Length of its way beyond both ends, on which it turns round."""
_FREE_M = 0.55
"""Room about its centre on that way; the drone is 0.6 m wide."""
_APART_S, _APART_M = 2.5, 2.0
"""Until so long before the meeting, the mover is at least so far from where the vehicle is."""
_TRIES = 300


@dataclass(frozen=True, kw_only=True, eq=False)
class FlownWay:
    """Positions of a vehicle by simulated time from the start of its run."""

    time_s: Float[np.ndarray, " n"]
    position_enu_m: Float[np.ndarray, "n 3"]

    def at(self, time_s: Float[np.ndarray, " k"]) -> Float[np.ndarray, "k 3"]:
        """Positions at given times, between samples by straight lines."""
        columns = (np.interp(time_s, self.time_s, x) for x in self.position_enu_m.T)
        return np.column_stack(list(columns))


def draw_meeting(
    way: FlownWay,
    between_s: tuple[float, float],
    direction: Direction,
    is_free: Callable[[Float[np.ndarray, "n 3"], float], Bool[np.ndarray, " n"]],
    rng: np.random.Generator,
) -> MovingObstacle | None:
    """Draw a drone that will be where the vehicle would be at some moment of its way.

    It comes in a straight line, leaves level, goes to and fro and heeds nobody.

    Args:
        way: The way that the vehicle flies if it meets nobody.
        between_s: The moment lies between these times.
        direction: Where it comes from; ahead and side are seen from the vehicle's motion.
        is_free: Whether the scene leaves room for a sphere of a given radius in m at places.
        rng: Source of the moment, the speed and the angles.

    Returns:
        The mover; None if several hundred draws have no free way.
    """
    for _ in range(_TRIES):
        meet_s = rng.uniform(*between_s)
        speed_mps = rng.uniform(*SPEED_MPS)
        # The course is the vehicle's motion over 0.3 s.
        here, soon = way.at(np.array([meet_s, meet_s + 0.3]))
        course = math.atan2(soon[1] - here[1], soon[0] - here[0])
        if math.dist(here, soon) < 0.05:
            course = rng.uniform(-math.pi, math.pi)  # it hovers
        turn_deg = rng.uniform(*_LEVEL_DEG.get(direction, (0.0, 180.0))) * rng.choice((-1, 1))
        heading = course + math.radians(turn_deg)
        # A mover that is seen above comes down.
        down = math.radians(rng.uniform(*_STEEP_DEG[direction]))
        level = math.cos(down)
        along = np.array([level * math.cos(heading), level * math.sin(heading), -math.sin(down)])
        corners = [here - (speed_mps * _COMES_FOR_S + _TURNS_M) * along, here + _PASSES_M * along]
        ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
        corners.append(corners[1] + (speed_mps * _LEAVES_FOR_S + _TURNS_M) * ahead)
        if not is_free(_along(corners), _FREE_M).all():
            continue
        mover = _meeting(here, corners, speed_mps, meet_s)
        if _stays_apart(mover, way, meet_s):
            return mover
    return None


def _along(corners: Sequence[Float[np.ndarray, 3]]) -> Float[np.ndarray, "n 3"]:
    """Places along a polyline, 0.2 m apart or less, so that no solid is stepped over."""
    legs = [
        np.linspace(a, b, math.ceil(math.dist(a, b) / 0.2) + 1)
        for a, b in itertools.pairwise(corners)
    ]
    return np.concatenate(legs)


def _meeting(
    here: Float[np.ndarray, 3],
    corners: Sequence[Float[np.ndarray, 3]],
    speed_mps: float,
    meet_s: float,
) -> MovingObstacle:
    """Make a drone that follows corners and is on its first leg at a place at a time."""
    kind = MOVER_KINDS["drone"]
    # A path is that of the mover's underside.
    lift = np.array([0.0, 0.0, kind.size_m[2] / 2])
    path = tuple(vector3(corner - lift) for corner in corners)
    length_m = smooth_path(path, is_loop=False).length_m
    # It speeds up evenly, so that it lags behind even speed by half of the time that this takes.
    # No faster than it can become and stop again on the way.
    speed_mps = min(speed_mps, math.sqrt(length_m * kind.acceleration_mps2))
    lag_s = speed_mps / kind.acceleration_mps2
    # To and fro is one period; the phase is set so that it passes at the wanted time.
    out_s = length_m / speed_mps + lag_s + kind.pause_s
    passes_s = math.dist(corners[0], here) / speed_mps + lag_s / 2
    return MovingObstacle(
        kind="drone",
        path_enu_m=path,
        speed_mps=speed_mps,
        phase=((passes_s - meet_s) / (2.0 * out_s)) % 1.0,
    )


def centres(mover: MovingObstacle, time_s: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
    """Centres of a mover at times of a run, n x 3."""
    (record,), points = new_movers([mover])
    lift = np.array([0.0, 0.0, MOVER_KINDS[mover.kind].size_m[2] / 2])
    found = np.empty((len(time_s), 3))
    for row, at_s in zip(found, time_s, strict=True):
        place_mover(record, points, at_s, 1.0)
        row[:] = record["position_enu_m"] + lift
    return found


def _stays_apart(mover: MovingObstacle, way: FlownWay, meet_s: float) -> bool:
    """True if a mover that goes to and fro meets the vehicle at the given time and not before."""
    before_s = np.arange(0.0, max(meet_s - _APART_S, 0.2), 0.1)
    off_m = np.linalg.norm(centres(mover, before_s) - way.at(before_s), axis=1)
    return bool(off_m.min() > _APART_M)
