"""Telemetry of the surroundings: obstacles, other aircraft, and the pilot's sticks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from autonomy.types import vector3
from flightsim.frames import swap_enu_ned, swap_yaw_enu_ned
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.ring_report import RingReport
from flightsim.mavlink.view import VehicleView

_ADSB_VEHICLE = layout("ADSB_VEHICLE")
_RC_CHANNELS = layout("RC_CHANNELS")

_FIRST_ICAO_ADDRESS = 0xF00000
"""First address of a block that the ICAO has given to nobody."""
_PWM_MIDDLE, _PWM_HALF_SPAN = 1500, 500
_UNUSED_CHANNEL, _FULL_SIGNAL = 0xFFFF, 254


class SurroundingsTelemetry:
    """Packs messages of obstacles, other aircraft and sticks."""

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        kinds = view.plant.obstacles_true.kinds
        self._aircraft = [index for index, kind in enumerate(kinds) if kind == "drone"]
        self._n_sent = 0
        self._ring = RingReport(view.plant)
        self.producers: Mapping[str, Callable[[], bytes | None]] = {
            "RC_CHANNELS": self._sticks,
            "OBSTACLE_DISTANCE": self._obstacles,
            **({"ADSB_VEHICLE": self._aircraft_report} if self._aircraft else {}),
        }

    def _aircraft_report(self) -> bytes:
        """Report the other aircraft in turn, one in each message."""
        number = self._n_sent % len(self._aircraft)
        self._n_sent += 1
        v = self._view
        index, states = self._aircraft[number], v.plant.obstacles_true
        place = v.frame.geodetic_from_enu(vector3(states.position_enu_m[index]))
        vn, ve, vd = swap_enu_ned(vector3(states.velocity_enu_mps[index]))
        heading_deg = math.degrees(swap_yaw_enu_ned(float(states.yaw_rad[index]))) % 360.0
        return _ADSB_VEHICLE.encode(
            ICAO_address=_FIRST_ICAO_ADDRESS + number,
            lat=round(place.latitude_deg * 1e7),
            lon=round(place.longitude_deg * 1e7),
            altitude_type=mav.ADSB_ALTITUDE_TYPE_GEOMETRIC,
            altitude=round(place.altitude_m * 1e3),
            heading=round(heading_deg * 100.0) % 36000,
            hor_velocity=round(100.0 * math.hypot(vn, ve)),
            ver_velocity=round(-100.0 * vd),
            callsign=f"DRONE{number}",
            emitter_type=mav.ADSB_EMITTER_TYPE_UAV,
            flags=mav.ADSB_FLAGS_VALID_COORDS
            | mav.ADSB_FLAGS_VALID_ALTITUDE
            | mav.ADSB_FLAGS_VALID_HEADING
            | mav.ADSB_FLAGS_VALID_VELOCITY
            | mav.ADSB_FLAGS_VALID_CALLSIGN,
        )

    def _obstacles(self) -> bytes:
        """Report the ring scan."""
        return self._ring.payload(self._view.time_us)

    def _sticks(self) -> bytes | None:
        """Report the sticks as pulses: roll, pitch, throttle, yaw; none without sticks."""
        v = self._view
        if not v.autopilot.sticks.is_alive(v.time_us):
            return None
        sticks = v.autopilot.sticks.current(v.time_us)
        # A stick pulled back gives a high pulse and pitches the nose up.
        axes = (sticks.roll, -sticks.pitch, 2.0 * sticks.throttle - 1.0, sticks.yaw)
        pulses = [_PWM_MIDDLE + round(_PWM_HALF_SPAN * axis) for axis in axes]
        pulses += [_UNUSED_CHANNEL] * (18 - len(pulses))  # fields of RC_CHANNELS
        return _RC_CHANNELS.encode(
            time_boot_ms=v.time_boot_ms,
            chancount=len(axes),
            rssi=_FULL_SIGNAL,
            **{f"chan{number}_raw": pulse for number, pulse in enumerate(pulses, start=1)},
        )
