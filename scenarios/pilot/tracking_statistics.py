"""Learns in flight how closely the vehicle follows its set points, because flight stacks differ.

Fixed tolerances that suit one flight stack keep another one waiting for ever: a real PX4 in wind
never hovers as still as our own autopilot does.
"""

from __future__ import annotations

import math
from collections import deque

from scenarios.pilot.course import AT_PLACE_M, AT_REST_MPS

SETTLING_US = 1_000_000
"""Time at rest of the course until the vehicle counts as hovering. Before that it still brakes."""
MOST_AWAY_M, MOST_DRIFT_MPS = 0.5, 0.6
"""Greatest tolerances for a hover. The distance is that by which a landing may miss its point."""
USUAL_STRAY_M, MOST_STRAY_M = 0.5, 1.0
"""Deviation that the usual margin of plans covers, and the greatest one that any margin covers."""
_PERIOD_US = 100_000  # between two samples: ten a second
_LEAST_SAMPLES, _MOST_SAMPLES = 10, 80
"""One second of samples is enough to judge by; samples older than eight seconds are dropped."""
_SHARE = 0.9
"""Share of the samples that must lie within a learned distance or speed."""
_HEADROOM = 1.25
"""Factor on the learned deviation, for the samples beyond that share."""
_STEP_M = 0.2
"""Step by which the margin of plans grows. Each new margin costs a search of the map, so steps are
coarse."""


class TrackingStatistics:
    """Learns from the distance and the speed between the vehicle and its set point in the air.

    Quantiles of the last eight seconds are used instead of means, because a single gust must not
    decide and a steady lag must.
    """

    def __init__(self) -> None:
        self._strays_m: deque[float] = deque(maxlen=_MOST_SAMPLES)
        self._hover_m: deque[float] = deque(maxlen=_MOST_SAMPLES)
        self._hover_mps: deque[float] = deque(maxlen=_MOST_SAMPLES)
        self._due_us = 0
        self._rests_since_us: int | None = None

    def update(self, time_us: int, away_m: float, drift_mps: float, *, is_resting: bool) -> None:
        """Learn from the present moment of a flight.

        Args:
            time_us: Time now.
            away_m: Level distance of the vehicle from its set point.
            drift_mps: Level speed relative to it.
            is_resting: True if the course is at rest.
        """
        if not is_resting:
            self._rests_since_us = None
        elif self._rests_since_us is None:
            self._rests_since_us = time_us
        # Ticks come five times as often; ten samples a second are enough for quantiles.
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
        """Distance from its set point to allow for, flying or hovering, m; 0 at first."""
        return min(_HEADROOM * _kept(self._strays_m), MOST_STRAY_M)

    @property
    def margin_m(self) -> float:
        """Margin that plans need because of that, m; 0 for the usual one."""
        if self.stray_m <= USUAL_STRAY_M:
            return 0.0
        return min(_STEP_M * math.ceil(self.stray_m / _STEP_M), MOST_STRAY_M)

    @property
    def keeps(self) -> tuple[float, float]:
        """Distance and speed that the vehicle keeps in a hover; zeros before that is learned."""
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
    """Return the value that the usual share of values does not exceed, 0 for too few values."""
    if len(values) < _LEAST_SAMPLES:
        return 0.0
    # At most 80 values, so sorting them at each call is cheap.
    return sorted(values)[math.ceil(_SHARE * len(values)) - 1]
