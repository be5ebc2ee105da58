"""ArduPilot's identity: ArduCopter 4.5, from its mode.h, its Parameters.cpp and its answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flightsim.autopilot.modes import Mode
from flightsim.frames import euler_rpy_rad, swap_flu_frd, swap_quat_enu_flu_ned_frd
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.personalities.personality import Alias, ModeEntry, Personality
from flightsim.mavlink.telemetry_sensors import imu_fields
from flightsim.mavlink.view import VehicleView

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
_EKF_HEIGHT, _EKF_PREDICTS_POSITION = 32, 256 | 512
_EKF_NOT_READY = 1024
_CENTI = 0.01


def _mode(
    title: str,
    custom_mode: int,
    mode: Mode,
    *also: Mode,
    base_mode: int = _AUTOMATIC,
    is_selectable: bool = True,
) -> ModeEntry:
    return ModeEntry(
        mode=mode,
        custom_mode=custom_mode,
        base_mode=base_mode,
        is_selectable=is_selectable,
        also=frozenset(also),
        title=title,
    )


def _extra_telemetry(view: VehicleView) -> Mapping[str, Callable[[], bytes | None]]:
    def ekf_status() -> bytes:
        health = view.autopilot.health
        flags = (_EKF_ATTITUDE if health.is_attitude_ok else 0) or _EKF_NOT_READY
        if health.is_position_ok:
            flags |= _EKF_VELOCITY | _EKF_POSITION_ABSOLUTE | _EKF_HEIGHT | _EKF_PREDICTS_POSITION
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


# Our modes without a place in ArduCopter are reported as what the vehicle does in them.
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
        _mode("CIRCLE", 7, Mode.ORBIT, is_selectable=False),
        _mode("LAND", 9, Mode.LAND, Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION),
        _mode("POSHOLD", 16, Mode.POSITION),
        _mode("BRAKE", 17, Mode.HOLD),
        _mode("GUIDED_NOGPS", 20, Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD),
        _mode("FOLLOW", 23, Mode.FOLLOW),
    ),
    mode_shift={"main": 0, "sub": 8},
    flight_sw_version=4 << 24 | 5 << 16 | 7 << 8 | 255,
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
    aliases=(
        Alias(name="ANGLE_MAX", ours="MPC_MAN_TILT_MAX", scale=_CENTI, is_integer=True),
        Alias(name="BATT_CAPACITY", ours="BAT1_CAPACITY", is_integer=True),
        Alias(name="CIRCLE_RADIUS", ours="NAV_LOITER_RAD", scale=_CENTI),
        Alias(name="DISARM_DELAY", ours="COM_DISARM_PRFLT", is_integer=True),
        Alias(
            name="FENCE_ACTION",
            ours="GF_ACTION",
            is_integer=True,
            codes={0: 1, 1: 3, 2: 5, 4: 2},
        ),
        Alias(name="FENCE_ALT_MAX", ours="GF_MAX_VER_DIST"),
        Alias(name="FENCE_RADIUS", ours="GF_MAX_HOR_DIST"),
        Alias(name="FS_GCS_ENABLE", ours="NAV_DLL_ACT", is_integer=True, codes={0: 0, 1: 2, 5: 3}),
        Alias(name="FS_GCS_TIMEOUT", ours="COM_DL_LOSS_T"),
        Alias(name="FS_THR_ENABLE", ours="NAV_RCL_ACT", is_integer=True, codes={0: 0, 1: 2, 3: 3}),
        Alias(name="GUID_TIMEOUT", ours="COM_OF_LOSS_T"),
        Alias(name="LAND_SPEED", ours="MPC_LAND_SPEED", scale=_CENTI, is_integer=True),
        Alias(name="LOIT_SPEED", ours="MPC_VEL_MANUAL", scale=_CENTI),
        Alias(name="MOT_THST_HOVER", ours="MPC_THR_HOVER"),
        Alias(name="PILOT_SPEED_DN", ours="MPC_Z_VEL_MAX_DN", scale=_CENTI, is_integer=True),
        Alias(name="PILOT_SPEED_UP", ours="MPC_Z_VEL_MAX_UP", scale=_CENTI, is_integer=True),
        Alias(name="PILOT_TKOFF_ALT", ours="MIS_TAKEOFF_ALT", scale=_CENTI),
        Alias(name="RC_OVERRIDE_TIME", ours="COM_RC_LOSS_T"),
        Alias(name="RTL_ALT", ours="RTL_RETURN_ALT", scale=_CENTI, is_integer=True),
        Alias(name="RTL_LOIT_TIME", ours="RTL_LAND_DELAY", scale=1e-3, is_integer=True),
        Alias(name="SIM_WIND_DIR", ours="SIM_WIND_DIR"),
        Alias(name="SIM_WIND_SPD", ours="SIM_WIND_SPD"),
        Alias(name="SIM_WIND_TURB", ours="SIM_WIND_TURB"),
        Alias(name="SYSID_THISMAV", ours="MAV_SYS_ID", is_integer=True),
        Alias(name="WPNAV_ACCEL", ours="MPC_ACC_HOR", scale=_CENTI),
        Alias(name="WPNAV_JERK", ours="MPC_JERK_AUTO"),
        Alias(name="WPNAV_RADIUS", ours="NAV_ACC_RAD", scale=_CENTI),
        Alias(name="WPNAV_SPEED", ours="MPC_XY_CRUISE", scale=_CENTI),
        Alias(name="WPNAV_SPEED_DN", ours="MPC_Z_V_AUTO_DN", scale=_CENTI),
        Alias(name="WPNAV_SPEED_UP", ours="MPC_Z_V_AUTO_UP", scale=_CENTI),
    ),
    initial_parameters={
        "COM_OBL_RC_ACT": 5,  # Without setpoints it stops and holds, ...
        "COM_OF_LOSS_T": 3.0,  # ... three seconds after the last one.
        "COM_RC_LOSS_T": 3.0,
        "COM_RC_OVERRIDE": 0,
        "MPC_XY_CRUISE": 10.0,
        "MPC_Z_V_AUTO_UP": 2.5,
        "NAV_RCL_ACT": 0,  # Its simulator has a radio, which is there when overrides end.
        "RTL_RETURN_ALT": 15.0,
    },
    takes_off_above_home=True,
    turns_as_told=False,
    has_guided_mode=True,
    switches_fence=True,
    tests_motors_clockwise=True,
    has_shell=False,
    has_metadata=False,
    requests_int=False,
    n_home_items=1,
    extra_telemetry=_extra_telemetry,
)
