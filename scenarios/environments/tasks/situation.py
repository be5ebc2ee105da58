"""Positions of a batch's vehicles, and how long they have been at their targets or in contact.

All tasks reward and end episodes by the same few figures, so these are measured once a step.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from autonomy.jit import kernel
from flightsim.plant import Fleet


class Situation:
    """The n vehicles of a batch by the truth, after the last step.

    Attributes:
        position_enu_m: Their positions (n, 3).
        target_enu_m: Their targets (n, 3), to be written.
        distance_m: Distance of each from its target (n,).
        speed_mps: Speed of each (n,).
        turning_radps: Size of the angular rate of each (n,).
        near_s: Time for which each has been within the task's `near_m` of its target (n,).
        touch_s: Time for which each has touched something (n,).
    """

    def __init__(self, fleet: Fleet, near_m: float, step_s: float) -> None:
        """Watch a fleet.

        Args:
            fleet: The vehicles.
            near_m: Distance from the target that counts as there.
            step_s: Time of a step.
        """
        history, n = fleet.history, len(fleet)
        self.position_enu_m: Float[np.ndarray, "n 3"] = history["position_true_enu_m"][:, -1]
        self._motion = (
            history["velocity_true_enu_mps"][:, -1],
            history["angular_rate_true_flu_radps"][:, -1],
            history["is_touching"],
        )
        self._near_m, self._step_s = near_m, step_s
        self.target_enu_m = np.zeros((n, 3))
        self.distance_m, self.speed_mps, self.turning_radps = np.zeros((3, n))
        self.near_s, self.touch_s = np.zeros((2, n))

    @property
    def is_touching(self) -> Bool[np.ndarray, " n"]:
        """True for each vehicle that has touched something in the last step."""
        return self.touch_s > 0.0

    def begin(self, index: int, target_enu_m: tuple[float, float, float]) -> None:
        """Give a vehicle that has been moved a new target."""
        self.target_enu_m[index] = target_enu_m
        self.near_s[index] = self.touch_s[index] = 0.0
        # The other figures follow with the next step; rewards need this one before it.
        self.distance_m[index] = math.dist(target_enu_m, self.position_enu_m[index])

    def look(self) -> None:
        """Update all figures after a step."""
        measure_situation(
            self.position_enu_m,
            *self._motion,
            self.target_enu_m,
            self._near_m,
            self._step_s,
            self.distance_m,
            self.speed_mps,
            self.turning_radps,
            self.near_s,
            self.touch_s,
        )


@kernel
def measure_situation(
    position_enu_m: np.ndarray,
    velocity_enu_mps: np.ndarray,
    rate_flu_radps: np.ndarray,
    is_touching: np.ndarray,
    target_enu_m: np.ndarray,
    near_m: float,
    step_s: float,
    distance_m: np.ndarray,
    speed_mps: np.ndarray,
    turning_radps: np.ndarray,
    near_s: np.ndarray,
    touch_s: np.ndarray,
) -> None:
    """Measure the situation of n vehicles in one call.

    The same in numpy takes 30 us for its many calls, however small n is.

    Args:
        position_enu_m: True positions (n, 3).
        velocity_enu_mps: True velocities (n, 3).
        rate_flu_radps: True angular rates (n, 3).
        is_touching: Contact (n, k), for each control tick of the step.
        target_enu_m: Targets (n, 3).
        near_m: Distance from the target that counts as there.
        step_s: Time of a step.
        distance_m: Written (n,), and so is all that follows; see `Situation`.
        speed_mps: Written.
        turning_radps: Written.
        near_s: A step longer, or zero.
        touch_s: A step longer, or zero.
    """
    for i in range(len(position_enu_m)):
        distance_m[i] = _length(target_enu_m[i] - position_enu_m[i])
        speed_mps[i] = _length(velocity_enu_mps[i])
        turning_radps[i] = _length(rate_flu_radps[i])
        # Consecutive time: leaving the target starts it again.
        near_s[i] = near_s[i] + step_s if distance_m[i] <= near_m else 0.0
        touch_s[i] = touch_s[i] + step_s if is_touching[i].any() else 0.0


@kernel
def _length(vector: np.ndarray) -> float:
    return math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
