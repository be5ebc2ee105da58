"""External flight stack that flies a plant: its bridge, process and monitor together.

The stack takes the place of our autopilot: `Plant.hand_over` lets it command the rotors at every
control tick, and time stands still until it has answered. It may be a binary that we start, or one
that the user starts. A stack that ends or falls silent has a `fault`, which cuts the motors and
ends the run, instead of an exception in the middle of a tick.
"""

from __future__ import annotations

import math
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from autonomy.types import yaw_of
from flightsim.autopilot.events import Severity
from flightsim.bridges.launch import ardupilot, px4
from flightsim.bridges.launch.launch import Launch, Start
from flightsim.bridges.launch.process import StackProcess
from flightsim.bridges.monitor import Monitor
from flightsim.bridges.motors import MotorMap
from flightsim.bridges.physics.ardupilot import ArduPilotBridge
from flightsim.bridges.physics.bridge import Bridge, BridgeError, Exchanges
from flightsim.bridges.physics.px4 import Px4Bridge
from flightsim.bridges.pipes import Tap, TcpWire, UdpWire, Wire
from flightsim.environment.rooms import indoor_rooms, is_in_room
from flightsim.frames import LocalFrame
from flightsim.mavlink.client import ARDUPILOT_HABITS, REAL_PX4_HABITS, Habits
from flightsim.mavlink.personalities import PERSONALITIES
from flightsim.plant import Plant
from flightsim.vehicles import Airframe

SILENCE_S = 10.0
"""Wall time of silence after which a stack has ended the run."""
_N_MOTORS = 4
_START_S = 60.0
"""Wall time within which a binary that we start must have found the physics."""
_LOOK_S = 0.05  # between two looks at the process, while waiting


@dataclass(frozen=True, kw_only=True, slots=True)
class StackKind:
    """Facts about a flight stack that we have a bridge for."""

    title: str
    program: str
    """Usual name of its binary, for the start line."""
    rate_hz: int
    """Exchanges per simulated second."""
    bridge: Callable[[int, LocalFrame], Bridge]
    launch: Callable[[Airframe, Start, int, Path, Path | None], Launch]
    wire: Callable[[int], Wire]
    """Connection for our monitor and pilot, by the number of the instance."""
    clients: Callable[[int], str]
    """Line that says where clients find it, by the number of the instance."""
    habits: Habits
    """Peculiarities that a client must know."""
    takes_odometry: bool
    """True if it flies by our odometry where there are no satellites."""


STACKS = MappingProxyType(
    {
        "ardupilot": StackKind(
            title="ArduPilot",
            program="arducopter",
            rate_hz=500,
            bridge=lambda instance, _: ArduPilotBridge(instance),
            launch=ardupilot.launch,
            wire=lambda instance: TcpWire(5763 + 10 * instance),
            clients=ardupilot.clients,
            habits=ARDUPILOT_HABITS,
            takes_odometry=False,
        ),
        "px4": StackKind(
            title="PX4",
            program="px4",
            rate_hz=250,
            bridge=Px4Bridge,
            launch=px4.launch,
            wire=lambda instance: UdpWire(px4.OUR_PORT + instance, px4.STACK_PORT + instance),
            clients=px4.clients,
            habits=REAL_PX4_HABITS,
            takes_odometry=True,
        ),
    }
)
"""Kinds by their names on the command line."""


class ExternalStack:
    """Flight stack that flies a plant in lockstep: one exchange before every control tick.

    Attributes:
        monitor: Client that reads the stack's own reports.
        start_line: Command line that starts the stack, for a user who does that.
        fault: Words that say why the run has ended; empty while it goes on.
    """

    def __init__(
        self,
        name: str,
        plant: Plant,
        frame: LocalFrame,
        *,
        instance: int = 0,
        binary: Path | None = None,
    ) -> None:
        """Open the ports, and start the binary if there is one.

        Args:
            name: One of `STACKS`.
            plant: Vehicle at rest, which is handed over.
            frame: Local frame of the scene.
            instance: Number that shifts all ports.
            binary: Program of the stack; None waits for one that the user starts.

        Raises:
            BridgeError: If the vehicle is no quadrotor, a port is taken, or the binary cannot be
                started.
        """
        self.kind, self._plant = STACKS[name], plant
        airframe = plant.world.airframe
        n_rotors = len(airframe.quadrotor.rotors)
        if n_rotors != _N_MOTORS:
            raise BridgeError(
                f"vehicle {airframe.name!r} has {n_rotors} rotors, and {self.kind.title} flies "
                f"vehicles of {_N_MOTORS} here; valid: --vehicle iris or hummingbird"
            )
        self.fault = ""
        self._process: StackProcess | None = None
        self._bridge = self.kind.bridge(instance, frame)
        self._motors = MotorMap(airframe)
        # From here on the plant asks `_drive` for the rotors before every tick.
        self._handover = plant.hand_over(self._drive)
        start = _start(plant, frame)
        self.monitor = Monitor(
            self.kind.wire(instance),
            plant,
            frame,
            names=PERSONALITIES[name],
            habits=self.kind.habits,
            origin=start.place if self.kind.takes_odometry and start.is_by_odometry else None,
        )
        self._folder = Path(tempfile.mkdtemp(prefix=f"aeroscene-{name}-"))
        self._is_connected = False
        try:
            launch = self.kind.launch(airframe, start, instance, self._folder, binary)
            self.start_line = launch.line(self.kind.program)
            if binary is not None:
                self._process = StackProcess(self.kind.title, binary, launch, self._folder)
        # An interrupt too must not leave ports and a folder behind.
        except BaseException:
            self.close()
            raise
        self._deadline_s = time.monotonic() + _START_S

    @property
    def address(self) -> str:
        """Words that say where the stack finds the physics."""
        return self._bridge.address

    @property
    def exchanges(self) -> Exchanges:
        """Counts of what has passed between the stack and the physics."""
        return self._bridge.exchanges

    @property
    def habits(self) -> Habits:
        """Peculiarities of the stack that a client must know."""
        return self.kind.habits

    @property
    def reports(self) -> Monitor:
        """Source of the mode and the arming that are shown and recorded."""
        return self.monitor

    def pipe(self) -> Tap:
        """Return a MAVLink connection for a companion inside this process."""
        return self.monitor.tap()

    def listen(self, listener: Callable[[Severity, str], None]) -> None:
        """Call a function with the severity and the text of each message, the stack's and ours."""
        self.monitor.listeners.append(listener)

    def wait_for_tick(self, timeout_s: float) -> bool:
        """Return True if time may pass; wait a moment for the stack to be there.

        It is True after a fault too, so that the caller's loop goes on and sees the fault.

        Args:
            timeout_s: Longest wait, of wall time.
        """
        if self.fault or self._is_connected:
            return True
        self._is_connected = self._bridge.connect(timeout_s)
        self._log_notices()
        # Only a binary of ours has to come in time; a user may start theirs later.
        if not self._is_connected and self._process is not None:
            self.fault = self._process.fault()
            if not self.fault and time.monotonic() > self._deadline_s:
                self.fault = (
                    f"{self.kind.title}'s absence: it has not come to {self.address} "
                    f"within {_START_S:.0f} s"
                )
        return self._is_connected or bool(self.fault)

    def update(self) -> None:
        """Take over the stack's estimate, and pass on its and our messages."""
        if (estimate := self.monitor.estimate) is not None:
            self._handover.take_estimate(estimate)
        self._log_notices()

    def _drive(self) -> None:
        """Send the state, and command the rotors by the answer; no power once the stack is lost."""
        if self.fault:
            self._handover.command_rotors(None)
            return
        self._bridge.send_state(self._plant)
        outputs = self._bridge.receive(_LOOK_S)
        # Nearly every answer comes at once; the process is looked at only when one is late.
        if outputs is None:
            deadline_s = time.monotonic() + SILENCE_S
            while outputs is None and not self.fault:
                outputs = self._bridge.receive(_LOOK_S)
                self._look_for_fault(deadline_s)
        self._handover.command_rotors(outputs and self._motors.rotor_speeds_radps(outputs))

    def _look_for_fault(self, deadline_s: float) -> None:
        if self._process is not None:
            self.fault = self._process.fault()
        if not self.fault and time.monotonic() > deadline_s:
            self.fault = (
                f"{self.kind.title}'s silence of {SILENCE_S:.0f} s "
                f"at t = {self._plant.time_us * 1e-6:.2f} s"
            )

    def _log_notices(self) -> None:
        while self._bridge.notices:
            line = self._bridge.notices.pop(0)
            for listener in self.monitor.listeners:
                listener(Severity.WARNING, line)

    def close(self) -> None:
        """End the binary, release the ports, and remove its folder."""
        if self._process is not None:
            self._process.close()
        self.monitor.close()
        self._bridge.close()
        shutil.rmtree(self._folder, ignore_errors=True)


def _start(plant: Plant, frame: LocalFrame) -> Start:
    truth = plant.truth
    # A heading is clockwise from north, a yaw counter-clockwise from east.
    heading_deg = 90.0 - math.degrees(yaw_of(truth.quat_wxyz))
    return Start(
        place=frame.geodetic_from_enu(truth.position_enu_m),
        heading_deg=heading_deg % 360.0,
        sensors=plant.cfg,
        is_in_room=bool(
            is_in_room(indoor_rooms(plant.world.scene), np.array(truth.position_enu_m))
        ),
    )
