"""Vehicles that a whole autopilot flies, with the interface of a fleet.

An environment over them is the same as over a `Fleet`, except that an action is a MAVLink setpoint.
It passes through links, modes, failsafes and limits, as it would from a companion computer, and
acts two ticks after it was sent. Several vehicles fly in one process, one after the other; for more
cores, start more processes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Quaternion, Vector3
from flightsim.environment.wind import CALM, WindCfg
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.client import MavlinkClient
from flightsim.plant import Plant
from flightsim.plant.record import HISTORY_DTYPE, PLANT_DTYPE, with_rotors
from flightsim.simulator import TICK_US, Simulator
from flightsim.testbench import TestbenchCfg
from flightsim.testbench.ended_vehicles import free_ended
from flightsim.testbench.vehicle import Vehicle
from flightsim.world import World
from scenarios.environments.cfg import EnvironmentCfg, EnvironmentInputError
from scenarios.environments.interface.actions import ActionScale
from scenarios.environments.interface.by_mavlink import check_offboard, send_command

_LOOP_HZ = 1_000_000 // TICK_US
_LONGEST_S = 60.0
"""Simulated time within which a vehicle has to be in the air; a real flight stack needs some 20."""
_STREAM_S = 0.5  # of setpoints before offboard mode is asked for
_RETRY_S = 1.0
_LIFT_M = 0.8
_LIFT_MPS = 1.5
_SETTLE_S = 0.2
"""Time without motion after the vehicle was put to its start."""
_WITHIN_M = 0.3


class AutopilotError(RuntimeError):
    """A flight stack is lost, or does not take off; one line says why."""


@dataclass(frozen=True, kw_only=True, slots=True)
class AutopilotCfg:
    """The autopilot that flies the vehicles of an environment."""

    name: Literal["builtin", "px4", "ardupilot"] = "builtin"
    """Our own, or another one, which runs in lockstep; see docs/flight_stacks.md."""
    binary: str = ""
    """Program of another one, which is started anew for each episode."""
    instance: int = 0
    """First instance: shifts the ports of another one. Each further vehicle takes the next."""


class AutopilotFleet:
    """Vehicles in worlds of their own, each flown by an autopilot of its own.

    It has those members of `flightsim.plant.Fleet` that environments use.
    """

    n_together = 1

    def __init__(
        self, worlds: Sequence[World], cfg: EnvironmentCfg, autopilot: AutopilotCfg
    ) -> None:
        """Prepare vehicles; each is built when its first episode begins.

        Args:
            worlds: World of each vehicle.
            cfg: Configuration of the environment.
            autopilot: The autopilot.

        Raises:
            EnvironmentInputError: If the configuration asks for more than an autopilot allows.
        """
        _check(cfg)
        self.worlds = list(worlds)
        self._n_ticks = _LOOP_HZ // cfg.action_hz
        self._cfg, self._autopilot = cfg, autopilot
        self._bench = _bench_cfg(cfg, autopilot)
        n, n_rows = len(worlds), self._bench.plant_cfg.control_hz // cfg.action_hz
        n_rotors = len(worlds[0].airframe.quadrotor.rotors)
        self.records = np.zeros(n, PLANT_DTYPE)
        self.history = with_rotors(np.zeros((n, n_rows), HISTORY_DTYPE), n_rotors)
        self.motor_speeds_radps = np.zeros((n, n_rotors))
        self.time_s = np.zeros(n)
        self._seats: list[_Seat | None] = [None] * n

    def __len__(self) -> int:
        return len(self.worlds)

    def client(self, index: int) -> MavlinkClient:
        """Return the companion of a vehicle whose episode has begun."""
        return self._seat(index).client

    def data(self, index: int) -> Any:
        """Return MuJoCo's state of a vehicle's world; read it only."""
        return self._seat(index).plant.data

    def advance(self) -> None:
        """Advance all vehicles by a step of the environment.

        Raises:
            AutopilotError: If a flight stack is lost.
        """
        for index in range(len(self)):
            self.advance_one(index)

    def advance_one(self, world: int) -> None:
        """Advance one vehicle by a step."""
        seat, rows = self._seat(world), self.history[world]
        k = len(rows) // self._n_ticks
        for i in range(self._n_ticks):
            seat.tick()
            rows[i * k : (i + 1) * k] = seat.plant.history
        self._look(world)

    def share(self, worlds: Sequence[int], work: Callable[[int], None]) -> None:
        """Call a function with each of some worlds."""
        for world in worlds:
            work(world)

    def restart(
        self,
        world: int,
        seed: int,
        wind: WindCfg = CALM,
        *,
        held_at: Sequence[tuple[Vector3, Quaternion]] = (),
        mass_shares: Sequence[float] = (),  # noqa: ARG002 - of other fleets
    ) -> None:
        """Begin anew: build a vehicle with its autopilot, take off, and come to a start.

        Args:
            world: Number of the world.
            seed: Seed of the flight.
            wind: Wind.
            held_at: Pose of the start; another flight stack flies to its position.
            mass_shares: Refused when the fleet was built.

        Raises:
            AutopilotError: If it does not take off or does not come to the start.
        """
        if (before := self._seats[world]) is not None:
            before.close()
            self._seats[world] = None
        free_ended()
        self._seats[world] = seat = _Seat(
            self.worlds[world], self._bench, self._autopilot.instance + world, seed, wind
        )
        seat.take_off()
        (pose,) = held_at
        seat.come_to(*pose)
        self.history[world] = seat.plant.history[-1]
        self._look(world)

    def align(self, worlds: Sequence[int]) -> None:
        """Do nothing: a vehicle that has taken off is aligned."""

    def release(self, world: int) -> None:
        """Do nothing: the vehicle is in the air."""

    def vehicles_of(self, world: int) -> range:
        """Return the numbers of the vehicles of a world."""
        return range(world, world + 1)

    def close(self) -> None:
        """End all flight stacks."""
        for seat in self._seats:
            if seat is not None:
                seat.close()
        self._seats = [None] * len(self)

    def _seat(self, index: int) -> _Seat:
        seat = self._seats[index]
        assert seat is not None
        return seat

    def _look(self, index: int) -> None:
        """Take over the state of a vehicle's plant, and the estimate of another flight stack."""
        seat = self._seat(index)
        self.time_s[index] = seat.plant.time_us * 1e-6
        self.records[index] = seat.plant.records[0]
        if self._autopilot.name != "builtin":
            t, estimate = seat.client.telemetry, self.records["filter"]
            estimate["position_enu_m"][index] = t.position_enu_m
            estimate["velocity_enu_mps"][index] = t.velocity_enu_mps
            estimate["quat_wxyz"][index] = t.quat_wxyz
            estimate["angular_rate_flu_radps"][index] = t.angular_rate_flu_radps


class OffboardActuation:
    """Sends actions to the autopilots of a fleet as MAVLink setpoints."""

    def __init__(self, fleet: AutopilotFleet, cfg: EnvironmentCfg) -> None:
        self._fleet, self._level = fleet, cfg.action
        self._scale = ActionScale([world.airframe for world in fleet.worlds], cfg.action)

    def apply(
        self,
        actions: Float[np.ndarray, "n 4"],
        position_enu_m: Float[np.ndarray, "n 3"],
        quat_wxyz: Float[np.ndarray, "n 4"],
    ) -> None:
        """Send the setpoint of each vehicle; arguments are those of `Actuation.apply`."""
        commands = self._scale.commands(actions, position_enu_m, quat_wxyz)
        for index in range(len(actions)):
            send_command(self._fleet.client(index), self._level, commands, index)

    def stop(self, which: int | Bool[np.ndarray, " n"]) -> None:
        """Stop the rotors of one vehicle, or of several, in whatever state they are."""
        chosen = [which] if isinstance(which, int) else np.flatnonzero(which).tolist()
        for index in chosen:
            self._fleet.client(index).disarm(is_forced=True)


class _Seat:
    """One vehicle with its autopilot and our companion, from the ground on."""

    def __init__(
        self, world: World, cfg: TestbenchCfg, instance: int, seed: int, wind: WindCfg
    ) -> None:
        scene = world.scene
        frame = LocalFrame(Geodetic(scene.latitude_deg, scene.longitude_deg, scene.altitude_m))
        self._cfg = replace(
            cfg,
            seed=seed,
            instance=instance,
            wind=wind.speed_mps,
            wind_from=wind.from_deg,
            turbulence=str(wind.turbulence_mps),
        )
        self.plant = Plant(world, self._cfg.plant_cfg)
        self._vehicle = Vehicle(
            self.plant,
            frame,
            self._cfg,
            has_network=False,
            links=(),
            captures=None,
            has_video=False,
        )
        self.client = self._vehicle.connect()
        self._simulator = Simulator(
            self.plant, self._vehicle.controller, self._vehicle.server, speed="max"
        )

    def tick(self) -> None:
        """Advance by 20 ms.

        Raises:
            AutopilotError: If the flight stack is lost.
        """
        if self._vehicle.external is not None:
            while not self._vehicle.server.wait_for_tick(0.05):
                pass
        self._simulator.step()
        self.client.update(self.plant.time_us)
        if fault := self._vehicle.stack.fault:
            raise AutopilotError(f"the flight was ended by {fault}")

    def take_off(self) -> None:
        """Arm in offboard mode, or as the flight stack wants it, and rise.

        Raises:
            AutopilotError: If it is not in the air within a minute of simulated time.
        """
        client = self.client
        is_ours = self._vehicle.external is None
        client.request_streams(is_quiet=is_ours)
        telemetry = client.telemetry
        self._tick_until(lambda: self._is_ready(is_ours=is_ours), "is not ready to fly")
        ground_m = self._up_m
        is_stream = not client.habits.takes_off_by_itself
        due_us = self.plant.time_us + round(_STREAM_S * 1e6)
        end_us = self.plant.time_us + round(_LONGEST_S * 1e6)
        while self._up_m - ground_m < _LIFT_M:
            if self.plant.time_us > end_us:
                texts = "; ".join(text for _, text in telemetry.texts[-3:])
                raise AutopilotError(
                    f"the vehicle does not take off: {texts or 'it does not say why'}"
                )
            if is_stream:
                client.send_velocity((0.0, 0.0, _LIFT_MPS), 0.0)
            if self.plant.time_us >= due_us:
                due_us += round(_RETRY_S * 1e6)
                if telemetry.custom_mode != client.habits.offboard:
                    client.set_mode(client.habits.offboard)
                client.arm()
                if not is_stream:
                    client.take_off(_LIFT_M + 0.2)
            self.tick()

    def come_to(self, position_enu_m: Vector3, quat_wxyz: Quaternion) -> None:
        """Come to a start, where the vehicle is then about at rest.

        Ours is put there within no time. The estimator of another stack would take a leap for a
        fault, so that one flies there.
        """
        if self._vehicle.external is None:
            self.client.send_velocity((0.0, 0.0, 0.0), 0.0)
            self._ticks(2)
            self.plant.put(position_enu_m, quat_wxyz)
            self._ticks(round(_SETTLE_S * _LOOP_HZ), (0.0, 0.0, 0.0))
            return
        goal = np.array(position_enu_m)

        def is_there() -> bool:
            self.client.send_position(position_enu_m, 0.0)
            away = goal - self.client.telemetry.position_enu_m
            return bool(np.linalg.norm(away) < _WITHIN_M)

        self._tick_until(is_there, "does not come to the start")

    def close(self) -> None:
        """End the flight stack."""
        self._vehicle.close()

    @property
    def _up_m(self) -> float:
        return self.plant.truth.position_enu_m[2]

    def _is_ready(self, *, is_ours: bool) -> bool:
        telemetry = self.client.telemetry
        if is_ours:
            return self.plant.is_aligned and telemetry.local_origin_enu_m is not None
        return telemetry.has_state and telemetry.is_armable and telemetry.is_navigating

    def _tick_until(self, is_done: Callable[[], bool], fault: str) -> None:
        for _ in range(round(_LONGEST_S * _LOOP_HZ)):
            if is_done():
                return
            self.tick()
        raise AutopilotError(f"the vehicle {fault} within {_LONGEST_S:g} s of simulated time")

    def _ticks(self, n: int, velocity_enu_mps: Vector3 | None = None) -> None:
        for _ in range(n):
            if velocity_enu_mps is not None:
                self.client.send_velocity(velocity_enu_mps, 0.0)
            self.tick()


def _bench_cfg(cfg: EnvironmentCfg, autopilot: AutopilotCfg) -> TestbenchCfg:
    return TestbenchCfg(
        vehicle=cfg.vehicle,
        speed="max",
        autopilot=autopilot.name,
        autopilot_binary=autopilot.binary,
        # The wind blows from anywhere in each episode: to solve its flow would take seconds.
        without="shelter",
    )


def _check(cfg: EnvironmentCfg) -> None:
    check_offboard(cfg.action)
    if cfg.action_hz > _LOOP_HZ:
        raise EnvironmentInputError(
            f"action_hz = {cfg.action_hz}: an autopilot takes setpoints up to {_LOOP_HZ} times a "
            "second; 50, 25, 10, 5 are valid"
        )
    for name in ("mass", "rotors"):
        if value := getattr(cfg.randomisation, name):
            raise EnvironmentInputError(
                f"randomisation.{name} = {value:g}: a vehicle of an autopilot is as its airframe "
                "says; 0 is valid"
            )
