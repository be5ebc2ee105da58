"""Serial link: one partner on a line, at the line's own pace, as long as the device is there."""

from __future__ import annotations

import contextlib
import logging
import os
import selectors
import termios
import time
import tty
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.links.link import LinkError
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.streams import Profile

_LOG = logging.getLogger(__name__)

_BAUDS = {
    int(name[1:]): getattr(termios, name)
    for name in dir(termios)
    if name[0] == "B" and name[1:].isdigit() and int(name[1:]) >= 9600
}
"""Speeds that this machine knows and at which MAVLink makes sense, with their constants."""
_BITS_PER_BYTE = 10
_READ_BYTES = 16_384
_BURST_S, _HELD_S, _DROPPED_S = 0.04, 0.1, 2.0
"""Times that are turned into bytes by the line's rate: what is written at once, beyond which
streams wait, and beyond which frames are dropped."""
_LEAST_BURST_BYTES = 300
"""The longest frame must fit."""
_REOPEN_S = 1.0  # pause between two attempts to open a device that is gone


@dataclass(frozen=True, kw_only=True)
class SerialLine:
    """A device and its speed in bits per second."""

    path: str
    baud: int = 57_600

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the line of PATH or PATH:BAUD.

        Raises:
            LinkError: If this machine does not know the speed.
        """
        path, _, baud = text.rpartition(":")
        # Paths may contain a colon themselves: only digits behind the last one are a speed.
        if not path or not baud.isdigit():
            return cls(path=text)
        if int(baud) not in _BAUDS:
            valid = ", ".join(map(str, sorted(_BAUDS)))
            raise LinkError(f"serial {text!r}: {baud} baud is unknown; valid: {valid}")
        return cls(path=path, baud=int(baud))

    @property
    def bytes_per_s(self) -> float:
        """Bytes that the line carries in a second: a byte has a start and a stop bit."""
        return self.baud / _BITS_PER_BYTE


class SerialLink:
    """A serial line, with the one partner at its other end.

    Writing never outruns the line, even if a driver would take more: telemetry waits while too much
    is on its way, and comes as often as there is room for it. A device that goes away is opened
    again when it is back.
    """

    def __init__(
        self,
        line: SerialLine,
        *,
        profile: Profile = "normal",
        is_lockstep: bool = False,
        signing: Signing | None = None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare a link.

        Args:
            line: Device and speed.
            profile: Default stream rates.
            is_lockstep: True runs protocol timeouts in simulated time.
            signing: Key and timestamps that all links share; None never signs.
            now_s: Clock of the line, in seconds of wall time.
        """
        self.name = f"serial:{line.path}"
        self._line = line
        self._profile: Profile = profile
        self._is_lockstep = is_lockstep
        self._signing = signing or Signing()
        self._link_id = self._signing.new_link_id()
        self._now_s = self._clock = now_s
        self._selector: selectors.BaseSelector | None = None
        self._device: int | None = None
        self._channel: Channel | None = None
        self._unsent = bytearray()
        self._credit_bytes = 0.0
        self._credited_s = self._tried_s = 0.0

    @property
    def channels(self) -> Sequence[Channel]:
        """The one partner while the device is there; a device that is back is opened first."""
        if self._channel is None and self._now_s() - self._tried_s > _REOPEN_S:
            with contextlib.suppress(LinkError):
                self._open_device()
        return () if self._channel is None else (self._channel,)

    def open(self, selector: selectors.BaseSelector, simulated_us: Callable[[], int]) -> None:
        """Open the device.

        Raises:
            LinkError: If it does not exist, is not accessible, or is no serial line.
        """
        if self._is_lockstep:
            self._clock = lambda: simulated_us() * 1e-6
        self._selector = selector
        self._open_device()

    def close(self) -> None:
        """Close the device."""
        self._leave()
        self._selector = None

    def _open_device(self) -> None:
        if self._selector is None:
            return
        self._tried_s = self._credited_s = self._now_s()
        self._device = open_raw(self._line)
        self._unsent.clear()
        self._credit_bytes = 0.0
        self._channel = Channel(
            self.name,
            self._write,
            profile=self._profile,
            clock=self._clock,
            is_datagram=False,
            signing=self._signing,
            link_id=self._link_id,
        )
        self._selector.register(self._device, selectors.EVENT_READ, self._poll)

    def _leave(self) -> None:
        """Close the device and leave the partner behind it."""
        if self._device is not None and self._selector is not None:
            self._selector.unregister(self._device)
            os.close(self._device)
        if self._channel is not None:
            self._channel.is_open = False
        self._device = self._channel = None

    def _lose(self) -> None:
        _LOG.warning("%s is gone; it is opened again when it is back", self.name)
        self._leave()

    def _poll(self) -> None:
        """Read new bytes, unless the partner has exceeded its budget, and go on writing."""
        assert self._device is not None
        assert self._channel is not None
        if self._channel.has_room:
            try:
                data = os.read(self._device, _READ_BYTES)
            except (BlockingIOError, InterruptedError):
                data = None
            except OSError:
                data = b""  # as at the end of the file: the device is gone
            if data:
                self._channel.receive(data)
            elif data is not None:
                self._lose()
                return
        if self._unsent:
            self._drain()

    def _write(self, frames: Sequence[bytes]) -> None:
        if self._device is None:
            return
        if len(self._unsent) < _DROPPED_S * self._line.bytes_per_s:
            self._unsent += b"".join(frames)
        self._drain()

    def _drain(self) -> None:
        """Write as much as the line has carried away since the last time."""
        assert self._device is not None
        assert self._selector is not None
        assert self._channel is not None
        rate, now_s = self._line.bytes_per_s, self._now_s()
        # A token bucket: bytes may be written as time pays for them, up to one burst.
        burst_bytes = max(_LEAST_BURST_BYTES, _BURST_S * rate)
        credit_bytes = self._credit_bytes + (now_s - self._credited_s) * rate
        self._credit_bytes, self._credited_s = min(burst_bytes, credit_bytes), now_s
        try:
            n_sent = os.write(self._device, self._unsent[: int(self._credit_bytes)])
        except (BlockingIOError, InterruptedError):
            n_sent = 0
        except OSError:
            return  # the device is gone, which reading notices too
        self._credit_bytes -= n_sent
        del self._unsent[:n_sent]
        self._channel.is_crowded = len(self._unsent) > _HELD_S * rate
        # Asked for only while bytes wait: a writable device would wake the selector all the time.
        wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if self._unsent else 0)
        if self._selector.get_key(self._device).events != wanted:
            self._selector.modify(self._device, wanted, self._poll)


def open_raw(line: SerialLine) -> int:
    """Return the file descriptor of a device: non-blocking, raw, eight bits without parity.

    Raises:
        LinkError: If it does not exist, is not accessible, or is no serial line.
    """
    try:
        # Without NOCTTY a signal on the line could end this process; without NONBLOCK opening
        # waits.
        device = os.open(line.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise LinkError(f"cannot open serial device {line.path}: {error.strerror}") from error
    try:
        tty.setraw(device)
        settings = termios.tcgetattr(device)
        # Ignore modem lines, read; one stop bit, no hardware flow control.
        settings[2] |= termios.CLOCAL | termios.CREAD
        settings[2] &= ~(termios.CSTOPB | termios.CRTSCTS)
        settings[4] = settings[5] = _BAUDS[line.baud]
        termios.tcsetattr(device, termios.TCSANOW, settings)
    except termios.error as error:
        os.close(device)
        raise LinkError(f"{line.path} is no serial device: {error.args[-1]}") from error
    return device
