"""Pilot in the whole stack, ready to fly."""

import dataclasses
import functools

import numpy as np
import pytest

from flightsim.cameras import Cameras
from flightsim.mavlink.client.client import MavlinkClient
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.mission.mission import plan_mission
from scenarios.pilot import Pilot, PilotCfg
from scenarios.pilot.pace import AMONG_MOVERS
from scenarios.trials.figures import Goal
from scenarios.trials.flight_log import FlightLog
from tests.scenarios.landing_scenes import ON_CONTAINER

# Most flights are to one area of one yard.
planned = functools.lru_cache(maxsize=8)(plan_mission)


class Demo:
    """Testbench, cameras and pilot.

    Attributes:
        gap_m: Least distance of the vehicle's centre from any mover's box.
    """

    def __init__(
        self,
        scene,
        area=ON_CONTAINER,
        *,
        vehicle="iris",
        alternates=(),
        known=None,
        traffic=None,
        expects_traffic=None,
    ):
        """Set up a flight; `known` is the pilot's map if that is not the scene itself."""
        self.bench = Testbench(
            scene,
            TestbenchCfg(speed="max", vehicle=vehicle),
            traffic=traffic,
            has_network=False,
        )
        self.cameras = Cameras(self.bench.plant)
        looks_out = bool(traffic) if expects_traffic is None else expects_traffic
        limits = AMONG_MOVERS.limits if looks_out else None
        mission = planned(known or scene, self.bench.airframe, area=area, limits=limits)
        self.mission = dataclasses.replace(mission, alternates=tuple(alternates))
        client = MavlinkClient(self.bench.stack.pipe(), self.bench.frame)
        brief = PilotCfg(expects_traffic=looks_out)
        self.see = self.cameras.render_depth
        self.pilot = Pilot(client, self.mission, self._frame, brief)
        self.log = FlightLog(self.bench.plant)
        self.gap_m = np.inf
        self.bench.observers += [self.log.on_tick, self.on_tick]

    def _frame(self, camera):
        """Render with the present `see`."""
        return self.see(camera)

    def on_tick(self):
        plant = self.bench.plant
        self.pilot.update(plant.time_us)
        others = plant.obstacles_true
        if len(others):
            away = np.array(plant.truth.position_enu_m) - others.position_enu_m
            c, s = np.cos(others.yaw_rad), np.sin(others.yaw_rad)
            x, y = c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]
            beyond = np.abs(np.column_stack([x, y, away[:, 2]])) - others.size_m / 2
            gap_m = float(np.linalg.norm(np.maximum(beyond, 0.0), axis=1).min())
            self.gap_m = min(self.gap_m, gap_m)

    def fly(self, until=lambda: False, limit_s=120.0):
        self.bench.simulator.run(
            until_us=round(limit_s * 1e6), stop=lambda: self.pilot.is_done or until()
        )
        return self.pilot

    def fly_to(self, phase):
        """Fly until a phase begins."""
        self.fly(until=lambda: self.pilot.phase is phase)
        assert self.pilot.phase is phase, self.pilot.transitions[-1].reason
        return self.pilot

    def fly_on(self, duration_s):
        """Fly for some time more."""
        return self.fly(limit_s=self.bench.plant.time_us * 1e-6 + duration_s)

    def deviation_m(self):
        """Level distance of the vehicle from its setpoint."""
        return self.pilot._flight.level_deviation_m

    def targets(self):
        return [change.target for change in self.pilot.transitions]

    def reason(self, phase):
        """Reason of the latest entry into a phase."""
        return next(c.reason for c in reversed(self.pilot.transitions) if c.target is phase)

    def score(self):
        return self.log.score(Goal(area=self.pilot.area, chosen_enu_m=self.pilot.touchdown_enu_m))


@pytest.fixture
def demo():
    made = []

    def make(*args, **options):
        made.append(Demo(*args, **options))
        return made[-1]

    yield make
    for each in made:
        each.cameras.close()
        each.bench.close()
