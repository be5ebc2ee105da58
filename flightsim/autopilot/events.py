"""Events that the autopilot reports without being asked."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import IntEnum, unique

from flightsim.autopilot.mission_item import MissionItem


@unique
class Severity(IntEnum):
    """Severities of syslog, RFC 5424 section 6.2.1: the smaller the number, the more urgent."""

    EMERGENCY = 0
    ALERT = 1
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6
    DEBUG = 7


@dataclass(frozen=True, slots=True)
class Statustext:
    """Line of text for people, with its simulated time."""

    time_us: int
    severity: Severity
    text: str


@dataclass(frozen=True, slots=True)
class MissionItemReached:
    """Report that the mission has arrived at its item `index` (from 0)."""

    time_us: int
    index: int


@dataclass(frozen=True, slots=True)
class PayloadOrder:
    """Order for gimbal or camera: the mission has come to an item that they execute."""

    time_us: int
    item: MissionItem


Event = Statustext | MissionItemReached | PayloadOrder


class EventLog:
    """Bounded queue of events; it ignores a text that is repeated within `quiet_us`.

    When `capacity` events wait, each new one drops the oldest, so that a client that never reads
    costs no memory.
    """

    def __init__(self, *, capacity: int = 256, quiet_us: int = 2_000_000) -> None:
        self.time_us = 0
        self._quiet_us = quiet_us
        self._waiting: deque[Event] = deque(maxlen=capacity)
        self._last_reported_us: dict[str, int] = {}

    def report(self, severity: Severity, text: str) -> None:
        """Queue a text for clients, unless the same one was queued less than `quiet_us` ago.

        Args:
            severity: Importance, which clients show by colour or sound.
            text: One line; a text with another number in it is another text.
        """
        last_us = self._last_reported_us.get(text)
        if last_us is not None and self.time_us - last_us < self._quiet_us:
            return
        # Texts with numbers differ each time, so the memory of them must not grow without end.
        if len(self._last_reported_us) > 128:
            self._last_reported_us.clear()
        self._last_reported_us[text] = self.time_us
        self._waiting.append(Statustext(self.time_us, severity, text))

    def mission_item_reached(self, index: int) -> None:
        """Queue the arrival at a mission item (index from 0)."""
        self._waiting.append(MissionItemReached(self.time_us, index))

    def payload_order(self, item: MissionItem) -> None:
        """Queue a mission item that gimbal or camera execute."""
        self._waiting.append(PayloadOrder(self.time_us, item))

    def pop(self) -> list[Event]:
        """Remove and return all queued events, oldest first."""
        if not self._waiting:
            return []
        events = list(self._waiting)
        self._waiting.clear()
        return events
