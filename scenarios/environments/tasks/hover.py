"""Hover: come to a point nearby, and stay there."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from scenarios.environments.episodes.place import Place
from scenarios.environments.tasks.situation import Situation
from scenarios.environments.tasks.task import Start, Task, draw_attitude, draw_free
from scenarios.trials.figures import Goal
from scenarios.trials.verdict import Ending, Verdict

# Distance from the target that ends an episode; time at the target that counts as held.
_FARTHEST_M = 5.0
_HELD_S = 1.0
# Distance at which the reward of closeness has fallen to 1/e.
_CLOSENESS_M = 0.5
_CRASH = -5.0


class Hover(Task):
    """Success is to be within 0.25 m of the target for the last second of the episode."""

    name = "hover"
    episode_s = 10.0
    near_m = 0.25

    def draw(self, place: Place, rng: np.random.Generator) -> list[Start]:
        """Draw a target about two metres over the scene's start, and a start within a metre."""
        # The target first: the start is drawn relative to it.
        target = draw_free(
            place, rng, place.start_enu_m, (-1.0, -1.0, 1.5), (1.0, 1.0, 2.5), "a target to hover"
        )
        position = draw_free(
            place, rng, target, (-1.0, -1.0, -0.8), (1.0, 1.0, 0.8), "a start beside the target"
        )
        start = Start(
            position_enu_m=position,
            quat_wxyz=draw_attitude(rng),
            target_enu_m=target,
            goal=Goal(stays_up=True),
        )
        return [start]

    def reward(
        self,
        now: Situation,
        before_m: Float[np.ndarray, " n"],  # noqa: ARG002 - of other tasks
        step_s: float,
    ) -> Float[np.ndarray, " n"]:
        """A second at the target is worth 1, less 0.1 for each m/s and 0.05 for each rad/s.

        The exponential gives a gradient from anywhere and is steep near the target.
        """
        closeness = np.exp(-now.distance_m / _CLOSENESS_M)
        return step_s * (closeness - 0.1 * now.speed_mps - 0.05 * now.turning_radps)

    def end_reward(self, *, is_success: bool, is_time_up: bool) -> float:
        """-5 for an end before the time."""
        return 0.0 if is_success or is_time_up else _CRASH

    def is_over(self, now: Situation) -> Bool[np.ndarray, " n"]:
        """On contact, and five metres away."""
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
