"""SERIAL_CONTROL: a part of PX4's shell over MAVLink."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send
from flightsim.mavlink.shell_commands import ShellCommands
from flightsim.mavlink.view import VehicleView

_PROMPT = "nsh> "
_NO_SHELL = "This vehicle has no shell.\n"
_CHUNK_BYTES = 70  # size of the data field of SERIAL_CONTROL
_CHUNKS_PER_TICK = 8
# Bounds on what a partner can make the vehicle keep and execute.
_LONGEST_LINE_BYTES = 256
_LINES_PER_MESSAGE = 4


class ShellService:
    """Collects each partner's line, and sends the output piece by piece."""

    def __init__(self, view: VehicleView, *, has_shell: bool) -> None:
        """Serve a shell.

        Args:
            view: The vehicle.
            has_shell: False answers that this vehicle has none.
        """
        self._commands = ShellCommands(view) if has_shell else None
        self._typed: dict[Channel, bytes] = {}
        self._printed: dict[Channel, bytes] = {}
        self.handlers: Mapping[str, Handler] = {"SERIAL_CONTROL": self._on_serial}

    @property
    def busy(self) -> Collection[Channel]:
        """Partners with output that is still to be sent."""
        return self._printed

    def update(self, channel: Channel) -> None:
        """Send the next pieces of a partner's output, at most 8."""
        for _ in range(_CHUNKS_PER_TICK):
            left = self._printed.pop(channel, b"")
            if not left:
                return
            self._send(channel, mav.SERIAL_CONTROL_DEV_SHELL, left[:_CHUNK_BYTES])
            if len(left) > _CHUNK_BYTES:
                self._printed[channel] = left[_CHUNK_BYTES:]

    def forget(self, channel: Channel) -> None:
        """Drop line and output of a partner that left."""
        self._typed.pop(channel, None)
        self._printed.pop(channel, None)

    def _on_serial(self, channel: Channel, message: Message) -> None:
        if message.flags & mav.SERIAL_CONTROL_FLAG_REPLY or not message.count:
            return  # an answer of another system, or a question for more of one
        if self._commands is None or message.device != mav.SERIAL_CONTROL_DEV_SHELL:
            self._send(channel, message.device, _NO_SHELL.encode())
            return
        data = bytes(message.data[: min(message.count, _CHUNK_BYTES)])
        *lines, rest = (self._typed.get(channel, b"") + data).split(b"\n")
        self._typed[channel] = rest[:_LONGEST_LINE_BYTES]
        if self._printed.get(channel):
            return  # lines typed while much is printed are not read
        output = ""
        for line in lines[:_LINES_PER_MESSAGE]:
            printed = self._commands.run(line.decode("ascii", "replace"))
            output += f"{printed}\n{_PROMPT}" if printed else _PROMPT
        if output:
            self._printed[channel] = output.encode("ascii", "replace")

    def _send(self, channel: Channel, device: int, data: bytes) -> None:
        send(
            channel,
            "SERIAL_CONTROL",
            device=device,
            flags=mav.SERIAL_CONTROL_FLAG_REPLY,
            count=len(data),
            data=data,
        )
