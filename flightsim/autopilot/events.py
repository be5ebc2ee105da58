"""Events that the autopilot reports without being asked."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import IntEnum, unique

from flightsim.autopilot.mission_item import MissionItem


@unique
class Severity(IntEnum):
    """Syslog severities, RFC 5424 section 6.2.1."""

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
    """Line of text for people."""

    time_us: int
    severity: Severity
    text: str


@dataclass(frozen=True, slots=True)
class MissionItemReached:
    """The mission has arrived at its item `index`."""

    time_us: int
    index: int


@dataclass(frozen=True, slots=True)
class PayloadOrder:
    """The mission has come to an item for what the vehicle carries."""

    time_us: int
    item: MissionItem


Event = Statustext | MissionItemReached | PayloadOrder


class EventLog:
    """Bounded queue of events; ignores a text that is repeated within `quiet_us`."""

    def __init__(self, *, capacity: int = 256, quiet_us: int = 2_000_000) -> None:
        self.time_us = 0
        self._quiet_us = quiet_us
        self._waiting: deque[Event] = deque(maxlen=capacity)
        self._last_said_us: dict[str, int] = {}

    def say(self, severity: Severity, text: str) -> None:
        """Queue a text, unless the same one was queued just before."""
        last_us = self._last_said_us.get(text)
        if last_us is not None and self.time_us - last_us < self._quiet_us:
            return
        if len(self._last_said_us) > 128:
            self._last_said_us.clear()
        self._last_said_us[text] = self.time_us
        self._waiting.append(Statustext(self.time_us, severity, text))

    def mission_item_reached(self, index: int) -> None:
        """Queue the arrival at a mission item."""
        self._waiting.append(MissionItemReached(self.time_us, index))

    def payload_order(self, item: MissionItem) -> None:
        """Queue an item for what the vehicle carries."""
        self._waiting.append(PayloadOrder(self.time_us, item))

    def pop(self) -> list[Event]:
        """Remove and return all queued events, oldest first."""
        if not self._waiting:
            return []
        events = list(self._waiting)
        self._waiting.clear()
        return events
