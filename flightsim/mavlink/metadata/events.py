"""Events as numbers that a ground station turns into words in its own language.

https://mavlink.io/en/services/events.html. Each event has a place in a sequence, so that a partner
that missed some can request them again. Texts (STATUSTEXT) cannot be requested again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flightsim.autopilot.events import Severity
from flightsim.autopilot.modes import FailsafeReason, LandedState
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, Partners, send
from flightsim.mavlink.view import VehicleView

_EVENT = layout("EVENT")
_CURRENT_EVENT_SEQUENCE = layout("CURRENT_EVENT_SEQUENCE")

_COMPONENT = 1
"""Component of the autopilot, in the highest byte of an event's number."""
_MOST_KEPT = 64  # events that can be repeated
_N_SEQUENCES = 1 << 16
_REASON = "failsafe_reason_t"
_REASONS = tuple(FailsafeReason)


@dataclass(frozen=True, kw_only=True)
class _Kind:
    """One kind of event, as the document describes it."""

    name: str
    message: str
    """Template of the words: {1} is the first argument."""
    severity: Severity = Severity.INFO
    arguments: Sequence[str] = ()
    """Type of each argument, a byte."""


_ARMED, _DISARMED, _TOOK_OFF, _LANDED, _FAILSAFE, _FAILSAFE_ENDED = range(1, 7)
_KINDS = {
    _ARMED: _Kind(name="armed", message="Armed"),
    _DISARMED: _Kind(name="disarmed", message="Disarmed"),
    _TOOK_OFF: _Kind(name="took_off", message="Takeoff detected"),
    _LANDED: _Kind(name="landed", message="Landing detected"),
    _FAILSAFE: _Kind(
        name="failsafe",
        message="Failsafe: {1}",
        severity=Severity.WARNING,
        arguments=(_REASON,),
    ),
    _FAILSAFE_ENDED: _Kind(name="failsafe_ended", message="Failsafe ended"),
}


def events_document() -> Mapping[str, Any]:
    """Return the meaning of each event: https://github.com/mavlink/libevents, schema version 2."""
    return {
        "version": 2,
        "components": {
            str(_COMPONENT): {
                "namespace": "aeroscene",
                "enums": {_REASON: {"type": "uint8_t", "entries": dict(_reason_entries())}},
                "event_groups": {
                    "default": {
                        "events": {str(number): _as_json(kind) for number, kind in _KINDS.items()}
                    }
                },
            }
        },
    }


def _reason_entries() -> Iterator[tuple[str, Mapping[str, str]]]:
    for number, reason in enumerate(_REASONS):
        yield str(number), {"name": reason.name.lower(), "description": reason.value}


def _as_json(kind: _Kind) -> Mapping[str, Any]:
    arguments = [{"name": name.removesuffix("_t"), "type": name} for name in kind.arguments]
    return {
        "name": kind.name,
        "message": kind.message,
        **({"arguments": arguments} if arguments else {}),
    }


class EventService:
    """Sends all partners the events as they happen, and again on request.

    Attributes:
        producers: Packing function of the last event's number.
    """

    def __init__(self, view: VehicleView, partners: Partners) -> None:
        self._view = view
        self._partners = partners
        self._n_told = 0
        self._kept: deque[tuple[int, bytes]] = deque(maxlen=_MOST_KEPT)
        self._before = self._state()
        self.handlers: Mapping[str, Handler] = {"REQUEST_EVENT": self._on_request}
        self.producers: Mapping[str, Callable[[], bytes]] = {
            "CURRENT_EVENT_SEQUENCE": self._current_sequence
        }

    def update(self) -> None:
        """Report the changes since the last tick."""
        now, before = self._state(), self._before
        if now == before:
            return
        self._before = now
        (is_armed, is_landed, failsafe), (was_armed, was_landed, last_failsafe) = now, before
        if is_armed != was_armed:
            self._tell(_ARMED if is_armed else _DISARMED)
        if is_landed != was_landed:
            self._tell(_LANDED if is_landed else _TOOK_OFF)
        if failsafe is not last_failsafe:
            if failsafe is None:
                self._tell(_FAILSAFE_ENDED)
            else:
                self._tell(_FAILSAFE, _REASONS.index(failsafe))

    def _state(self) -> tuple[bool, bool, FailsafeReason | None]:
        autopilot = self._view.autopilot
        is_landed = autopilot.landed_state is LandedState.ON_GROUND
        return autopilot.is_armed, is_landed, autopilot.failsafe

    def _tell(self, number: int, *arguments: int) -> None:
        severity = _KINDS[number].severity
        sequence = self._n_told % _N_SEQUENCES
        self._n_told += 1
        payload = _EVENT.encode(
            id=_COMPONENT << 24 | number,
            event_time_boot_ms=self._view.time_boot_ms,
            sequence=sequence,
            # Four bits each for the external and the internal level.
            log_levels=severity << 4 | severity,
            arguments=arguments,
        )
        self._kept.append((sequence, payload))
        self._partners.broadcast(_EVENT, payload)

    def _current_sequence(self) -> bytes:
        # -1 becomes the last number before 0: nothing has happened yet.
        return _CURRENT_EVENT_SEQUENCE.encode(sequence=(self._n_told - 1) % _N_SEQUENCES)

    def _on_request(self, channel: Channel, message: Message) -> None:
        """Repeat a range of events; one that is no longer kept is refused."""
        first, last = message.first_sequence, message.last_sequence
        n_asked = (last - first) % _N_SEQUENCES + 1
        found = [
            payload
            for sequence, payload in self._kept
            # Counted from the first asked for, so that a range may cross the end of the 16 bits.
            if (sequence - first) % _N_SEQUENCES < n_asked
        ]
        for payload in found:
            channel.send(_EVENT, payload)
        if len(found) < n_asked:
            oldest = self._kept[0][0] if self._kept else self._n_told % _N_SEQUENCES
            send(
                channel,
                "RESPONSE_EVENT_ERROR",
                target_system=message.get_srcSystem(),
                target_component=message.get_srcComponent(),
                sequence=first,
                sequence_oldest_available=oldest,
            )
