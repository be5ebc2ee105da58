"""Navigation: fly from the scene's start to a point over one of its areas, past all obstacles."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Vector3
from scenarios.environments.cfg import EnvironmentInputError
from scenarios.environments.episodes.draws import uniform
from scenarios.environments.episodes.place import Place
from scenarios.environments.tasks.situation import Situation
from scenarios.environments.tasks.task import (
    MOST_DRAWS,
    Start,
    Task,
    draw_attitude,
    draw_free,
)
from scenarios.trials.figures import Goal
from scenarios.trials.verdict import Ending, Verdict

_LEAST_WAY_M = 3.0
_REACHED, _CRASH = 10.0, -5.0


class Navigation(Task):
    """Success is to come within a metre of the target without touching anything."""

    name = "navigation"
    episode_s = 60.0
    near_m = 1.0

    def draw(self, place: Place, rng: np.random.Generator) -> list[Start]:
        """Draw a start over the scene's own, and a target over an area three metres or more off."""
        position = draw_free(
            place, rng, place.start_enu_m, (-0.5, -0.5, 1.5), (0.5, 0.5, 2.5), "a start"
        )
        start = Start(
            position_enu_m=position,
            quat_wxyz=draw_attitude(rng),
            target_enu_m=_draw_target(place, rng, position),
            goal=Goal(stays_up=True),
        )
        return [start]

    def reward(
        self, now: Situation, before_m: Float[np.ndarray, " n"], step_s: float
    ) -> Float[np.ndarray, " n"]:
        """1 for each metre that it came nearer, less 0.05 for each second and each rad/s.

        The reward of progress adds up to the distance covered, whatever the path, so that detours
        around obstacles cost only time.
        """
        return before_m - now.distance_m - step_s * (0.05 + 0.05 * now.turning_radps)

    def end_reward(self, *, is_success: bool, is_time_up: bool) -> float:
        """10 for the target, -5 for a contact."""
        if is_success:
            return _REACHED
        return 0.0 if is_time_up else _CRASH

    def is_over(self, now: Situation) -> Bool[np.ndarray, " n"]:
        """At the target, and on contact."""
        return (now.near_s > 0.0) | (now.touch_s > 0.0)

    def ending(self, now: Situation, index: int, seconds: float, *, is_time_up: bool) -> Ending:
        """State whether the target was reached."""
        if now.near_s[index] > 0.0:
            word = Verdict(True, f"reached the target after {seconds:.1f} s")
        else:
            word = Verdict(False, f"still {now.distance_m[index]:.1f} m from the target")
        return Ending(word=word, is_done=not is_time_up)


def _draw_target(place: Place, rng: np.random.Generator, start_enu_m: Vector3) -> Vector3:
    """Draw a free point one to three metres over an area."""
    # Near ones need no navigation.
    far = [area for area in place.areas if math.dist(area.centroid, start_enu_m) > _LEAST_WAY_M]
    # Without a far area go straight to the error.
    for _ in range(MOST_DRAWS if far else 0):
        x, y, z = far[rng.integers(len(far))].centroid
        target = (x, y, z + uniform(rng, 1.0, 3.0))
        if place.is_free(target):
            return target
    scene, vehicle = place.world.scene.scene_id, place.world.airframe.name
    raise EnvironmentInputError(
        f"scene {scene!r}: it has no area for {vehicle} with free air above, {_LEAST_WAY_M:g} m or "
        "more from its start; another scene is valid"
    )
