"""ArduPilot's identity: ArduCopter 4.5, from its mode.h, its Parameters.cpp and its answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flightsim.autopilot.modes import Mode
from flightsim.frames import euler_rpy_rad, swap_flu_frd, swap_quat_enu_flu_ned_frd
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.personalities.copter_parameters import ALIASES, SETTINGS, defaults_of
from flightsim.mavlink.personalities.personality import ModeEntry, Personality
from flightsim.mavlink.telemetry_sensors import imu_fields
from flightsim.mavlink.view import VehicleView
from flightsim.plant.external_aids import FixSource

_EKF_STATUS_REPORT = layout("EKF_STATUS_REPORT")
_RANGEFINDER = layout("RANGEFINDER")
_RAW_IMU = layout("RAW_IMU")
_SIMSTATE = layout("SIMSTATE")

_STICKS = (
    mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mav.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
    | mav.MAV_MODE_FLAG_STABILIZE_ENABLED
)
_AUTOMATIC = _STICKS | mav.MAV_MODE_FLAG_GUIDED_ENABLED

# EKF_STATUS_FLAGS
_EKF_ATTITUDE, _EKF_VELOCITY, _EKF_POSITION_ABSOLUTE = 1, 2 | 4, 16
# Bits of EKF_STATUS_REPORT; "unaided" is EKF_CONST_POS_MODE.
_EKF_HEIGHT, _EKF_UNAIDED, _EKF_PREDICTS_POSITION = 32, 128, 256 | 512
_EKF_NOT_READY = 1024


def _mode(
    title: str,
    custom_mode: int,
    mode: Mode,
    *also: Mode,
    base_mode: int = _AUTOMATIC,
) -> ModeEntry:
    return ModeEntry(
        mode=mode,
        custom_mode=custom_mode,
        base_mode=base_mode,
        also=frozenset(also),
        title=title,
    )


def _extra_telemetry(view: VehicleView) -> Mapping[str, Callable[[], bytes | None]]:
    def ekf_status() -> bytes:
        health = view.autopilot.health
        # Without an attitude the filter reports that it is not initialised.
        flags = (_EKF_ATTITUDE if health.is_attitude_ok else 0) or _EKF_NOT_READY
        if health.is_position_ok:
            flags |= _EKF_VELOCITY | _EKF_POSITION_ABSOLUTE | _EKF_HEIGHT | _EKF_PREDICTS_POSITION
        if view.plant.estimator.is_dead_reckoning:
            flags |= _EKF_UNAIDED
        return _EKF_STATUS_REPORT.encode(flags=flags)

    def rangefinder() -> bytes | None:
        range_m = view.plant.sensors.range_m
        return _RANGEFINDER.encode(distance=range_m) if math.isfinite(range_m) else None

    def raw_imu() -> bytes:
        return _RAW_IMU.encode(time_usec=view.time_us, **imu_fields(view))

    def simulated_state() -> bytes:
        truth = view.plant.truth
        place = view.frame.geodetic_from_enu(truth.position_enu_m)
        roll, pitch, yaw = euler_rpy_rad(swap_quat_enu_flu_ned_frd(truth.quat_wxyz))
        xacc, yacc, zacc = swap_flu_frd(view.plant.sensors.imu.accel_flu_mps2)
        xgyro, ygyro, zgyro = swap_flu_frd(truth.angular_rate_flu_radps)
        return _SIMSTATE.pack(
            *(roll, pitch, yaw, xacc, yacc, zacc, xgyro, ygyro, zgyro),
            round(place.latitude_deg * 1e7),
            round(place.longitude_deg * 1e7),
        )

    return {
        "EKF_STATUS_REPORT": ekf_status,
        "RANGEFINDER": rangefinder,
        "RAW_IMU": raw_imu,
        "SIMSTATE": simulated_state,
    }


# Our modes without a counterpart in ArduCopter are reported by what the vehicle does in them.
ARDUPILOT = Personality(
    name="ardupilot",
    autopilot=mav.MAV_AUTOPILOT_ARDUPILOTMEGA,
    modes=(
        _mode("GUIDED", 4, Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD),
        _mode("STABILIZE", 0, Mode.STABILIZED, Mode.MANUAL, base_mode=_STICKS),
        _mode("ACRO", 1, Mode.ACRO, base_mode=_STICKS),
        _mode("ALT_HOLD", 2, Mode.ALTITUDE, base_mode=_STICKS),
        _mode("AUTO", 3, Mode.MISSION),
        _mode("LOITER", 5, Mode.POSITION),
        _mode("RTL", 6, Mode.RETURN),
        _mode("CIRCLE", 7, Mode.ORBIT),
        _mode("LAND", 9, Mode.LAND, Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION),
        _mode("POSHOLD", 16, Mode.POSITION),
        _mode("BRAKE", 17, Mode.HOLD),
        _mode("GUIDED_NOGPS", 20, Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD),
        _mode("FOLLOW", 23, Mode.FOLLOW),
    ),
    mode_shift={"main": 0, "sub": 8},
    flight_sw_version=4 << 24 | 5 << 16 | 7 << 8 | 255,  # 4.5.7, official release
    flight_custom_version=b"2a3dc4b7",
    capabilities=(
        mav.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
        | mav.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | mav.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mav.MAV_PROTOCOL_CAPABILITY_FTP
        | mav.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
        | mav.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
        | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
        | mav.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
        | mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
        | mav.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | mav.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    ),
    banner="ArduCopter V4.5.7 (AeroScene)",
    has_bytewise_integers=False,
    aliases=ALIASES,
    settings=SETTINGS,
    initial_parameters={
        **defaults_of(ALIASES),
        "COM_OBL_RC_ACT": 5,  # Without setpoints it stops and holds.
        "COM_RC_OVERRIDE": 0,
        "MPC_XY_VEL_MAX": 35.0,  # Speeds have no limit besides their own.
    },
    pilot_speeds_limit_all=False,
    takes_off_above_home=True,
    acknowledges_set_mode=True,
    # Its simulator has a database of the terrain; whether data is there does not matter to Copter.
    # Source: ArduCopter 4.5, GCS_Copter.cpp, update_vehicle_sensor_status_flags.
    status_bits=1 << 22,
    turns_to_commanded_heading=False,
    has_guided_mode=True,
    switches_fence=True,
    tests_motors_clockwise=True,
    has_shell=False,
    has_metadata=False,
    requests_int=False,
    n_home_items=1,
    fix_source=FixSource.OWN,
    vision_switch=("VISO_TYPE", 1),
    mount_message="MOUNT_STATUS",
    extra_telemetry=_extra_telemetry,
)
