"""Swarm: each of several vehicles comes to a target of its own, and none touches another."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Vector3
from scenarios.environments.episodes.place import Place
from scenarios.environments.tasks.situation import Situation
from scenarios.environments.tasks.task import (
    MOST_DRAWS,
    Start,
    Task,
    draw_attitude,
    draw_point,
    no_room,
)
from scenarios.trials.figures import Goal
from scenarios.trials.verdict import Ending, Verdict

_LOW_M, _HIGH_M = 1.5, 4.0
"""Heights over the scene's start between which starts and targets lie."""
_LEAST_HALF_M = 2.0  # of the box of starts and targets, which grows with the swarm
_APART_M = 1.5
"""Least distance between two starts, and between two targets."""
_FARTHEST_M = 30.0
_HELD_S = 1.0
_CLOSENESS_M = 0.5
_NEAR_MATE_M = 1.0  # distance of another vehicle's centre within which crowding costs
_CRASH = -5.0


class Swarm(Task):
    """Success of a vehicle is to be within 0.25 m of its target for the last second."""

    name = "swarm"
    episode_s = 20.0
    near_m = 0.25

    def __init__(self, n_vehicles: int) -> None:
        self._n_vehicles = n_vehicles

    def draw(self, place: Place, rng: np.random.Generator) -> list[Start]:
        """Draw starts and targets of all vehicles in one box over the scene's start, each apart.

        Raises:
            EnvironmentInputError: If a hundred draws of one find no free air for it.
        """
        n = self._n_vehicles
        starts = _draw_apart(place, rng, n, "the starts of a swarm")
        targets = _draw_apart(place, rng, n, "the targets of a swarm")
        return [
            Start(
                position_enu_m=start,
                quat_wxyz=draw_attitude(rng),
                target_enu_m=target,
                goal=Goal(stays_up=True),
            )
            for start, target in zip(starts, targets, strict=True)
        ]

    def reward(
        self, now: Situation, before_m: Float[np.ndarray, " n"], step_s: float
    ) -> Float[np.ndarray, " n"]:
        """1 for each metre nearer, and 1 for a second at the target, less the following costs.

        A second costs 0.05 for each rad/s, and up to 1 within a metre of another vehicle's centre.
        """
        closeness = np.exp(-now.distance_m / _CLOSENESS_M)
        crowding = np.maximum(1.0 - nearest_mate_m(now.position_enu_m) / _NEAR_MATE_M, 0.0)
        each_s = closeness - 0.05 * now.turning_radps - crowding
        return before_m - now.distance_m + step_s * each_s

    def end_reward(self, *, is_success: bool, is_time_up: bool) -> float:
        """-5 for an end before the time."""
        return 0.0 if is_success or is_time_up else _CRASH

    def is_over(self, now: Situation) -> Bool[np.ndarray, " n"]:
        """On contact, and 30 metres away."""
        return (now.touch_s > 0.0) | (now.distance_m > _FARTHEST_M)

    def ending(self, now: Situation, index: int, seconds: float, *, is_time_up: bool) -> Ending:
        """State whether the target was held."""
        away_m = now.distance_m[index]
        if not is_time_up:
            word = Verdict(False, f"was {away_m:.1f} m from the target after {seconds:.1f} s")
        elif now.near_s[index] >= _HELD_S:
            word = Verdict(True, f"held the target, {away_m:.2f} m from it in the end")
        else:
            word = Verdict(False, f"did not hold the target, {away_m:.2f} m from it in the end")
        return Ending(word=word, is_done=True)


def nearest_mate_m(position_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
    """The distance of each vehicle's centre from the nearest other one; infinite if alone."""
    apart_m = np.linalg.norm(position_enu_m[:, None] - position_enu_m, axis=2)
    # A vehicle is no neighbour of itself.
    np.fill_diagonal(apart_m, math.inf)
    return apart_m.min(axis=1)


def _draw_apart(place: Place, rng: np.random.Generator, n: int, what: str) -> list[Vector3]:
    """Free points apart from each other, in a box over the scene's start that fits n of them."""
    # The area grows with n, so the density of vehicles stays the same.
    half_m = max(_LEAST_HALF_M, _APART_M * math.sqrt(n))
    low, high = (-half_m, -half_m, _LOW_M), (half_m, half_m, _HIGH_M)
    drawn: list[Vector3] = []
    for _ in range(n):
        drawn.append(_draw_one(place, rng, (low, high), drawn, what))
    return drawn


def _draw_one(
    place: Place,
    rng: np.random.Generator,
    box_m: tuple[Vector3, Vector3],
    taken: Sequence[Vector3],
    what: str,
) -> Vector3:
    for _ in range(MOST_DRAWS):
        point = draw_point(rng, place.start_enu_m, *box_m)
        is_apart = all(math.dist(point, other) >= _APART_M for other in taken)
        if is_apart and place.is_free(point):
            return point
    raise no_room(place, what)
