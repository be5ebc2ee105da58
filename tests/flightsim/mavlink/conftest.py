"""Vehicle with its real plant and autopilot on an empty field, and an in-process client."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from aeroscene.scene import Scene
from flightsim.autopilot.autopilot import Autopilot
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.links import InProcessLink
from flightsim.mavlink.personalities import PX4, Personality
from flightsim.mavlink.server import MavlinkServer
from flightsim.payload import Payload, PayloadCfg
from flightsim.plant import Plant, PlantCfg
from flightsim.simulator import Simulator
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import World, build_world
from tests.flightsim.mavlink.wire import Heard, Wire, named

START_ENU_M = (12.0, -7.0, 0.0)


class Flight:
    """A simulated vehicle and one client of its MAVLink server, in lockstep."""

    def __init__(
        self, world: World, personality: Personality = PX4, payload: PayloadCfg | None = None
    ):
        self.plant = Plant(world, PlantCfg(seed=3))
        scene = world.scene
        self.frame = LocalFrame(Geodetic(scene.latitude_deg, scene.longitude_deg, scene.altitude_m))
        self.autopilot = Autopilot(
            self.plant,
            self.frame,
            airframe=world.airframe,
            initial_parameters=personality.initial_parameters,
            parameter_ranges=personality.parameter_ranges,
            pilot_speeds_limit_all=personality.pilot_speeds_limit_all,
        )
        self.link = InProcessLink()
        self.payload = (
            None if payload is None else Payload(self.plant, self.autopilot, self.frame, payload)
        )
        self.server = MavlinkServer(
            self.autopilot,
            self.plant,
            self.frame,
            [self.link],
            personality=personality,
            payload=self.payload,
        )
        self.simulator = Simulator(self.plant, self.autopilot, self.server, speed="max")
        self.wire = Wire()
        self._heard: list[Any] = []
        self._latest: list[Heard] = []

    @property
    def heard(self) -> list[Any]:
        """All messages received."""
        for came in self._latest:
            self._heard += came
        self._latest.clear()
        return self._heard

    def close(self) -> None:
        self.server.close()
        if self.payload is not None:
            self.payload.close()

    def send(self, name: str, *values: Any, **named_values: Any) -> None:
        self.link.client.send(self.wire.encode(name, *values, **named_values))

    def step(self, count: int = 1) -> Heard:
        """Run some ticks and return the messages received."""
        data = bytearray()
        for _ in range(count):
            self.simulator.step()
            data += self.link.client.recv()
        came = Heard(self.wire, bytes(data))
        self._latest.append(came)
        return came

    def skip(self, seconds: float) -> None:
        """Run without receiving, which is most of the work."""
        for _ in range(round(50 * seconds)):
            self.simulator.step()
            self.link.client.recv()

    def run(self, seconds: float) -> Heard:
        return self.step(round(50 * seconds))

    def run_until(self, is_reached: Callable[[], bool], limit_s: float = 60.0) -> None:
        for _ in range(round(50 * limit_s)):
            if is_reached():
                return
            self.step()
        raise AssertionError(f"not reached within {limit_s} simulated seconds")

    def command(self, number: int, *params: float, **fields: Any) -> int:
        """Send a COMMAND_LONG and return the result of its acknowledgement."""
        params = (*params, *(0.0,) * (7 - len(params)))
        target = (fields.get("system", 1), fields.get("component", 1))
        self.send("COMMAND_LONG", *target, number, 0, *params)
        return self.result_of(number)

    def command_int(self, number: int, frame: int, *params: Any) -> int:
        """Send a COMMAND_INT and return the result of its acknowledgement."""
        self.send("COMMAND_INT", 1, 1, frame, number, 0, 0, *params)
        return self.result_of(number)

    def result_of(self, number: int) -> int:
        (ack,) = [m for m in named(self.step(), "COMMAND_ACK") if m.command == number]
        assert (ack.target_system, ack.target_component) == (255, 190)
        return ack.result

    def last(self, name: str) -> Any:
        """Latest message of a type."""
        return named(self.heard, name)[-1]

    def become_ready(self) -> None:
        """Wait until the vehicle can be armed."""
        self.run_until(lambda: self.autopilot.health.is_armable)

    def take_off(self, height_m: float = 10.0) -> None:
        self.become_ready()
        self.autopilot.parameters.set("MIS_TAKEOFF_ALT", height_m)
        assert self.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
        assert self.command(mav.MAV_CMD_NAV_TAKEOFF, *(float("nan"),) * 7) == 0
        up_m = self.plant.truth.position_enu_m[2]
        self.run_until(lambda: self.plant.truth.position_enu_m[2] > up_m + height_m - 0.5)


@pytest.fixture(scope="session")
def field() -> World:
    """Empty field, with the vehicle away from the scene's origin."""
    scene = Scene(
        scene_id="field",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-200.0, -200.0, 0.0),
        extent_max_enu_m=(200.0, 200.0, 120.0),
        start_position_enu_m=START_ENU_M,
        start_yaw_rad=0.7,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=(),
    )
    return build_world(scene, AIRFRAMES["iris"])


@pytest.fixture
def flight(field: World) -> Iterator[Flight]:
    """Fresh vehicle on the field whose client has already sent data."""
    flight = Flight(field)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    yield flight
    flight.close()
