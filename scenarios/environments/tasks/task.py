"""Interface of a task, which decides for all vehicles of a batch at once.

A task draws how an episode begins, rewards steps, and says when it is over. The verdict is not its
own: success is judged as in campaigns (`scenarios.trials.verdict`), from the history and the task's
goal.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Quaternion, Vector3, quat_about_up
from scenarios.environments.cfg import EnvironmentInputError
from scenarios.environments.episodes.draws import uniform
from scenarios.environments.episodes.place import Place
from scenarios.environments.tasks.situation import Situation
from scenarios.trials.figures import Goal
from scenarios.trials.verdict import Ending

MOST_DRAWS = 100
"""Number of draws after which a scene counts as one without room."""
_MOST_TILT_RAD = math.radians(20.0)  # of a start's attitude


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """Beginning of an episode: the vehicle is released at rest, its rotors at hover speed."""

    position_enu_m: Vector3
    quat_wxyz: Quaternion
    target_enu_m: Vector3
    goal: Goal


class Task(ABC):
    """A task; `Batch` calls it.

    Methods get arrays over all vehicles and return arrays, so that a batch of thousands takes a few
    calls of numpy.
    """

    name: str
    """Name of the task; the stream of its draws is named by it, too."""
    episode_s: float
    """Longest time of an episode."""
    near_m: float
    """Distance from the target that counts as there."""
    settles = False
    """True to stop the rotors and await rest when an episode is over."""

    @abstractmethod
    def draw(self, place: Place, rng: np.random.Generator) -> list[Start]:
        """Draw the beginning of an episode for each vehicle of a world.

        Args:
            place: The world's free air and areas.
            rng: Generator of the episode; nothing else may be drawn from.

        Raises:
            EnvironmentInputError: If the scene has no place for it.
        """

    @abstractmethod
    def reward(
        self, now: Situation, before_m: Float[np.ndarray, " n"], step_s: float
    ) -> Float[np.ndarray, " n"]:
        """Return the reward of a step, without the reward of the end.

        Args:
            now: Situation after the step.
            before_m: Distances from the target before it.
            step_s: Simulated time of the step.
        """

    @abstractmethod
    def end_reward(self, *, is_success: bool, is_time_up: bool) -> float:
        """Return the reward of the end, which is added to that of the last step."""

    @abstractmethod
    def is_over(self, now: Situation) -> Bool[np.ndarray, " n"]:
        """Return whether each vehicle's episode is over before its time is up."""

    @abstractmethod
    def ending(self, now: Situation, index: int, seconds: float, *, is_time_up: bool) -> Ending:
        """Return the end of a vehicle's episode, as far as the history does not show it.

        Args:
            now: Situation after the last step.
            index: Number of the vehicle.
            seconds: Duration of the episode.
            is_time_up: True if only the time limit ended it.
        """


def draw_free(
    place: Place,
    rng: np.random.Generator,
    middle_enu_m: Vector3,
    low_m: Vector3,
    high_m: Vector3,
    what: str,
) -> Vector3:
    """Return a uniformly drawn free point of a box around a point.

    Args:
        place: The world's free air.
        rng: Generator.
        middle_enu_m: The point.
        low_m: Lower corner of the box, relative to the point.
        high_m: Upper corner, likewise.
        what: Purpose of the point, for the message.

    Raises:
        EnvironmentInputError: If a hundred draws find none.
    """
    for _ in range(MOST_DRAWS):
        point = draw_point(rng, middle_enu_m, low_m, high_m)
        if place.is_free(point):
            return point
    raise no_room(place, what)


def draw_point(
    rng: np.random.Generator, middle_enu_m: Vector3, low_m: Vector3, high_m: Vector3
) -> Vector3:
    """Return a uniformly drawn point of a box around a point."""
    (x, y, z), (x0, y0, z0), (x1, y1, z1) = middle_enu_m, low_m, high_m
    return (x + uniform(rng, x0, x1), y + uniform(rng, y0, y1), z + uniform(rng, z0, z1))


def no_room(place: Place, what: str) -> EnvironmentInputError:
    """Return the error for draws that find no free air for something."""
    scene = place.world.scene.scene_id
    return EnvironmentInputError(
        f"scene {scene!r}: it has no free air for {what}; another scene is valid"
    )


def draw_attitude(rng: np.random.Generator) -> Quaternion:
    """Return any heading, tilted by up to 20 degrees to any side."""
    w, _, _, z = quat_about_up(uniform(rng, -math.pi, math.pi))
    # Half of the tilt: the quaternion of a rotation by an angle has the sine of half of it.
    half, side = 0.5 * uniform(rng, 0.0, _MOST_TILT_RAD), uniform(rng, -math.pi, math.pi)
    c, a, b = math.cos(half), math.sin(half) * math.cos(side), math.sin(half) * math.sin(side)
    # Heading times tilt, multiplied out: the heading has only w and z, the tilt no z.
    return (w * c, w * a - z * b, w * b + z * a, z * c)
