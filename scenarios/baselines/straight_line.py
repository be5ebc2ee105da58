"""Baseline without perception, map or planning: straight up, straight across, straight down.

Its success rate is what a scene gives away for nothing. Only the success of another pilot beyond
that rate is the pilot's own merit.
"""

from __future__ import annotations

from collections.abc import Iterator

from scenarios.baselines.offboard import area_of, fly_line, land, take_control
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Verdict

_TAKEOFF_M, _HOVER_M = 2.5, 3.0
"""Heights above the start and above the area between which it flies the line."""
_SPEED_MPS = 2.5


class StraightLinePilot:
    """A `scenarios.Companion` that flies straight to the assigned area, whatever is in between.

    Without an assigned area it chooses the roomiest one under open sky.
    """

    def __init__(self, aboard: Aboard) -> None:
        self.area = area_of(aboard)
        self.verdict = Verdict(success=False, reason="not finished")
        self.is_done = False
        self._client = aboard.client
        self._flight = self._fly()

    def update(self, time_us: int) -> None:
        """Read telemetry, and send the next set point."""
        self._client.update(time_us)
        self.is_done = self.is_done or next(self._flight, self) is self

    def _fly(self) -> Iterator[None]:
        """Fly from take-off to landing; each step is a tick."""
        client = self._client
        x, y, z = start = yield from take_control(client)
        above_start = (x, y, z + _TAKEOFF_M)
        # The line between the two points may climb or descend, and goes through whatever it meets.
        goal_x, goal_y, goal_z = self.area.centroid
        above_goal = (goal_x, goal_y, goal_z + _HOVER_M)
        yield from fly_line(client, start, above_start, _SPEED_MPS)
        yield from fly_line(client, above_start, above_goal, _SPEED_MPS)
        yield from land(client)
        self.verdict = Verdict(success=True, reason="came down where the straight line ends")
