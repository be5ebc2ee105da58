"""Stick input: MANUAL_CONTROL of ground stations and RC_CHANNELS_OVERRIDE of scripts."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.view import VehicleView

_INVALID_AXIS = 0x7FFF
_PWM_MIDDLE, _PWM_HALF_SPAN = 1500, 500
# A channel that is given back to the radio, and one that the message leaves as it is.
_PWM_RELEASED, _PWM_KEPT = 0, 0xFFFF


class ManualControlService:
    """Passes stick positions to the autopilot, which checks their age.

    They come as axes (MANUAL_CONTROL) or as pulse widths of a remote control
    (RC_CHANNELS_OVERRIDE).
    """

    def __init__(self, view: VehicleView, system_id: int) -> None:
        self._view = view
        self._autopilot = view.autopilot
        self._system_id = system_id
        self._pulses = [_PWM_RELEASED] * 4
        self._pulsed_us = [0] * 4
        """Time at which each pulse was sent; an old one counts as released."""
        self.handlers: Mapping[str, Handler] = {
            "MANUAL_CONTROL": self._on_manual_control,
            "RC_CHANNELS_OVERRIDE": self._on_override,
        }

    def _on_manual_control(self, _: Channel, message: Message) -> None:
        if message.target != self._system_id:
            return
        self._autopilot.set_manual_control(
            pitch=_axis(message.x),
            roll=_axis(message.y),
            throttle=0.5 if message.z == _INVALID_AXIS else max(0.0, min(1.0, message.z / 1000.0)),
            yaw=_axis(message.r),
        )

    def _on_override(self, _: Channel, message: Message) -> None:
        now_us = self._view.time_us
        told = (message.chan1_raw, message.chan2_raw, message.chan3_raw, message.chan4_raw)
        # Each channel may come in a message of its own, so the others keep their last pulse.
        for channel, pwm in enumerate(told):
            if pwm != _PWM_KEPT:
                self._pulses[channel], self._pulsed_us[channel] = pwm, now_us
        oldest_us = now_us - self._autopilot.sticks.timeout_us
        pulses = [
            pwm if told_us >= oldest_us else _PWM_RELEASED
            for pwm, told_us in zip(self._pulses, self._pulsed_us, strict=True)
        ]
        if not any(pulses):
            return  # all are released, and there is no radio besides
        roll, pitch, throttle, yaw = map(_deflection, pulses)
        # A stick pulled back gives a high pulse and pitches the nose up.
        self._autopilot.set_manual_control(
            pitch=-pitch, roll=roll, throttle=0.5 + 0.5 * throttle, yaw=yaw
        )


def _axis(value: int) -> float:
    return 0.0 if value == _INVALID_AXIS else max(-1.0, min(1.0, value / 1000.0))


def _deflection(pwm: int) -> float:
    """Return the deflection of a stick by its pulse width, us; a released one is in the middle."""
    if pwm == _PWM_RELEASED:
        return 0.0
    return max(-1.0, min(1.0, (pwm - _PWM_MIDDLE) / _PWM_HALF_SPAN))
