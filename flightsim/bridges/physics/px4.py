"""PX4's simulator MAVLink: sensors and truth by TCP, motor outputs back, a step at a time.

PX4 connects to us, and its clock is the time in HIL_SENSOR. It answers each HIL_SENSOR with its
outputs, and the next one waits for them, which keeps both in step. Until its outputs run, a second
or two after its start, no answer comes; time then passes at the pace of the wall clock, since PX4
needs passing time to start.
"""

from __future__ import annotations

import contextlib
import math
import selectors
import socket
import time
from collections.abc import Sequence
from typing import Any

from flightsim.bridges.physics.bridge import BridgeError, Exchanges, MotorOutputs
from flightsim.bridges.physics.px4_messages import SensorMessages
from flightsim.frames import LocalFrame
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.mavlink.dialect import layout
from flightsim.plant import Plant

PORT = 4560  # PX4's own; instance i adds i
_ANSWER = layout("HIL_ACTUATOR_CONTROLS", "time_usec", "flags", "controls", "mode")
_CHUNK_BYTES = 1 << 16
_LOCKSTEP_FLAG = 1
_FREE_TICK_S = 0.004  # a tick at 250 Hz, of wall time, while PX4 starts
_OFF: MotorOutputs = (0.0, 0.0, 0.0, 0.0)


class Px4Bridge:
    """Simulator for one PX4; while it answers, a second connection is refused.

    It is a `Bridge`. A PX4 that connects again after it was lost has begun anew, and goes on in the
    same run.
    """

    def __init__(self, instance: int, frame: LocalFrame) -> None:
        """Listen on the port of an instance.

        Args:
            instance: Number from 0; each has its own port.
            frame: Local frame of the scene, by which positions become latitudes and longitudes.

        Raises:
            BridgeError: If the port is taken.
        """
        port = PORT + instance
        self.address = f"TCP 127.0.0.1:{port}"
        self.notices: list[str] = []
        self.n_restarts = 0
        self.exchanges = Exchanges()
        self._listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._listener.bind(("127.0.0.1", port))
        except OSError as error:
            self._listener.close()
            raise BridgeError(
                f"TCP port {port} for PX4's simulator is taken; valid: another --instance"
            ) from error
        self._listener.listen(1)
        self._listener.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._socket: socket.socket | None = None
        self._messages = SensorMessages(frame)
        self._parser = mavlink.MAVLink(None)
        self._has_outputs = False
        """True if PX4 has answered a step since it connected."""
        self._outputs: MotorOutputs | None = None
        self._told_us = 0  # time in the last HIL_SENSOR
        self._told: set[str] = set()  # notices made so far

    def connect(self, timeout_s: float) -> bool:
        """Return True if PX4 is connected; wait for it at most this wall time."""
        if self._socket is None and self._selector.select(timeout_s):
            self._accept()
        return self._socket is not None

    def send_state(self, plant: Plant) -> None:
        """Send the sensors' samples and the truth of this tick."""
        self._outputs = None
        data, self._told_us = self._messages.frames(plant)
        self._send(data)
        self.exchanges.told += 1

    def receive(self, timeout_s: float) -> MotorOutputs | None:
        """Return the outputs that answer the last samples.

        Args:
            timeout_s: Longest wait of wall time, once PX4 answers; before that it is one tick.

        Returns:
            The outputs; all off while PX4 starts, and None if it is silent or gone.
        """
        limit_s = timeout_s if self._has_outputs else _FREE_TICK_S
        deadline_s = time.monotonic() + limit_s
        while self._outputs is None:
            left_s = deadline_s - time.monotonic()
            if left_s <= 0.0:
                is_starting = self._socket is not None and not self._has_outputs
                self.exchanges.unanswered += is_starting
                return _OFF if is_starting else None
            for key, _ in self._selector.select(left_s):
                if key.fileobj is self._listener:
                    # A PX4 that was started anew connects again in the middle of a run.
                    self._accept()
                else:
                    self._read()
        self.exchanges.answered += 1
        return self._outputs

    def close(self) -> None:
        """Release the port."""
        self._drop()
        self._selector.close()
        self._listener.close()

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:
            return
        if self._has_outputs:
            self._read()  # It may be gone, and that not read yet.
        if self._has_outputs:
            client.close()
            self._add_notice(
                f"{self.address}: a second connection is refused while PX4 answers; valid: one PX4 "
                "an --instance"
            )
            return
        if self._socket is not None or self._told_us:
            self.n_restarts += 1
            self.notices.append(f"PX4 has begun anew at {self.address}")
        self._drop()
        # A small frame must not wait for the next one to fill a packet.
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.setblocking(False)
        self._socket = client
        self._selector.register(client, selectors.EVENT_READ)
        self._parser = mavlink.MAVLink(None)
        self._parser.robust_parsing = True

    def _drop(self) -> None:
        """Forget the connection, which has ended or is replaced."""
        if self._socket is not None:
            self._selector.unregister(self._socket)
            self._socket.close()
        self._socket, self._has_outputs = None, False

    def _send(self, data: bytes) -> None:
        # A connection that has broken is noticed by reading.
        with contextlib.suppress(OSError):
            if self._socket is not None:
                self._socket.sendall(data)

    def _read(self) -> None:
        assert self._socket is not None
        try:
            data = self._socket.recv(_CHUNK_BYTES)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if not data:
            self._drop()
            return
        # Nearly always it is one whole answer, which the parser would take 14 us for, not 2.
        payload = None if self._parser.buf_len() else _ANSWER.payload_v2(data)
        if payload is not None:
            time_us, flags, *controls, mode = _ANSWER.unpack(payload)
            self._take(time_us, flags, controls, mode)
            return
        messages: list[Any] = self._parser.parse_buffer(data) or []
        for message in messages:
            if message.get_type() == _ANSWER.name:
                self._take(message.time_usec, message.flags, message.controls, message.mode)
            elif message.get_type() == "BAD_DATA":
                self._add_notice(
                    f"{self.address}: bytes that are no MAVLink are ignored; valid: the simulator "
                    "link of PX4 1.12 and later"
                )

    def _take(self, time_us: int, flags: int, controls: Sequence[float], mode: int) -> None:
        if not flags & _LOCKSTEP_FLAG:
            self._add_notice(
                f"{self.address}: PX4 runs without lockstep (flags {flags}), so that its "
                "flights do not repeat; valid: a build for simulation with lockstep"
            )
        elif self._has_outputs and (time_us < self._told_us or self._outputs):
            # An answer to an earlier step, or a second one, must not count for this step.
            self.exchanges.repeated += 1
            return  # It answers a step that has been made, or that is answered.
        elif time_us > self._told_us:
            self.exchanges.left_out += 1
        self._has_outputs = True
        is_armed = mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
        # Channels without a motor are NaN.
        a, b, c, d = (c if math.isfinite(c) else 0.0 for c in controls[:4])
        self._outputs = (a, b, c, d) if is_armed else _OFF

    def _add_notice(self, line: str) -> None:
        """Add a notice, the first time that it occurs."""
        if line not in self._told:
            self._told.add(line)
            self.notices.append(line)
