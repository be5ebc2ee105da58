"""ArduCopter's parameters that act here: names, units, ranges, defaults and choices.

Source: the documentation of each parameter in ArduCopter 4.5: ArduCopter/Parameters.cpp, config.h,
AC_WPNav.cpp, AC_Loiter.cpp, AC_Circle.cpp, AC_Fence.cpp, AP_GPS.cpp, AP_VisualOdom.cpp.
Exceptions, each with its reason, stand beside the parameter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from flightsim.mavlink.personalities.personality import Alias, Setting
from flightsim.mavlink.view import VehicleView
from flightsim.plant.outside import FixSource

_CENTI, _MILLI = 0.01, 1e-3
_CM, _CMPS, _CMPS2 = "cm", "cm/s", "cm/s/s"

# Actions of failsafes in our table.
_NOTHING, _HOLD, _RETURN, _LAND = 0, 1, 2, 3
_FAILSAFE = {
    0: _NOTHING,
    1: _RETURN,
    2: _RETURN,  # "continue the mission" was removed in 4.0, and returns since then
    3: _RETURN,  # There is no SmartRTL: the choice after it is taken.
    4: _LAND,
    5: _LAND,
    6: _RETURN,  # DO_LAND_START, or else a return
    7: _HOLD,  # brake
}
"""FS_GCS_ENABLE."""
_THROTTLE_FAILSAFE = {**_FAILSAFE, 3: _LAND, 4: _RETURN}
"""FS_THR_ENABLE, which counts 3 and 4 otherwise."""
_FENCE = {0: 1, 1: 3, 2: 5, 3: 3, 4: 2, 5: 5}
"""FENCE_ACTION: report, return, land, SmartRTL or return, brake, SmartRTL or land."""
_NEVER_S = 1e6

ALIASES = (
    Alias(
        name="ANGLE_MAX",
        ours="MPC_MAN_TILT_MAX",
        scale=_CENTI,
        unit="cdeg",
        is_integer=True,
        valid=(1000, 8000),
        default=3000,
    ),
    Alias(name="BATT_CAPACITY", ours="BAT1_CAPACITY", unit="mAh", is_integer=True),
    # A radius of 0 would turn on the spot: a circle here has at least a metre.
    Alias(
        name="CIRCLE_RADIUS",
        ours="NAV_LOITER_RAD",
        scale=_CENTI,
        unit=_CM,
        valid=(100, 200000),
        default=1000,
    ),
    Alias(
        name="DISARM_DELAY",
        ours="COM_DISARM_PRFLT",
        unit="s",
        is_integer=True,
        valid=(0, 127),
        default=10,
        special={0: -1},
    ),
    Alias(name="FENCE_ACTION", ours="GF_ACTION", is_integer=True, codes=_FENCE, default=1),
    Alias(name="FENCE_ALT_MAX", ours="GF_MAX_VER_DIST", unit="m", valid=(10, 1000), default=100),
    Alias(name="FENCE_RADIUS", ours="GF_MAX_HOR_DIST", unit="m", valid=(30, 10000), default=300),
    Alias(name="FS_GCS_ENABLE", ours="NAV_DLL_ACT", is_integer=True, codes=_FAILSAFE, default=0),
    Alias(name="FS_GCS_TIMEOUT", ours="COM_DL_LOSS_T", unit="s", valid=(2, 120), default=5),
    # 1 in ArduCopter, whose simulator has a radio that is there when overrides end.
    Alias(
        name="FS_THR_ENABLE",
        ours="NAV_RCL_ACT",
        is_integer=True,
        codes=_THROTTLE_FAILSAFE,
        default=0,
    ),
    Alias(name="GUID_TIMEOUT", ours="COM_OF_LOSS_T", unit="s", valid=(0.1, 5), default=3),
    Alias(
        name="LAND_SPEED",
        ours="MPC_LAND_SPEED",
        scale=_CENTI,
        unit=_CMPS,
        is_integer=True,
        valid=(30, 200),
        default=50,
    ),
    Alias(
        name="LOIT_SPEED",
        ours="MPC_VEL_MANUAL",
        scale=_CENTI,
        unit=_CMPS,
        valid=(20, 3500),
        default=1250,
    ),
    Alias(name="MOT_THST_HOVER", ours="MPC_THR_HOVER"),
    Alias(
        name="PILOT_SPEED_DN",
        ours="MPC_Z_VEL_MAX_DN",
        scale=_CENTI,
        unit=_CMPS,
        is_integer=True,
        valid=(0, 500),
        default=0,
        zero_means="PILOT_SPEED_UP",
    ),
    Alias(
        name="PILOT_SPEED_UP",
        ours="MPC_Z_VEL_MAX_UP",
        scale=_CENTI,
        unit=_CMPS,
        is_integer=True,
        valid=(50, 500),
        default=250,
    ),
    # Height of a takeoff that names none; 0 leaves it to the vehicle.
    Alias(
        name="PILOT_TKOFF_ALT",
        ours="MIS_TAKEOFF_ALT",
        scale=_CENTI,
        unit=_CM,
        valid=(0, 1000),
        default=0,
        special={0: 2.5},
    ),
    # 0, which turns overrides off, is not known here.
    Alias(
        name="RC_OVERRIDE_TIME",
        ours="COM_RC_LOSS_T",
        unit="s",
        valid=(0.1, 120),
        default=3,
        special={-1: _NEVER_S},
    ),
    Alias(
        name="RTL_ALT",
        ours="RTL_RETURN_ALT",
        scale=_CENTI,
        unit=_CM,
        is_integer=True,
        valid=(200, 300000),
        default=1500,
    ),
    Alias(
        name="RTL_LOIT_TIME",
        ours="RTL_LAND_DELAY",
        scale=_MILLI,
        unit="ms",
        is_integer=True,
        valid=(0, 60000),
        default=5000,
    ),
    Alias(name="SIM_WIND_DIR", ours="SIM_WIND_DIR", unit="deg"),
    Alias(name="SIM_WIND_SPD", ours="SIM_WIND_SPD", unit="m/s"),
    Alias(name="SIM_WIND_TURB", ours="SIM_WIND_TURB", unit="m/s"),
    Alias(name="SYSID_THISMAV", ours="MAV_SYS_ID", is_integer=True),
    Alias(
        name="WPNAV_ACCEL",
        ours="MPC_ACC_HOR",
        scale=_CENTI,
        unit=_CMPS2,
        valid=(50, 500),
        default=250,
    ),
    Alias(name="VISO_TYPE", ours="EKF2_EV_CTRL", is_integer=True, codes={0: 0, 1: 15}, default=0),
    Alias(name="WPNAV_JERK", ours="MPC_JERK_AUTO", unit="m/s/s/s", valid=(1, 20), default=1),
    Alias(
        name="WPNAV_RADIUS",
        ours="NAV_ACC_RAD",
        scale=_CENTI,
        unit=_CM,
        valid=(5, 1000),
        default=200,
    ),
    Alias(
        name="WPNAV_SPEED",
        ours="MPC_XY_CRUISE",
        scale=_CENTI,
        unit=_CMPS,
        valid=(10, 2000),
        default=1000,
    ),
    Alias(
        name="WPNAV_SPEED_DN",
        ours="MPC_Z_V_AUTO_DN",
        scale=_CENTI,
        unit=_CMPS,
        valid=(10, 500),
        default=150,
    ),
    Alias(
        name="WPNAV_SPEED_UP",
        ours="MPC_Z_V_AUTO_UP",
        scale=_CENTI,
        unit=_CMPS,
        valid=(10, 1000),
        default=250,
    ),
)


def defaults_of(aliases: Iterable[Alias]) -> Mapping[str, float]:
    """Our values of a flight stack's defaults."""
    named = {alias.name: alias for alias in aliases}
    told = ((alias, alias.default) for alias in named.values() if alias.default is not None)
    values: dict[str, float] = {}
    for alias, default in told:
        meant = named[alias.zero_means] if alias.zero_means and default == 0 else alias
        assert meant.default is not None, meant.name
        values[alias.ours] = meant.ours_of(meant.default)
    return values


_FIX_SOURCES = {
    0: FixSource.NONE,
    1: FixSource.OWN,  # whatever there is
    2: FixSource.OWN,  # u-blox, which the simulated receivers are after
    14: FixSource.CLIENT,
    100: FixSource.OWN,  # the simulator's
}
"""GPS_TYPE."""


def _fix_type(view: VehicleView) -> int:
    source = view.plant.outside.fix_source
    return next((number for number, named in _FIX_SOURCES.items() if named is source), 1)


def _choose_fixes(view: VehicleView, value: int) -> None:
    view.plant.outside.fix_source = _FIX_SOURCES[value]


def _turn_fence(view: VehicleView, value: int) -> None:
    view.autopilot.fence.switch = value == 1


SETTINGS = (
    # Off in ArduCopter until it is set; here an uploaded fence turns it on, as long as nobody has
    # set it.
    Setting(
        name="FENCE_ENABLE",
        choices={0: "off", 1: "on"},
        read=lambda view: int(view.autopilot.fence.is_enabled),
        write=_turn_fence,
    ),
    Setting(
        name="GPS_TYPE",
        choices={number: source.value for number, source in _FIX_SOURCES.items()},
        read=_fix_type,
        write=_choose_fixes,
    ),
)
