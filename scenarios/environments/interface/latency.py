"""Delayed actions: each vehicle's actions act some steps after they were given."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from scenarios.environments.interface.actions import N_ACTIONS


class ActionQueue:
    """Actions of n vehicles, of the latest steps.

    Attributes:
        latest: The latest actions (n, 4), zero at first.
    """

    def __init__(self, n: int, longest: int) -> None:
        """Prepare for latencies of up to `longest` steps."""
        self.latest = np.zeros((n, N_ACTIONS))
        self._waiting = np.zeros((1 + longest, n, N_ACTIONS))
        self._latency = np.zeros(n, dtype=int)
        self._n_steps = 0

    def restart(self, index: int, latency: int) -> None:
        """Forget the actions of one vehicle, whose next ones act `latency` steps later."""
        self._waiting[:, index] = self.latest[index] = 0.0
        self._latency[index] = latency

    def delayed(self, actions: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
        """Store the actions of a step, and return those that act in it."""
        n_kept = len(self._waiting)
        # A ring of steps: each vehicle reads as many places back as its latency.
        self.latest[:] = self._waiting[self._n_steps % n_kept] = actions
        due = (self._n_steps - self._latency) % n_kept
        self._n_steps += 1
        return self._waiting[due, np.arange(len(actions))]
