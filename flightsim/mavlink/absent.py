"""What the vehicle does not have: a shell and a buzzer. Whoever asks is told so."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send
from flightsim.mavlink.statustext import StatustextSender

_NO_SHELL = b"This vehicle has no shell.\n"
_NO_BUZZER = "This vehicle has no buzzer: the tune is not played"


class AbsentService:
    """Answers messages to parts that are not there, so that nobody waits for them."""

    def __init__(self, statustext: StatustextSender) -> None:
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {
            "SERIAL_CONTROL": self._on_serial,
            "PLAY_TUNE": self._on_tune,
            "PLAY_TUNE_V2": self._on_tune,
        }

    def _on_serial(self, channel: Channel, message: Message) -> None:
        if message.flags & mav.SERIAL_CONTROL_FLAG_REPLY or not message.count:
            return  # An answer of somebody else, or a question for more of one.
        send(
            channel,
            "SERIAL_CONTROL",
            device=message.device,
            flags=mav.SERIAL_CONTROL_FLAG_REPLY,
            count=len(_NO_SHELL),
            data=_NO_SHELL,
        )

    def _on_tune(self, _: Channel, __: Message) -> None:
        # Tunes have no acknowledgement: SDKs report success however it ends.
        self._statustext.say(Severity.WARNING, _NO_BUZZER)
