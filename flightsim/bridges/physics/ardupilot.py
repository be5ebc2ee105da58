"""ArduPilot's JSON physics: a request by UDP for every step, a line of JSON for an answer.

ArduPilot leads: it sends pulse widths and a count of its steps, and waits for the state after the
step. If no answer comes, it repeats the request with the same count, which must not make a step of
its own. It makes its barometer, magnetometer and receiver from the true state; the IMU and the
rangefinder are ours. The layouts are those of ArduPilot's SIM_JSON example.
"""

from __future__ import annotations

import math
import selectors
import socket
import struct

from autonomy.types import Vector3
from flightsim.bridges.physics.bridge import BridgeError, Exchanges, MotorOutputs
from flightsim.frames import swap_enu_ned, swap_flu_frd, swap_quat_enu_flu_ned_frd
from flightsim.plant import Plant

PORT = 9002  # ArduPilot's own; instance i adds ten times i
PORT_STEP = 10
_REQUESTS = {
    layout.size: (magic, layout)
    for magic, layout in (
        (18458, struct.Struct("<HHI16H")),
        (29569, struct.Struct("<HHI32H")),
    )
}
"""Magic number and layout (magic, rate, count, pulse widths) of a request, by its size in bytes: 16
channels or 32."""
_PULSE_LOW_US, _PULSE_SPAN_US = 1000.0, 1000.0  # 1000 us is off, 2000 us full
_DATAGRAM_BYTES = 2048
_BEYOND_REACH_M = 1000.0
"""Range that stands for none, far beyond what the rangefinder measures."""
_CLOCK_S_PER_US = 1e-6 * (1.0 + 1e-9)
"""Seconds in a microsecond, a trace too many: ArduPilot cuts the difference of two times to whole
microseconds, and rounding must not leave one just short."""
_RESTART_FRAMES = 2
"""A count below this, after a greater one, means that the flight stack has begun anew."""
# The reader searches for substrings, so no key may contain another one.
_STATE = (
    '\n{"timestamp":%.15f,"imu":{"gyro":[%.9f,%.9f,%.9f],"accel_body":[%.9f,%.9f,%.9f]},'
    '"position":[%.6f,%.6f,%.6f],"velocity":[%.6f,%.6f,%.6f],"quaternion":[%.9f,%.9f,%.9f,%.9f],'
    '"rng_1":%.3f,"battery":{"voltage":%.3f,"current":%.3f}}\n'
)


class ArduPilotBridge:
    """Physics server for one ArduPilot; it answers the latest sender.

    It is a `Bridge`. An ArduPilot that begins anew is known by its count, which starts again.
    """

    def __init__(self, instance: int) -> None:
        """Listen on the port of an instance.

        Args:
            instance: Number from 0; each has its own port, ten apart.

        Raises:
            BridgeError: If the port is taken.
        """
        port = PORT + PORT_STEP * instance
        self.address = f"UDP 127.0.0.1:{port}"
        self.notices: list[str] = []
        self.n_restarts = 0
        self.exchanges = Exchanges()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(("127.0.0.1", port))
        except OSError as error:
            self._socket.close()
            raise BridgeError(
                f"UDP port {port} for ArduPilot's physics is taken; valid: another --instance"
            ) from error
        self._socket.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)
        self._client: tuple[str, int] | None = None
        self._count = -1
        """Count of the last request that was taken; -1 before the first."""
        self._outputs: MotorOutputs | None = None
        """Outputs of a request that has come but not yet been taken."""
        self._is_owed = False
        """True if the last request waits for the state after its step."""
        # Kept for a repeated request, which gets the same answer.
        self._answer = b""
        self._is_noise_told = False
        self._origin_enu_m: Vector3 | None = None  # NED counts from here, the home

    def connect(self, timeout_s: float) -> bool:
        """Wait for the first request; return True if one has come.

        Args:
            timeout_s: Longest wait, of wall time.
        """
        if self._client is None:
            self._outputs = self._outputs or self._await_request(timeout_s)
        return self._client is not None

    def send_state(self, plant: Plant) -> None:
        """Answer the last request, now that its step has been made."""
        if self._origin_enu_m is None:
            self._origin_enu_m = plant.truth.position_enu_m
        if self._is_owed:
            self._answer = _state(plant, self._origin_enu_m)
            self._send()
            self.exchanges.told += 1
            self._is_owed = False

    def receive(self, timeout_s: float) -> MotorOutputs | None:
        """Return the outputs of the next request, which is owed an answer then; else None."""
        outputs = self._outputs or self._await_request(timeout_s)
        self._outputs = None
        self._is_owed = outputs is not None
        self.exchanges.answered += outputs is not None
        return outputs

    def close(self) -> None:
        """Release the port."""
        self._selector.close()
        self._socket.close()

    def _await_request(self, timeout_s: float) -> MotorOutputs | None:
        """Wait for a request for a step that has not been made, and return its outputs.

        Repeated requests are answered from memory, and packets of other layouts are refused, both
        of which return None.
        """
        try:
            data, sender = self._socket.recvfrom(_DATAGRAM_BYTES)
        except OSError:  # nothing there, or an ICMP error left by a partner that is gone
            if not self._selector.select(timeout_s):
                return None
            try:
                data, sender = self._socket.recvfrom(_DATAGRAM_BYTES)
            except OSError:
                return None
        magic, layout = _REQUESTS.get(len(data), (0, None))
        if layout is None or data[:2] != magic.to_bytes(2, "little"):
            self._refuse(data, sender)
            return None
        _, _, count, *pulses = layout.unpack(data)
        self._client = sender
        if count == self._count:
            self.exchanges.repeated += 1
            self._send()  # It has not got the answer, or would not ask again.
            return None
        if count < _RESTART_FRAMES <= self._count:
            self.n_restarts += 1
            self.notices.append(f"ArduPilot has begun anew at {sender[0]}:{sender[1]}")
        # Its clock never runs backwards but at a start, so a gap of either sign is a lost step.
        elif self._count >= 0:
            self.exchanges.left_out += abs(count - self._count - 1)
        self._count = count
        a, b, c, d = ((pulse - _PULSE_LOW_US) / _PULSE_SPAN_US for pulse in pulses[:4])
        return (a, b, c, d)

    def _refuse(self, data: bytes, sender: tuple[str, int]) -> None:
        if self._is_noise_told:
            return
        self._is_noise_told = True
        magic = int.from_bytes(data[:2], "little")
        self.notices.append(
            f"{self.address}: {len(data)} bytes with magic {magic} from {sender[0]}:{sender[1]} "
            "are ignored; valid: 40 with 18458 or 72 with 29569, as ArduPilot 4.1 and later send"
        )

    def _send(self) -> None:
        try:
            if self._client is not None and self._answer:
                self._socket.sendto(self._answer, self._client)
        except OSError:
            return  # It is gone, or will ask again.


def _state(plant: Plant, origin_enu_m: Vector3) -> bytes:
    """Return the present state as ArduPilot reads it: NED from its home, and FRD."""
    truth, imu, battery = plant.truth, plant.sensors.imu, plant.battery
    x, y, z = truth.position_enu_m
    ox, oy, oz = origin_enu_m
    range_m = plant.sensors.range_m
    values = (
        plant.time_us * _CLOCK_S_PER_US,
        *swap_flu_frd(imu.gyro_flu_radps),
        *swap_flu_frd(imu.accel_flu_mps2),
        *swap_enu_ned((x - ox, y - oy, z - oz)),
        *swap_enu_ned(truth.velocity_enu_mps),
        *swap_quat_enu_flu_ned_frd(truth.quat_wxyz),
        range_m if math.isfinite(range_m) else _BEYOND_REACH_M,
        battery.voltage_v,
        battery.current_a,
    )
    return (_STATE % values).encode()
