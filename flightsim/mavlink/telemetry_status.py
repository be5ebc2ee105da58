"""Status telemetry: messages of identity, system state and home position."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from autonomy.types import quat_about_up
from flightsim.autopilot.modes import LandedState, Mode, SystemState
from flightsim.autopilot.status import BatteryView, Health
from flightsim.environment.date import EPOCH_US
from flightsim.frames import swap_quat_enu_flu_ned_frd
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.hardware_uid import hardware_uid
from flightsim.mavlink.mode_report import ModeReport
from flightsim.mavlink.personalities import Personality
from flightsim.mavlink.vehicle_type import vehicle_type
from flightsim.mavlink.view import VehicleView

_HEARTBEAT = layout("HEARTBEAT")
_SYS_STATUS = layout(
    "SYS_STATUS",
    *("onboard_control_sensors_present", "onboard_control_sensors_enabled"),
    *("onboard_control_sensors_health", "load", "voltage_battery", "current_battery"),
    *("drop_rate_comm", "errors_comm", "errors_count1", "errors_count2", "errors_count3"),
    *("errors_count4", "battery_remaining", "onboard_control_sensors_present_extended"),
    "onboard_control_sensors_enabled_extended",
    "onboard_control_sensors_health_extended",
)
_EXTENDED_SYS_STATE = layout("EXTENDED_SYS_STATE", "vtol_state", "landed_state")
_HOME_POSITION = layout("HOME_POSITION")
_GPS_GLOBAL_ORIGIN = layout("GPS_GLOBAL_ORIGIN")
_MISSION_CURRENT = layout("MISSION_CURRENT")
_CURRENT_MODE = layout("CURRENT_MODE")
_AUTOPILOT_VERSION = layout("AUTOPILOT_VERSION")
_FLIGHT_INFORMATION = layout("FLIGHT_INFORMATION")
_PROTOCOL_VERSION = layout("PROTOCOL_VERSION")

_STATES = {
    SystemState.STANDBY: mav.MAV_STATE_STANDBY,
    SystemState.ACTIVE: mav.MAV_STATE_ACTIVE,
    SystemState.CRITICAL: mav.MAV_STATE_CRITICAL,
    SystemState.EMERGENCY: mav.MAV_STATE_EMERGENCY,
}
# There are only four payloads, so they are packed once.
_EXTENDED_SYS_STATES = {
    state: _EXTENDED_SYS_STATE.pack(0, landed_state)
    for state, landed_state in (
        (LandedState.ON_GROUND, mav.MAV_LANDED_STATE_ON_GROUND),
        (LandedState.IN_AIR, mav.MAV_LANDED_STATE_IN_AIR),
        (LandedState.TAKEOFF, mav.MAV_LANDED_STATE_TAKEOFF),
        (LandedState.LANDING, mav.MAV_LANDED_STATE_LANDING),
    )
}
# MAV_SYS_STATUS_SENSOR
_GYRO, _ACCEL, _MAG, _PRESSURE, _GPS, _LASER = 1, 2, 4, 8, 32, 256
_CONTROLLERS = 1024 | 2048 | 4096 | 8192 | 16384 | 32768  # rates to motor outputs
_GEOFENCE, _AHRS, _BATTERY, _PREARM_CHECK = 1 << 20, 1 << 21, 1 << 25, 1 << 28
_PRESENT = (
    (_GYRO | _ACCEL | _MAG | _PRESSURE | _GPS | _LASER | _CONTROLLERS)
    | (_GEOFENCE | _AHRS | _BATTERY | _PREARM_CHECK)
)  # fmt: skip


class StatusTelemetry:
    """Packs messages from the autopilot's state."""

    def __init__(
        self, view: VehicleView, personality: Personality, modes: ModeReport, system_id: int
    ) -> None:
        self._view = view
        self._personality = personality
        self._modes = modes
        self._system_id = system_id
        self._type = vehicle_type(view.plant.world.airframe)
        self._packed_of: tuple[Health, BatteryView] | tuple[None, None] = (None, None)
        self._packed = b""
        self.producers: Mapping[str, Callable[[], bytes | None]] = {
            "HEARTBEAT": self._heartbeat,
            "SYS_STATUS": self._sys_status,
            "EXTENDED_SYS_STATE": self._extended_sys_state,
            "HOME_POSITION": self._home_position,
            "GPS_GLOBAL_ORIGIN": self._global_origin,
            "MISSION_CURRENT": self._mission_current,
            "CURRENT_MODE": self._current_mode,
            "AUTOPILOT_VERSION": self._autopilot_version,
            "PROTOCOL_VERSION": self._protocol_version,
            "FLIGHT_INFORMATION": self._flight_information,
        }

    def _heartbeat(self) -> bytes:
        autopilot = self._view.autopilot
        entry = self._modes.entry
        state = _STATES[autopilot.system_state]
        if autopilot.mode is Mode.TERMINATION:
            state = mav.MAV_STATE_FLIGHT_TERMINATION
        return _HEARTBEAT.encode(
            type=self._type,
            autopilot=self._personality.autopilot,
            base_mode=entry.base_mode
            | (mav.MAV_MODE_FLAG_SAFETY_ARMED if autopilot.is_armed else 0),
            custom_mode=entry.custom_mode,
            system_status=state,
            mavlink_version=3,
        )

    def _sys_status(self) -> bytes:
        """Report the parts' health; packed anew only after the autopilot has checked them."""
        autopilot = self._view.autopilot
        health, battery = autopilot.health, autopilot.battery
        # By identity: the autopilot makes new reports twice a second.
        if health is not self._packed_of[0] or battery is not self._packed_of[1]:
            more = self._personality.status_bits
            self._packed_of, self._packed = (health, battery), _pack_status(health, battery, more)
        return self._packed

    def _extended_sys_state(self) -> bytes:
        return _EXTENDED_SYS_STATES[self._view.autopilot.landed_state]

    def _home_position(self) -> bytes | None:
        v = self._view
        home = v.autopilot.home
        if home is None:
            return None
        x, y, z = v.ned_from_enu(home.position_enu_m)
        return _HOME_POSITION.encode(
            latitude=round(home.geodetic.latitude_deg * 1e7),
            longitude=round(home.geodetic.longitude_deg * 1e7),
            altitude=round(home.geodetic.altitude_m * 1e3),
            x=x,
            y=y,
            z=z,
            q=swap_quat_enu_flu_ned_frd(quat_about_up(home.yaw_rad)),
            time_usec=v.time_us,
        )

    def _global_origin(self) -> bytes:
        v = self._view
        return _GPS_GLOBAL_ORIGIN.encode(
            latitude=round(v.origin.latitude_deg * 1e7),
            longitude=round(v.origin.longitude_deg * 1e7),
            altitude=round(v.origin.altitude_m * 1e3),
            time_usec=v.time_us,
        )

    def _mission_current(self) -> bytes:
        autopilot = self._view.autopilot
        mission = autopilot.mission
        n_home_items = self._personality.n_home_items
        return _MISSION_CURRENT.encode(
            seq=mission.current_index + n_home_items,
            total=n_home_items + len(mission) if len(mission) else 0xFFFF,  # 0xFFFF: no mission
            mission_state=self._mission_state(),
            mission_mode=1 if autopilot.mode is Mode.MISSION else 2,
        )

    def _mission_state(self) -> int:
        autopilot = self._view.autopilot
        mission = autopilot.mission
        if not len(mission):
            return mav.MISSION_STATE_NO_MISSION
        if mission.is_finished:
            return mav.MISSION_STATE_COMPLETE
        if autopilot.is_mission_running:
            return mav.MISSION_STATE_ACTIVE
        is_under_way = mission.current_index > 0 or mission.last_reached_index is not None
        return mav.MISSION_STATE_PAUSED if is_under_way else mav.MISSION_STATE_NOT_STARTED

    def _current_mode(self) -> bytes:
        entry = self._modes.entry
        return _CURRENT_MODE.encode(
            standard_mode=entry.standard_mode,
            custom_mode=entry.custom_mode,
            intended_custom_mode=entry.custom_mode,
        )

    def _autopilot_version(self) -> bytes:
        personality = self._personality
        return _AUTOPILOT_VERSION.encode(
            capabilities=personality.capabilities,
            flight_sw_version=personality.flight_sw_version,
            flight_custom_version=personality.flight_custom_version,
            uid=0xAE5CE4E0_0000_0000 | self._system_id,
            uid2=list(hardware_uid(self._system_id)),
        )

    def _protocol_version(self) -> bytes:
        return _PROTOCOL_VERSION.encode(version=200, min_version=100, max_version=200)

    def _flight_information(self) -> bytes:
        v = self._view
        autopilot = v.autopilot
        return _FLIGHT_INFORMATION.encode(
            time_boot_ms=v.time_boot_ms,
            arming_time_utc=_utc_us(autopilot.armed_at_us),
            # Both times are UTC, by the date of the simulation.
            takeoff_time_utc=_utc_us(autopilot.took_off_at_us),
            flight_uuid=autopilot.n_arms,
        )


def _utc_us(time_us: int | None) -> int:
    return 0 if time_us is None else EPOCH_US + time_us


def _pack_status(health: Health, battery: BatteryView, more: int) -> bytes:
    """Pack SYS_STATUS.

    Args:
        health: Health of the parts.
        battery: The battery.
        more: Bits that are always present, on and healthy.
    """
    # MAVSDK infers "position known" from GPS, and "calibrated" from gyro, accel and mag.
    bits = (
        (_GYRO | _ACCEL if health.is_imu_ok else 0)
        | (_MAG if health.is_mag_ok else 0)
        | (_PRESSURE if health.is_baro_ok else 0)
        | (_GPS if health.is_gnss_ok and health.is_position_ok else 0)
        | (_LASER if health.is_rangefinder_ok else 0)
        | (_AHRS if health.is_attitude_ok else 0)
        | (_BATTERY if health.is_battery_ok else 0)
        | (_GEOFENCE if health.is_geofence_ok else 0)
        | (_PREARM_CHECK if health.is_armable else 0)
        | _CONTROLLERS
        | more
    )
    present = _PRESENT | more
    return _SYS_STATUS.pack(
        *(present, present if health.is_geofence_on else present & ~_GEOFENCE, bits, 0),
        max(0, min(0xFFFE, round(1e3 * battery.voltage_v))),
        max(-1, min(0x7FFF, round(100.0 * battery.current_a))),
        *(0,) * 6,
        max(0, min(100, round(100.0 * battery.remaining))),
        *(0, 0, 0),
    )
