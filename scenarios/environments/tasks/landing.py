"""Landing: come down on an area of the scene, softly and in its middle."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from scenarios.environments.cfg import EnvironmentInputError
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

_FARTHEST_M = 15.0
_APPROACH_M = ((-1.5, -1.5, 1.0), (1.5, 1.5, 5.0))
"""Bounds of the start, relative to the area's middle."""
TOUCHDOWN_S = 0.3
"""A vehicle that has touched something for so long has landed, well or not."""
_LANDED, _CRASH = 10.0, -5.0


class Landing(Task):
    """Success is the trial's `landed`: at rest, upright and soft, near the middle of the area.

    When the vehicle has touched something for 0.3 s its rotors are stopped, as a flight stack does,
    and within the same step it comes to rest.
    """

    name = "landing"
    episode_s = 20.0
    near_m = 0.5
    settles = True

    def draw(self, place: Place, rng: np.random.Generator) -> list[Start]:
        """Draw an area, and a start one to five metres above it."""
        if not place.areas:
            raise EnvironmentInputError(
                f"scene {place.world.scene.scene_id!r}: it has no landing area for "
                f"{place.world.airframe.name} but its start; another scene is valid"
            )
        # Another area at each draw, because a roof may cover one of them.
        for _ in range(MOST_DRAWS):
            area = place.areas[rng.integers(len(place.areas))]
            x, y, z = area.centroid
            position = draw_point(rng, area.centroid, *_APPROACH_M)
            if place.is_free(position):
                start = Start(
                    position_enu_m=position,
                    quat_wxyz=draw_attitude(rng),
                    # The target is the vehicle's centre as it stands on the area.
                    target_enu_m=(x, y, z + place.world.airframe.leg_length_m),
                    goal=Goal(area=area, others=place.areas),
                )
                return [start]
        raise no_room(place, "an approach")

    def reward(
        self, now: Situation, before_m: Float[np.ndarray, " n"], step_s: float
    ) -> Float[np.ndarray, " n"]:
        """1 for each metre nearer, less a price for turning and for too much speed.

        A speed of 0.5 m/s plus half the distance per second is free; each m/s more costs 1 a
        second, and each rad/s 0.1.
        """
        # The allowed speed falls with the distance, so that slowing down in time pays.
        free_mps = 0.5 + 0.5 * now.distance_m
        too_fast_mps = np.maximum(now.speed_mps - free_mps, 0.0)
        return before_m - now.distance_m - step_s * (too_fast_mps + 0.1 * now.turning_radps)

    def end_reward(self, *, is_success: bool, is_time_up: bool) -> float:
        """10 for the verdict `landed`, -5 for any other end before the time."""
        if is_success:
            return _LANDED
        return 0.0 if is_time_up else _CRASH

    def is_over(self, now: Situation) -> Bool[np.ndarray, " n"]:
        """After the touchdown, and far away."""
        return (now.touch_s >= TOUCHDOWN_S) | (now.distance_m > _FARTHEST_M)

    def ending(self, now: Situation, index: int, seconds: float, *, is_time_up: bool) -> Ending:
        """State whether it came down at all; the verdict follows from the history."""
        # Only a touch: whether it was a landing is the verdict's to judge.
        is_down = now.touch_s[index] > 0.0
        said = f"{now.distance_m[index]:.1f} m from the target after {seconds:.1f} s"
        return Ending(word=Verdict(bool(is_down), said), is_done=not is_time_up)
