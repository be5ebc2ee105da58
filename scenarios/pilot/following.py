"""How well the vehicle follows its course, learned in flight: flight stacks differ in it."""

from __future__ import annotations

import math
from collections import deque

from scenarios.pilot.course import AT_PLACE_M, AT_REST_MPS

SETTLING_US = 1_000_000
"""Time at rest of the course before the vehicle counts as hovering: it still brakes."""
MOST_AWAY_M, MOST_DRIFT_MPS = 0.5, 0.6
"""Bounds beyond which no hover counts as one: the distance is as far off as a landing may end."""
USUAL_STRAY_M, MOST_STRAY_M = 0.5, 1.0
"""Distance from the plan that its usual margin allows for, and the most that any is made for."""
_PERIOD_US = 100_000
_LEAST_SAMPLES, _MOST_SAMPLES = 10, 80
"""A second is enough to tell; of what was longer ago than eight, nothing is kept."""
_SHARE = 0.9
"""Share of the samples that it keeps within what it is said to keep within."""
_HEADROOM = 1.25
"""Allowance for the rest of them."""
_STEP_M = 0.2
"""Step in which the margin of plans grows, so that the map is searched anew only now and then."""


class Following:
    """Learns from the distance and the speed between the vehicle and its setpoint in the air."""

    def __init__(self) -> None:
        self._strays_m: deque[float] = deque(maxlen=_MOST_SAMPLES)
        self._hover_m: deque[float] = deque(maxlen=_MOST_SAMPLES)
        self._hover_mps: deque[float] = deque(maxlen=_MOST_SAMPLES)
        self._due_us = 0
        self._rests_since_us: int | None = None

    def hear(self, time_us: int, away_m: float, drift_mps: float, *, is_resting: bool) -> None:
        """Learn from the present moment of a flight.

        Args:
            time_us: Time now.
            away_m: Level distance of the vehicle from its setpoint.
            drift_mps: Level speed relative to it.
            is_resting: Whether the course is at rest.
        """
        if not is_resting:
            self._rests_since_us = None
        elif self._rests_since_us is None:
            self._rests_since_us = time_us
        if time_us < self._due_us:
            return
        self._due_us = time_us + _PERIOD_US
        self._strays_m.append(away_m)
        since_us = self._rests_since_us
        if since_us is not None and time_us - since_us >= SETTLING_US:
            self._hover_m.append(away_m)
            self._hover_mps.append(drift_mps)

    @property
    def stray_m(self) -> float:
        """Distance from its setpoint to allow for, flying or hovering; 0 at first."""
        return min(_HEADROOM * _kept(self._strays_m), MOST_STRAY_M)

    @property
    def margin_m(self) -> float:
        """Margin that plans need for that; 0 for the usual one."""
        if self.stray_m <= USUAL_STRAY_M:
            return 0.0
        return min(_STEP_M * math.ceil(self.stray_m / _STEP_M), MOST_STRAY_M)

    @property
    def keeps(self) -> tuple[float, float]:
        """Distance and speed that it stays below as it hovers; zeros while that is not learned."""
        return _kept(self._hover_m), _kept(self._hover_mps)

    @property
    def at_place(self) -> tuple[float, float]:
        """Distance and speed that count as being at a place, at rest."""
        away_m, drift_mps = self.keeps
        return (
            min(max(AT_PLACE_M, away_m), MOST_AWAY_M),
            min(max(AT_REST_MPS, drift_mps), MOST_DRIFT_MPS),
        )


def _kept(values: deque[float]) -> float:
    """What the usual share of values is within, 0 of too few."""
    if len(values) < _LEAST_SAMPLES:
        return 0.0
    return sorted(values)[math.ceil(_SHARE * len(values)) - 1]
