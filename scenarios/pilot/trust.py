"""How far the estimate of the position is to be trusted: is there anything that it rests on?"""

from __future__ import annotations

import math
from collections import deque

_LOOK_BACK_US = 1_000_000
_LEAST_RISE_M = 0.05
"""Rise of the claimed deviation in each of two seconds, at least, and ..."""
_LEAST_RISE_IN_BOTH_M = 0.13
"""... in both together, that only an estimate without any position has. Odometry at the pilot's
greatest speed makes 0.09 m of it, and less later on; a receiver that gets worse makes one step."""


class Trust:
    """Watches the deviation that the autopilot claims for its horizontal position.

    While neither satellites nor odometry measure it, the deviation rises faster and faster.
    """

    def __init__(self) -> None:
        self._claims: deque[tuple[int, float]] = deque()
        self.is_adrift = False
        """Whether nothing seems to measure the position."""

    def hear(self, time_us: int, sigma_m: float) -> None:
        """Take the present claim."""
        claims = self._claims
        if not math.isfinite(sigma_m):
            return
        claims.append((time_us, sigma_m))
        while len(claims) > 1 and claims[1][0] <= time_us - 2 * _LOOK_BACK_US:
            claims.popleft()
        if time_us - claims[0][0] < 2 * _LOOK_BACK_US:
            return
        before_m = next(sigma for at, sigma in claims if at >= time_us - _LOOK_BACK_US)
        early_m, late_m = before_m - claims[0][1], sigma_m - before_m
        rises = min(early_m, late_m) > _LEAST_RISE_M and early_m + late_m > _LEAST_RISE_IN_BOTH_M
        self.is_adrift = rises or (self.is_adrift and late_m > 0.0)
