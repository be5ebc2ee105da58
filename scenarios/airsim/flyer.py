"""Flies one vehicle as AirSim's calls ask, by MAVLink as any companion computer does.

A task is a generator: it advances by one tick at each step, and what it returns is the answer of
the call. One task runs at a time. The next one, or cancelLastTask, ends it with False. Between
tasks the vehicle holds its position, as long as API control is on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator

import numpy as np

from autonomy.rotation import yaw_from_quat
from autonomy.types import ZERO3, Quaternion, Vector3
from flightsim.autopilot.reports import FlightReports
from flightsim.mavlink.client import Command, MavlinkClient
from flightsim.mavlink.client.telemetry import LANDED_ON_GROUND
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.plant.relocation import PlaceTakenError
from flightsim.testbench import Vehicle
from scenarios.airsim.guidance import Facing, Guidance
from scenarios.airsim.messages import RCData
from scenarios.airsim.methods import Later, RpcError

Task = Generator[None, None, bool]
Sender = Callable[[MavlinkClient], None]

_RETRY_US = 200_000
_LONGEST_ARMING_US = 15_000_000
"""A vehicle that has just been switched on needs some seconds until it may be armed."""
_LONGEST_ENGAGING_US = 5_000_000
_FORCE = 21196.0
"""Parameter of MAVLink's arm and disarm that skips the checks."""


class Flyer:
    """The calls of one vehicle that move it; call `on_tick` after each tick.

    Attributes:
        guidance: Reference that the vehicle follows while a client controls it.
        is_enabled: Whether a client has taken API control.
        sticks: Sticks of a radio, as a client holds them.
    """

    def __init__(self, vehicle: Vehicle, connect: Callable[[], MavlinkClient] | None) -> None:
        """Prepare; nothing is sent before the first command.

        Args:
            vehicle: The vehicle.
            connect: Connects a companion; None where a pilot of this process flies.
        """
        self._vehicle, self._connect = vehicle, connect
        self._client: MavlinkClient | None = None
        self._task: Task | None = None
        self._answer = Later()
        self._deadline_us = math.inf
        self._arming: tuple[Later, bool, Command, float] | None = None
        self._is_kept_disarmed = False
        """True if a client has disarmed the vehicle, so that no move arms it."""
        self._send: Sender | None = None
        """Sends the setpoint of this tick."""
        self._is_engaged = False
        truth = vehicle.plant.truth
        self._start = (truth.position_enu_m, truth.quat_wxyz)
        self.guidance = Guidance()
        self.is_enabled = False
        self.sticks = RCData()

    # --- connection ---

    @property
    def client(self) -> MavlinkClient:
        """The companion, connected with the first command.

        Raises:
            RpcError: If a pilot of this process flies.
        """
        if self._client is None:
            if self._connect is None:
                raise RpcError("a pilot of this run flies the vehicle; valid: calls that read")
            self._client = self._connect()
            self._client.request_streams()
        return self._client

    @property
    def reports(self) -> FlightReports:
        """Mode, arming and phase of the autopilot."""
        return self._vehicle.stack.reports

    @property
    def now_us(self) -> int:
        """Simulated time."""
        return self._vehicle.plant.time_us

    @property
    def is_landed(self) -> bool:
        """True if the autopilot reports that the vehicle stands on the ground."""
        return self.client.telemetry.landed_state == LANDED_ON_GROUND

    @property
    def is_armed(self) -> bool:
        """True if the vehicle is armed, so that the rotors may turn."""
        return self.reports.is_armed

    @property
    def position_enu_m(self) -> Vector3:
        """Position that the vehicle reports."""
        return self.client.telemetry.position_enu_m

    @property
    def speed_mps(self) -> float:
        """Speed that the vehicle reports."""
        return math.hypot(*self.client.telemetry.velocity_enu_mps)

    @property
    def yaw_rad(self) -> float:
        """Heading, counter-clockwise from east."""
        return self.client.telemetry.yaw_rad

    # --- control ---

    def enable(self, *, is_enabled: bool) -> None:
        """Take API control, or give it back; the vehicle then holds by itself."""
        _ = self.client
        self.is_enabled = is_enabled
        if not is_enabled:
            self.cancel()
            self.release()

    def arm(self, *, is_armed: bool) -> Later:
        """Arm or disarm; the answer says whether it worked."""
        if not is_armed:
            self.cancel()
            self.release()
        self._is_kept_disarmed = not is_armed
        later = Later()
        command = self.client.arm() if is_armed else self.client.disarm()
        self._arming = (later, is_armed, command, self.now_us + _LONGEST_ARMING_US)
        return later

    def put(self, position_enu_m: Vector3, quat_wxyz: Quaternion) -> None:
        """Put the vehicle at rest at another pose; it ends its task and holds there.

        Raises:
            RpcError: If the vehicle would be inside of something, or another flight stack flies.
        """
        self._require_own_stack()
        self.cancel()
        try:
            self._vehicle.plant.put(position_enu_m, quat_wxyz)
        except PlaceTakenError as error:
            raise RpcError(f"{error}; valid: a free place") from None
        if self._client is not None and self.is_armed:
            estimate = self._vehicle.plant.estimate
            yaw_rad = float(yaw_from_quat(np.array(estimate.quat_wxyz)))
            self.guidance.reset(estimate.position_enu_m, ZERO3, yaw_rad)
            self.guidance.stop()

    def renew(self) -> Later:
        """Stop the rotors, put the vehicle back to its start, and give API control back.

        Raises:
            RpcError: If another flight stack flies.
        """
        self._require_own_stack()
        later = self._begin(self._renewed())
        self.is_enabled, self._is_kept_disarmed = False, False
        return later

    def _renewed(self) -> Task:
        self.release()
        self._is_engaged, self._send = False, None
        if self.is_armed:
            command = self.client.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0, _FORCE)
            yield from self._done(command)
        try:
            self._vehicle.plant.renew(*self._start)
        except PlaceTakenError as error:
            raise RpcError(f"the start is taken: {error}") from None
        end_us = self.now_us + _LONGEST_ENGAGING_US
        while not self.is_landed and self.now_us < end_us:
            yield
        return True

    def _require_own_stack(self) -> None:
        if self._vehicle.external is not None:
            raise RpcError("another flight stack flies, which knows of no jumps; valid: moves")

    def start(self, task: Task, timeout_s: float = math.inf) -> Later:
        """Begin a task in the place of the present one.

        Args:
            task: The task.
            timeout_s: Simulated seconds after which it ends with False.

        Returns:
            The answer of the call.

        Raises:
            RpcError: If no client has taken API control.
        """
        if not self.is_enabled:
            raise RpcError("API control is off; valid: after enableApiControl(True)")
        return self._begin(task, timeout_s)

    def _begin(self, task: Task, timeout_s: float = math.inf) -> Later:
        _ = self.client
        self.cancel()
        self._task, self._answer = task, Later()
        self._deadline_us = self.now_us + 1e6 * timeout_s
        return self._answer

    def cancel(self) -> None:
        """End the present task with False; the vehicle then holds."""
        if self._task is None:
            return
        task, self._task = self._task, None
        task.close()
        self._answer.finish(False)
        if self._is_engaged:
            self.guidance.stop()
            self._send = self._hold

    def release(self) -> None:
        """Send no setpoints any more; in the air the autopilot then holds."""
        was_engaged, self._is_engaged, self._send = self._is_engaged, False, None
        if was_engaged and not self.is_landed and self._mode_is(self.client.habits.offboard):
            self.client.set_mode(self.client.habits.hold)

    # --- for tasks ---

    def engage(self, *, must_fly: bool = True) -> Task:
        """Steps until the vehicle is armed and follows setpoints.

        Args:
            must_fly: Whether to arm it if it is not.

        Raises:
            RpcError: If it cannot be.
        """
        client = self.client
        end_us = self.now_us + _LONGEST_ENGAGING_US + _LONGEST_ARMING_US
        while not (client.telemetry.has_state and client.telemetry.is_navigating):
            self._expect_before(end_us, "the vehicle does not know where it is")
            yield
        if not self._is_engaged:
            telemetry = client.telemetry
            velocity = telemetry.velocity_enu_mps
            self.guidance.reset(telemetry.position_enu_m, velocity, telemetry.yaw_rad)
            self.guidance.stop()
        self._is_engaged, self._send = True, self._hold
        if must_fly and not self.is_armed:
            yield from self._armed()
        offboard = client.habits.offboard
        if not self._mode_is(offboard):
            yield
            yield from self._accepted(lambda: client.set_mode(offboard), "offboard mode")
            while not self._mode_is(offboard):
                self._expect_before(end_us, "the vehicle does not enter offboard mode")
                yield
        return True

    def follow(self, facing: Facing) -> bool:
        """Turn the reference and send it in this tick.

        Returns:
            Whether the vehicle could not follow: the reference is then where the vehicle is, and
            has no goal.
        """
        self.guidance.turn(facing)
        self._send = self._send_reference
        return self._must_wait()

    def point(self, quat_wxyz: Quaternion | None, rates_flu: Vector3, thrust: float) -> None:
        """Send an attitude, or angular rates, in this tick."""
        telemetry = self.client.telemetry
        self.guidance.reset(telemetry.position_enu_m, telemetry.velocity_enu_mps, telemetry.yaw_rad)
        self._send = lambda client: client.send_attitude(quat_wxyz, rates_flu, thrust)

    def hand_over(self, custom_mode: int) -> Task:
        """Steps until the autopilot flies by itself in a mode.

        Raises:
            RpcError: If it refuses.
        """
        client = self.client
        yield from self._accepted(lambda: client.set_mode(custom_mode), "the mode")
        self._is_engaged, self._send = False, None
        return True

    # --- each tick ---

    def on_tick(self) -> None:
        """Read what the vehicle reports, advance the task, send a setpoint."""
        client = self._client
        if client is None:
            return
        client.update(self.now_us)
        self._advance_arming()
        self._advance_task()
        if self._send is not None and client.telemetry.has_state:
            self._send(client)

    def _advance_task(self) -> None:
        if self._task is None:
            return
        if self.now_us >= self._deadline_us:
            self.cancel()
            return
        try:
            next(self._task)
        except StopIteration as end:
            is_reached = bool(end.value)
            self._end_task(lambda answer: answer.finish(is_reached))
        except RpcError as error:
            line = str(error)
            self._end_task(lambda answer: answer.fail(line))

    def _end_task(self, tell: Callable[[Later], None]) -> None:
        self._task = None
        if self._is_engaged:
            self.guidance.stop()
            self._send = self._hold
        tell(self._answer)

    def _advance_arming(self) -> None:
        if self._arming is None:
            return
        later, is_wanted, command, end_us = self._arming
        if self.is_armed == is_wanted:
            later.finish(True)
        elif command.is_done and not command.is_accepted:
            # In the air it stays as it is; on the ground the checks may pass later.
            if not is_wanted or self.now_us >= end_us:
                later.finish(False)
            elif self.now_us - command.due_us > _RETRY_US:
                self._arming = (later, is_wanted, self.client.arm(), end_us)
        if later.is_done:
            self._arming = None

    def _hold(self, client: MavlinkClient) -> None:
        self.guidance.step_path()
        self.guidance.turn(Facing())
        if self._must_wait():
            self.guidance.stop()
        self._send_reference(client)

    def _must_wait(self) -> bool:
        telemetry = self.client.telemetry
        return self.guidance.wait_for(telemetry.position_enu_m, telemetry.velocity_enu_mps)

    def _send_reference(self, client: MavlinkClient) -> None:
        client.send_setpoint(self.guidance.reference)

    def _armed(self) -> Task:
        if self._is_kept_disarmed:
            raise RpcError("the vehicle is disarmed; valid: after armDisarm(True)")
        yield from self._accepted(self.client.arm, "arming", _LONGEST_ARMING_US)
        while not self.is_armed:
            yield
        return True

    def _accepted(
        self, ask: Callable[[], Command], what: str, longest_us: int = _LONGEST_ENGAGING_US
    ) -> Task:
        """Steps until a command is accepted, which is repeated for a while."""
        end_us = self.now_us + longest_us
        while True:
            command = ask()
            yield from self._done(command)
            if command.is_accepted:
                return True
            self._expect_before(end_us, f"{what} is refused: {command.outcome()}")
            again_us = self.now_us + _RETRY_US
            while self.now_us < again_us:
                yield

    def _done(self, command: Command) -> Task:
        while not command.is_done:
            yield
        return command.is_accepted

    def _expect_before(self, end_us: float, line: str) -> None:
        if self.now_us >= end_us:
            raise RpcError(line)

    def _mode_is(self, custom_mode: int) -> bool:
        return self.client.telemetry.custom_mode == custom_mode
