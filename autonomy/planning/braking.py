"""Braking: coming to rest as soon as possible, ahead, or aside if a mover approaches.

An optimiser would have to choose where to stop; drawing many simple stops and testing them is
quicker and always gives an answer in time. Motions of one piece from the present state to rest are
drawn: straight stops, stops on the plan, and stops beside, above and below them. The first that can
be proved is taken, ordered by time and distance aside. The proof extends past its end, where the
vehicle stands, to the horizon of the movers' prediction.

`brake` gives the goal up for now: its trajectory ends at rest, somewhere near. `replan`
(`autonomy.planning.replanning`, with `evasion` for its candidate paths) keeps the goal instead and
bends the rest of the plan around movers. A pilot replans first, and brakes if that fails.

Source: motions of least jerk and their test as in Mueller, Hehn and D'Andrea 2015; a stop that is
always at hand as in Tordesillas et al. 2019 (FASTER).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from autonomy.planning.craft import Craft
from autonomy.planning.errors import CertificateError, EvasionError, PlanningError
from autonomy.planning.evasion import no_nearer
from autonomy.planning.feasibility import allowances, first_feasible
from autonomy.planning.moving_obstacles import NOTHING_MOVES, MovingObstacles
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.planner import as_node, bounds_for, with_yaw
from autonomy.planning.trajectory import Trajectory, join_states
from autonomy.types import FlatReference

# Durations of the stops, and distances of the places aside from the straight stop.
_TIMES_S = np.geomspace(0.4, 6.0, 20)
_ASIDE_M = (0.6, 1.2, 2.0, 3.2)
_PRICE_ASIDE_SPM = 0.5
"""Price in seconds of each metre away from the straight stop."""
_RESERVE = 1.004
"""Share of a limit that a start may have used: between the optimiser's tolerance, which it may have
used up, and the certificate's."""
_MOST_PROOFS = 12  # a proof is dear; the quick test before it leaves few candidates


def brake(
    previous: Trajectory,
    at_time_s: float,
    obstacles: Obstacles,
    craft: Craft,
    *,
    moving: MovingObstacles = NOTHING_MOVES,
    start: FlatReference | None = None,
) -> Trajectory:
    """Plan a certified trajectory to rest as soon as possible, away from moving obstacles.

    The arguments are those of `replan`, but `previous` may be any trajectory. `at_time_s` may be
    later than its end, where the vehicle stands. After the stop the vehicle also stands clear of
    moving obstacles until the prediction's horizon. Nothing is proved about the time after it.

    Returns:
        A trajectory without a corridor: `plan_trajectory` goes on from its end.

    Raises:
        LimitsError: If the start is beyond the limits.
        EvasionError: If `moving` holds obstacles and no stop could be proved. The movers or the
            static scene may be the cause. To find out, call `brake` again without `moving`: a stop
            that it then returns is clear of the static scene alone.
        CertificateError: If `moving` is empty and no stop could be proved.
    """
    begin = previous.sample(at_time_s) if start is None else start
    moving = no_nearer(moving, np.array(begin.position_enu_m), craft.keep_m)
    reason: PlanningError | None = None
    for stop in _feasible_stops(begin, previous, at_time_s, obstacles, craft, moving):
        try:
            proved = craft.prove(_then_stand(stop, moving), obstacles, moving=moving)
        except PlanningError as error:
            reason = error
        else:
            return dataclasses.replace(stop, min_clearance_m=proved.min_clearance_m)
    x, y, z = begin.position_enu_m
    raise (EvasionError if len(moving) else CertificateError)(
        f"no stop from ({x:.1f}, {y:.1f}, {z:.1f}) m at "
        f"{math.hypot(*begin.velocity_enu_mps):.2f} m/s could be proved"
        f"{'' if reason is None else f' ({reason})'}; valid: more room ahead, or a slower flight"
    ) from reason


def _feasible_stops(
    begin: FlatReference,
    plan: Trajectory,
    at_s: float,
    obstacles: Obstacles,
    craft: Craft,
    moving: MovingObstacles,
) -> Iterator[Trajectory]:
    """Yield a few stops that pass a quick test of limits and clearance, best first."""
    limits, quadrotor, keep_m = craft.limits, craft.quadrotor, craft.keep_m
    allowed = allowances(bounds_for(begin, limits, quadrotor), limits, quadrotor, _RESERVE)
    ends, durations_s, order = _stops(begin, plan, at_s)
    coefficients = join_states(np.broadcast_to(as_node(begin), ends.shape), ends, durations_s)
    order = order[_is_clear_at_rest(ends[order, 0], durations_s[order], moving, keep_m)]
    for _ in range(_MOST_PROOFS):
        at = first_feasible(
            order, coefficients, durations_s, allowed, obstacles.solids, moving.movers, keep_m
        )
        if at < 0:
            return
        chosen = order[at : at + 1]
        order = order[at + 1 :]
        yield with_yaw(
            coefficients[chosen], durations_s[chosen], begin.yaw_rad, limits, begin.yaw_rate_radps
        )


def _stops(
    begin: FlatReference, plan: Trajectory, at_s: float
) -> tuple[Float[np.ndarray, "m 3 3"], Float[np.ndarray, " m"], np.ndarray]:
    """Return states at rest, times to reach them, and their order, best first."""
    p, v, a = as_node(begin)
    t = _TIMES_S[:, None]
    # The motion of least jerk with a free end stops here.
    ahead = p + v * t / 2 + a * t**2 / 12
    aside = np.concatenate([np.zeros((1, 3)), *(reach * _directions(v) for reach in _ASIDE_M)])
    # Quarter, half and three quarters of the distance that the plan covers in the stop's time.
    along = plan.positions(at_s + np.multiply.outer(_TIMES_S, (0.25, 0.5, 0.75)).ravel())
    on_plan = along.reshape(len(t), 3, 3)
    places = np.concatenate([ahead[:, None] + aside, on_plan], axis=1)
    way = np.linalg.norm(places - ahead[:, None], axis=2)
    ends = np.zeros((way.size, 3, 3))
    ends[:, 0] = places.reshape(-1, 3)
    durations = np.repeat(_TIMES_S, way.shape[1])
    return ends, durations, np.argsort(durations + _PRICE_ASIDE_SPM * way.ravel(), kind="stable")


def _directions(velocity: np.ndarray) -> Float[np.ndarray, "26 3"]:
    """Return directions to all sides of the horizontal motion: level, slanted, up and down."""
    heading = math.atan2(velocity[1], velocity[0])
    angle = heading + np.arange(8) * math.pi / 4
    level = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(8)])
    up = np.array([0.0, 0.0, 1.0])
    slanted = math.sqrt(0.5)
    return np.concatenate(
        [level, slanted * (level + up), slanted * (level - up), up[None], -up[None]]
    )


def _is_clear_at_rest(
    places: np.ndarray, since_s: np.ndarray, moving: MovingObstacles, keep_m: float
) -> np.ndarray:
    """Return whether moving obstacles stay away from positions after given times, by samples.

    Only a filter before the proof, so samples of 0.1 s suffice.
    """
    if not len(moving):
        return np.ones(len(places), dtype=bool)
    is_clear = np.ones(len(places), dtype=bool)
    for time_s in np.arange(0.0, moving.horizon_s + 0.1, 0.1).tolist():
        distance = moving.distances(places, np.full(len(places), time_s))[0].min(axis=0)
        is_clear &= (distance > keep_m) | (since_s > time_s)
    return is_clear


def _then_stand(stop: Trajectory, moving: MovingObstacles) -> Trajectory:
    """Return the trajectory followed by rest at its end until the prediction's horizon."""
    rest_s = moving.horizon_s - stop.duration_s if len(moving) else 0.0
    if rest_s <= 0:
        return stop
    stand = np.zeros((1, *stop.coefficients.shape[1:]))
    stand[0, 0] = stop.positions(np.array([stop.duration_s]))[0]
    return dataclasses.replace(
        stop,
        durations_s=np.append(stop.durations_s, rest_s),
        coefficients=np.concatenate([stop.coefficients, stand]),
    )
