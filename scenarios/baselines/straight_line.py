"""Baseline without perception, map or planning: straight up, straight across, straight down.

What it reaches is what a scene gives for nothing; what another pilot reaches beyond that is the
pilot's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from autonomy.types import FlatReference, Vector3, vector3
from flightsim.mavlink.client import PX4_LAND, PX4_OFFBOARD
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Verdict

_TAKEOFF_M, _HOVER_M = 2.5, 3.0
"""Heights above the start and above the area between which it flies the line."""
_SPEED_MPS = 2.5
_TICK_S = 0.02
_REST_S = 1.0
"""Time at the end of a line, to come to rest."""


class StraightLinePilot:
    """A `scenarios.Companion` that flies the straight line to the assigned area, whatever stands.

    Without an assigned area it chooses the roomiest one under open sky.
    """

    def __init__(self, aboard: Aboard) -> None:
        areas = aboard.scene.landing_areas
        self.area = aboard.area or max(areas, key=lambda area: (area.clearance_m, area.radius))
        self.verdict = Verdict(success=False, reason="not finished")
        self.is_done = False
        self._client = aboard.client
        self._flight = self._fly()

    def update(self, time_us: int) -> None:
        """Read telemetry and fly on."""
        self._client.update(time_us)
        self.is_done = self.is_done or next(self._flight, self) is self

    def _fly(self) -> Iterator[None]:
        """The whole flight; each step is a tick."""
        client, state = self._client, self._client.telemetry
        client.request_streams()
        while not (state.has_state and state.is_armable and state.local_origin_enu_m):
            yield
        x, y, z = start = state.position_enu_m
        yield from self._line(start, start)  # Offboard mode wants a stream of setpoints first.
        client.set_mode(PX4_OFFBOARD)
        client.arm()
        above_start = (x, y, z + _TAKEOFF_M)
        goal_x, goal_y, goal_z = self.area.centroid
        yield from self._line(start, above_start)
        yield from self._line(above_start, (goal_x, goal_y, goal_z + _HOVER_M))
        client.set_mode(PX4_LAND)
        while state.is_armed:
            yield
        self.verdict = Verdict(success=True, reason="came down where the straight line ends")

    def _line(self, start_enu_m: Vector3, end_enu_m: Vector3) -> Iterator[None]:
        """Setpoints along a line from rest to rest."""
        start, way = np.array(start_enu_m), np.subtract(end_enu_m, start_enu_m)
        # The smooth step is 1.5 times as fast in its middle as on average.
        n_ticks = math.ceil(1.5 * float(np.linalg.norm(way)) / _SPEED_MPS / _TICK_S)
        for tick in range(n_ticks + round(_REST_S / _TICK_S)):
            share = min(1.0, (tick + 1) / max(n_ticks, 1))
            at = start + share * share * (3.0 - 2.0 * share) * way
            self._client.send_setpoint(FlatReference(position_enu_m=vector3(at)))
            yield
