"""Baseline that knows the map but plans no path: downhill in an artificial potential field.

It shows how much of a success rate is due to planning. The pilot has the same map as ours, and
reacts to it at each tick instead of searching for a path.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator

import numpy as np

from aeroscene.scene import InteractionArea
from autonomy.types import FlatReference, Vector3, vector3
from flightsim.mavlink.client import PX4_HOLD
from flightsim.testbench import TestbenchError
from scenarios.baselines.offboard import TICK_S, area_of, fly_line, land, take_control
from scenarios.baselines.potential_field import FieldCfg, acceleration
from scenarios.mission.mission import takeoff_point
from scenarios.mission.surroundings import MissionError, Surroundings, survey
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Verdict

_FIELD = FieldCfg()
_AT_GOAL_M, _AT_REST_MPS = 0.2, 0.1
"""Distance and speed below which the point has reached the goal."""
_NEARER_M, _PATIENCE_S = 0.25, 15.0
"""The point rests in a local minimum if it makes less than this progress in this time."""


class PotentialFieldPilot:
    """A `scenarios.Companion` that follows a point through the potential field of the given map.

    The point begins above the start, where our pilot's paths begin. Its goal is the free place
    above the area where our pilot's paths end, and from there the autopilot lands. Without an
    assigned area it chooses the roomiest one under open sky.
    """

    def __init__(self, aboard: Aboard) -> None:
        """Prepare a flight.

        Args:
            aboard: Equipment, of which it needs no camera.

        Raises:
            TestbenchError: If there is no room above the start or above the area.
        """
        self.area = area_of(aboard)
        self.verdict = Verdict(success=False, reason="not finished")
        self.is_done = False
        self._client = aboard.client
        try:
            self._world = survey(aboard.scene, aboard.airframe)
            self._above_start = takeoff_point(self._world)
            self._goal = _above(self.area, self._world)
        except MissionError as error:
            raise TestbenchError(str(error)) from error
        self._flight = self._fly()

    def update(self, time_us: int) -> None:
        """Read telemetry, and send the next set point.

        Args:
            time_us: Simulated time.
        """
        self._client.update(time_us)
        self.is_done = self.is_done or next(self._flight, self) is self

    def _fly(self) -> Iterator[None]:
        """Fly from take-off to landing; each step is a tick."""
        client = self._client
        start = yield from take_control(client)
        yield from fly_line(client, start, self._above_start, _FIELD.speed_mps)
        end = yield from self._descend()
        if (away_m := math.dist(end, self._goal)) > _AT_GOAL_M:
            reason = f"rests in a local minimum {away_m:.1f} m from above area {self.area.id}"
            self.verdict = Verdict(success=False, reason=reason)
            # It stays in the air: landing somewhere else would be no success either.
            client.set_mode(PX4_HOLD)
            return
        yield from fly_line(client, end, self._goal, _FIELD.speed_mps)
        yield from land(client)
        self.verdict = Verdict(success=True, reason="came down where the field has its minimum")

    def _descend(self) -> Generator[None, None, Vector3]:
        """Send the point's positions as set points until it rests, and return its last position."""
        position, velocity, goal = np.array(self._above_start), np.zeros(3), np.array(self._goal)
        nearest_m, since_s = math.inf, 0.0
        while since_s < _PATIENCE_S:
            away_m = float(np.linalg.norm(goal - position))
            if away_m <= _AT_GOAL_M and float(np.linalg.norm(velocity)) < _AT_REST_MPS:
                break
            # The patience starts anew with each quarter of a metre of progress.
            since_s += TICK_S
            if away_m < nearest_m - _NEARER_M:
                nearest_m, since_s = away_m, 0.0
            solids, radius_m = self._world.obstacles.solids, self._world.radius_m
            a = acceleration(position, velocity, goal, solids, radius_m, _FIELD)
            # Semi-implicit Euler, the new velocity first: it stays stable with a stiff repulsion.
            velocity += a * TICK_S
            position += velocity * TICK_S
            self._client.send_setpoint(
                FlatReference(
                    position_enu_m=vector3(position),
                    velocity_enu_mps=vector3(velocity),
                    acceleration_enu_mps2=vector3(a),
                )
            )
            yield
        return vector3(position)


def _above(area: InteractionArea, world: Surroundings) -> Vector3:
    """Return the free place above an area, with free air all the way down.

    Raises:
        MissionError: If there is none.
    """
    if (place := world.hover_above(area)) is None:
        raise MissionError(f"area {area.id} has no free place to hover above it")
    return place
