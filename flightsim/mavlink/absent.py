"""What the vehicle does not have: a buzzer. Whoever asks is told so."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.statustext import StatustextSender

_NO_BUZZER = "This vehicle has no buzzer: the tune is not played"


class AbsentService:
    """Answers messages to parts that are not there."""

    def __init__(self, statustext: StatustextSender) -> None:
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {
            "PLAY_TUNE": self._on_tune,
            "PLAY_TUNE_V2": self._on_tune,
        }

    def _on_tune(self, _: Channel, __: Message) -> None:
        # Tunes have no acknowledgement: SDKs report success however it ends.
        self._statustext.say(Severity.WARNING, _NO_BUZZER)
