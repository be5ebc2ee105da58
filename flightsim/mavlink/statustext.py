"""STATUSTEXT: text messages for people, long ones in chunks."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from flightsim.autopilot.events import Severity
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.service import Partners

_STATUSTEXT = layout("STATUSTEXT")
_CHUNK_BYTES = 50  # text field of one message
_LONGEST_BYTES = 250  # five chunks


class StatustextSender:
    """Sends texts to all partners; numbers those that need more than one message.

    Attributes:
        listeners: Called with every text, even without partners.
    """

    def __init__(self, partners: Partners) -> None:
        self._partners = partners
        self._last_id = 0
        self._said_in_tick: set[str] = set()
        self.listeners: list[Callable[[Severity, str], None]] = []

    def end_tick(self) -> None:
        """End the tick, so that texts sent in it may be repeated."""
        self._said_in_tick.clear()

    def broadcast(self, severity: Severity, text: str) -> None:
        """Send a text of at most 250 bytes; longer ones are cut, repeats in a tick are dropped.

        Args:
            severity: Severity, as ground stations colour it.
            text: The text.
        """
        if text in self._said_in_tick:
            return
        self._said_in_tick.add(text)
        for listener in self.listeners:
            listener(severity, text)
        for payload in self._payloads(severity, text.encode()[:_LONGEST_BYTES]):
            self._partners.broadcast(_STATUSTEXT, payload)

    def answer(self, channel: Channel, severity: Severity, text: str) -> None:
        """Send a text to one partner; listeners get it too."""
        for listener in self.listeners:
            listener(severity, text)
        for payload in self._payloads(severity, text.encode()[:_LONGEST_BYTES]):
            channel.send(_STATUSTEXT, payload)

    def _payloads(self, severity: Severity, line: bytes) -> Iterator[bytes]:
        if len(line) <= _CHUNK_BYTES:
            yield _STATUSTEXT.encode(severity=int(severity), text=line)
            return
        # 0 means "complete in one message", so ids run from 1.
        self._last_id = self._last_id % 0xFFFF + 1
        # A chunk that is not full ends the text, so a full last chunk is followed by an empty one.
        for chunk, start in enumerate(range(0, len(line) + 1, _CHUNK_BYTES)):
            yield _STATUSTEXT.encode(
                severity=int(severity),
                text=line[start : start + _CHUNK_BYTES],
                id=self._last_id,
                chunk_seq=chunk,
            )
