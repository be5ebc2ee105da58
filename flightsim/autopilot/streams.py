"""Continuous input from clients: offboard setpoints, sticks, a target to follow and heartbeats.

Each stream keeps its latest value and its age in simulated time, so that silence can be detected
and runs repeat at any speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign

from autonomy.types import ZERO3, Setpoint, Vector3
from flightsim.autopilot.parameters import Parameters

OFFBOARD_ENTRY_GAP_US = 500_000
"""Longest gap between setpoints for entering offboard mode: they must exceed 2 Hz."""


TARGET_TIMEOUT_US = 3_000_000
"""Time after which a target that reports nothing is no longer followed, as in PX4."""


class OffboardStream:
    """The latest offboard setpoint and its age."""

    def __init__(self) -> None:
        self.setpoint: Setpoint | None = None
        self._received_us = 0

    def receive(self, setpoint: Setpoint, time_us: int) -> None:
        """Accept a setpoint received at a simulated time."""
        self.setpoint = setpoint
        self._received_us = time_us

    def is_alive(self, time_us: int, limit_us: float = OFFBOARD_ENTRY_GAP_US) -> bool:
        """Return true if the latest setpoint is at most `limit_us` old."""
        return self.setpoint is not None and time_us - self._received_us <= limit_us


@dataclass(frozen=True, kw_only=True, slots=True)
class Sticks:
    """Stick positions: forward, right and clockwise positive, -1 to 1; throttle 0 to 1."""

    pitch: float = 0.0
    roll: float = 0.0
    throttle: float = 0.5
    yaw: float = 0.0

    @classmethod
    def limited(cls, *, pitch: float, roll: float, throttle: float, yaw: float) -> Sticks:
        """Return stick positions with each value moved into its range.

        Args:
            pitch: Forwards positive, -1 to 1.
            roll: To the right positive, -1 to 1.
            throttle: 0 to 1, with the middle at 0.5.
            yaw: Clockwise positive, -1 to 1.
        """
        return cls(
            pitch=min(max(pitch, -1.0), 1.0),
            roll=min(max(roll, -1.0), 1.0),
            throttle=min(max(throttle, 0.0), 1.0),
            yaw=min(max(yaw, -1.0), 1.0),
        )


CENTRED = Sticks()


class StickStream:
    """The latest stick positions and their age."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._sticks = CENTRED
        self._received_us: int | None = None
        self.is_heard = True
        """True if anything is received at all; false is an injected loss of the sticks' signal."""

    def receive(self, sticks: Sticks, time_us: int) -> None:
        """Accept stick positions, unless COM_RC_IN_MODE disables sticks or their signal is lost.

        Args:
            sticks: Positions of the sticks.
            time_us: Simulated time at which they came.
        """
        if self.is_heard and self._parameters["COM_RC_IN_MODE"] != 4:  # 4: stick input disabled
            self._sticks = sticks
            self._received_us = time_us

    @property
    def timeout_us(self) -> float:
        """Silence after which sticks count as lost, microseconds."""
        return 1e6 * max(self._parameters["COM_RC_LOSS_T"], 0.1)

    def is_alive(self, time_us: int) -> bool:
        """Return true if the latest stick positions are not too old."""
        return self._received_us is not None and time_us - self._received_us <= self.timeout_us

    def current(self, time_us: int) -> Sticks:
        """Return the present stick positions; centred while none are received."""
        return self._sticks if self.is_alive(time_us) else CENTRED

    def is_moved(self, time_us: int) -> bool:
        """Return true if a stick is deflected by more than COM_RC_STICK_OV percent."""
        if not self.is_alive(time_us):
            return False
        sticks, limit = self._sticks, 0.01 * self._parameters["COM_RC_STICK_OV"]
        # The throttle does not count: it rests anywhere, not in its middle.
        return max(abs(sticks.pitch), abs(sticks.roll), abs(sticks.yaw)) > limit


def with_dead_zone(deflection: float, dead_zone: float) -> float:
    """Return a deflection with a dead zone in the middle and full travel at the ends, -1 to 1.

    Args:
        deflection: Stick position, -1 to 1.
        dead_zone: Half width of the zone that yields 0, below 1.
    """
    if abs(deflection) <= dead_zone:
        return 0.0
    return copysign((abs(deflection) - dead_zone) / (1.0 - dead_zone), deflection)


class TargetStream:
    """The latest report of a target's position, as for follow mode or a precision landing."""

    def __init__(self) -> None:
        self.velocity_enu_mps: Vector3 = ZERO3
        self._position_enu_m: Vector3 | None = None
        self._received_us = 0

    def receive(self, position_enu_m: Vector3, velocity_enu_mps: Vector3, time_us: int) -> None:
        """Accept a report of position and velocity at a simulated time."""
        self._position_enu_m = position_enu_m
        self.velocity_enu_mps = velocity_enu_mps
        self._received_us = time_us

    @property
    def latest_enu_m(self) -> Vector3 | None:
        """Position of the target in the latest report, however old; None without any."""
        return self._position_enu_m

    def at(self, time_us: int) -> Vector3 | None:
        """Return the position of the target at a time, extrapolated by its velocity.

        Returns:
            None if nothing was reported within the last 3 s.
        """
        age_us = time_us - self._received_us
        if self._position_enu_m is None or age_us > TARGET_TIMEOUT_US:
            return None
        x, y, z = self._position_enu_m
        vx, vy, vz = self.velocity_enu_mps
        age_s = 1e-6 * age_us
        return (x + vx * age_s, y + vy * age_s, z + vz * age_s)


class DatalinkWatch:
    """Time when a ground station was last heard."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._heard_us: int | None = None
        self.is_heard = True
        """True if heartbeats are received at all; false is an injected loss of the link."""

    def receive(self, time_us: int) -> None:
        """Accept a heartbeat received at a simulated time."""
        if self.is_heard:
            self._heard_us = time_us

    def is_lost(self, time_us: int) -> bool:
        """Return true if ground stations were present and have been silent for COM_DL_LOSS_T."""
        # A flight without any ground station has no link to lose.
        if self._heard_us is None:
            return False
        return time_us - self._heard_us > 1e6 * self._parameters["COM_DL_LOSS_T"]
