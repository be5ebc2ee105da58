"""Motor telemetry: reports of the speed controllers."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flightsim.mavlink.dialect import layout
from flightsim.mavlink.telemetry import Producer
from flightsim.mavlink.view import VehicleView
from flightsim.vehicles.battery import watts_per_cubed_speed

_ESC_STATUS, _ESC_INFO = layout("ESC_STATUS"), layout("ESC_INFO")

_ESCS = 4
"""Speed controllers in one message; further ones come in more messages."""
_INFO_BITS = 8
_RPM_PER_RADPS = 30.0 / math.pi
_LEAST_VOLTAGE_V = 1.0  # no division by zero at an empty battery
_DSHOT = 5  # of ESC_CONNECTION_TYPE
_UNKNOWN_TEMPERATURE = 0x7FFF


class MotorTelemetry:
    """Packs messages of the motors, in the order of their numbers."""

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        airframe = view.plant.world.airframe
        self._motors = airframe.motors
        self._first_escs = range(0, len(self._motors), _ESCS)
        self._watts_per_cubed_speed = watts_per_cubed_speed(airframe.battery)
        self.producers: Mapping[str, Producer] = {
            "ESC_STATUS": self._esc_status,
            "ESC_INFO": self._esc_info,
        }

    def _esc_status(self) -> tuple[bytes, ...]:
        v = self._view
        voltage_v = v.autopilot.battery.voltage_v
        return tuple(self._esc_part(first, voltage_v) for first in self._first_escs)

    def _esc_part(self, first: int, voltage_v: float) -> bytes:
        v = self._view
        rotors = self._motors[first : first + _ESCS]
        speeds_radps = [v.plant.rotor_speeds_radps[rotor] for rotor in rotors]
        # Controllers measure current; here it follows from the same power law as the battery's
        # load.
        watts = [self._watts_per_cubed_speed * abs(speed) ** 3 for speed in speeds_radps]
        return _ESC_STATUS.encode(
            time_usec=v.time_us,
            rpm=[round(_RPM_PER_RADPS * speed) for speed in speeds_radps],
            voltage=[voltage_v] * len(speeds_radps),
            current=[power_w / max(voltage_v, _LEAST_VOLTAGE_V) for power_w in watts],
            index=first,
        )

    def _esc_info(self) -> tuple[bytes, ...]:
        v = self._view
        lost = v.plant.lost_rotors
        online = sum(1 << k for k, rotor in enumerate(self._motors) if rotor not in lost)
        return tuple(
            _ESC_INFO.encode(
                time_usec=v.time_us,
                # MAVLink's counter of data packets; here it counts ticks.
                counter=v.time_us // 20_000 & 0xFFFF,
                count=len(self._motors),
                connection_type=_DSHOT,
                # Bits of eight controllers share one field: the group that this message belongs to.
                info=online >> first // _INFO_BITS * _INFO_BITS & 0xFF,
                temperature=[_UNKNOWN_TEMPERATURE] * _ESCS,
                index=first,
            )
            for first in self._first_escs
        )
