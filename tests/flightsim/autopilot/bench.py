"""Autopilot on the real plant above empty ground, with the queries that tests need."""

import math
from functools import cache

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.events import MissionItemReached, Statustext
from flightsim.autopilot.mission_item import MissionItem
from flightsim.autopilot.modes import LandedState, Mode
from flightsim.frames import Geodetic, LocalFrame
from flightsim.plant import Plant
from flightsim.plant.cfg import PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, relief_scene

GROUND_AMSL_M = 488.0
NAN = math.nan


@cache
def world_with(vehicle, start=(0.0, 0.0, 0.0), extra=(), relief=None):
    scene = empty_scene(start) if relief is None else relief_scene(relief)
    return build_world(scene, AIRFRAMES[vehicle], extra=extra)


class Bench:
    """Vehicle at (0, 0), facing east, ready to arm; `plant` configures the plant."""

    def __init__(
        self,
        vehicle="iris",
        *,
        initial_parameters=None,
        start=(0.0, 0.0, 0.0),
        extra=(),
        relief=None,
        seed=7,
        **plant,
    ):
        self.plant = Plant(world_with(vehicle, start, extra, relief), PlantCfg(seed=seed, **plant))
        self.frame = LocalFrame(Geodetic(47.4, 8.5, GROUND_AMSL_M))
        self.pilot = Autopilot(
            self.plant,
            self.frame,
            airframe=AIRFRAMES[vehicle],
            initial_parameters=initial_parameters,
            terrain=relief,
        )
        self.texts: list[str] = []
        self.reached: list[int] = []
        self.setpoints = []
        self.positions = []
        assert self.run(5.0, lambda: self.pilot.prearm.is_ok)

    def step(self):
        self.plant.advance()
        self.pilot.update()
        for event in self.pilot.pop_events():
            if isinstance(event, Statustext):
                self.texts.append(event.text)
            elif isinstance(event, MissionItemReached):
                self.reached.append(event.index)
        self.setpoints.append(self.pilot.setpoint)
        self.positions.append(self.plant.truth.position_enu_m)

    def run(self, seconds, until=None, *, each=None):
        """Run for a time or until a condition; return whether it was met."""
        for _ in range(round(seconds * 50)):
            if each is not None:
                each()
            self.step()
            if until is not None and until():
                return True
        return until is None

    def stream(self, setpoint, seconds, until=None):
        """Run while a companion sends a setpoint at 50 Hz."""
        return self.run(seconds, until, each=lambda: self.pilot.set_offboard_setpoint(setpoint))

    def steer(self, seconds, *, pitch=0.0, roll=0.0, throttle=0.5, yaw=0.0):
        """Run while a pilot holds the sticks."""
        self.run(
            seconds,
            each=lambda: self.pilot.set_manual_control(
                pitch=pitch, roll=roll, throttle=throttle, yaw=yaw
            ),
        )

    def take_off(self, height_m=3.0):
        """Arm, climb and hold."""
        assert self.pilot.arm().is_accepted
        assert self.pilot.takeoff(GROUND_AMSL_M + height_m).is_accepted
        assert self.run(20.0, lambda: self.pilot.mode is Mode.HOLD)
        return self

    def geodetic(self, east_m, north_m, up_m=NAN):
        return self.frame.geodetic_from_enu((east_m, north_m, up_m))

    def item(self, command, east_m=0.0, north_m=0.0, up_m=0.0, **fields):
        """Create a mission item in the frame "global, relative to home"."""
        place = self.geodetic(east_m, north_m, 0.0)
        return MissionItem(
            command=command,
            x=place.latitude_deg,
            y=place.longitude_deg,
            z=up_m,
            **{"frame": 6, **fields},
        )

    @property
    def position(self):
        """True position of the soles' ground-level reference: 0 high when standing."""
        x, y, z = self.plant.truth.position_enu_m
        return (x, y, z - self.plant.world.airframe.leg_length_m)

    @property
    def speed_mps(self):
        return math.hypot(*self.plant.truth.velocity_enu_mps)

    @property
    def yaw_rad(self):
        w, x, y, z = self.plant.truth.quat_wxyz
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))

    @property
    def is_on_ground(self):
        return self.pilot.landed_state is LandedState.ON_GROUND

    def says(self, fragment):
        """Whether a status text contains these words."""
        return any(fragment in text for text in self.texts)
