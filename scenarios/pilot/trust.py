"""Test whether anything measures the position that the autopilot claims to know.

An autopilot that has lost its sources keeps sending positions, and some say so late or never. Its
claimed deviation, however, then rises without end.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

_SECONDS = 3
_LEAST_RISE_M = 0.035
"""Least rise of the claimed deviation in each of these seconds, and ..."""
_LEAST_RISE_IN_ALL_M = 0.2
"""... in all of them together, that only an estimate without any position has. Odometry was seen to
cause 0.1 m of it; a receiver that gets worse makes one step."""


class Trust:
    """Watches the deviation that the autopilot claims for its horizontal position.

    While neither satellites nor odometry measure the position, the deviation rises on and on.
    """

    def __init__(self) -> None:
        self._claims: deque[tuple[int, float]] = deque()
        self.is_adrift = False
        """True if nothing seems to measure the position."""

    def update(self, time_us: int, sigma_m: float) -> None:
        """Record the present claim; NaN and infinity are ignored."""
        claims = self._claims
        if not math.isfinite(sigma_m):
            return
        claims.append((time_us, sigma_m))
        since_us = time_us - _SECONDS * 1_000_000
        while len(claims) > 1 and claims[1][0] <= since_us:
            claims.popleft()
        if claims[0][0] > since_us:
            return
        each_m = [self._claimed_m(time_us - n * 1_000_000) for n in range(_SECONDS, -1, -1)]
        rises_m = [after - before for before, after in pairwise(each_m)]
        starts = min(rises_m) > _LEAST_RISE_M and sum(rises_m) > _LEAST_RISE_IN_ALL_M
        # A few seconds of steep rise start it; then any rise keeps it.
        self.is_adrift = starts or (self.is_adrift and rises_m[-1] > 0.0)

    def _claimed_m(self, time_us: int) -> float:
        """Return the claim that held at a time."""
        return next(sigma_m for at_us, sigma_m in reversed(self._claims) if at_us <= time_us)
