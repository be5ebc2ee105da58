"""ArduCopter's parameters that act here: names, units, ranges, defaults and choices.

Source: the documentation of each parameter in ArduCopter 4.5: ArduCopter/Parameters.cpp, config.h,
AC_WPNav.cpp, AC_Loiter.cpp, AC_Circle.cpp, AC_Fence.cpp, AP_GPS.cpp, AP_VisualOdom.cpp.
The table is `copter_parameters.csv`: our parameter, ArduCopter's unit in ours (`scale`), range and
default in ArduCopter's unit, and numbers that mean something else (`special`, theirs=ours).
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from importlib.resources import files

from flightsim.mavlink.personalities.personality import Alias, Setting
from flightsim.mavlink.view import VehicleView
from flightsim.plant.external_aids import FixSource

# Actions of failsafes in our table.
# FS_THR_ENABLE and FS_GCS_ENABLE number actions differently, so each has its own codes.
_NOTHING, _HOLD, _RETURN, _LAND = 0, 1, 2, 3
_FAILSAFE = {
    0: _NOTHING,
    1: _RETURN,
    2: _RETURN,  # "continue the mission" was removed in 4.0, and returns since then
    3: _RETURN,  # there is no SmartRTL: the choice after it is taken
    4: _LAND,
    5: _LAND,
    6: _RETURN,  # DO_LAND_START, or else a return
    7: _HOLD,  # brake
}
"""Codes of FS_GCS_ENABLE."""
_THROTTLE_FAILSAFE = {**_FAILSAFE, 3: _LAND, 4: _RETURN}
"""Codes of FS_THR_ENABLE, in which 3 and 4 have other meanings."""
_FENCE = {0: 1, 1: 3, 2: 5, 3: 3, 4: 2, 5: 5}
"""Codes of FENCE_ACTION: report, return, land, SmartRTL or return, brake, SmartRTL or land."""
_CODES = {
    "FENCE_ACTION": _FENCE,
    "FS_GCS_ENABLE": _FAILSAFE,
    "FS_THR_ENABLE": _THROTTLE_FAILSAFE,
    "VISO_TYPE": {0: 0, 1: 15},
}


def _read_table() -> tuple[Alias, ...]:
    text = files("flightsim.mavlink.personalities").joinpath("copter_parameters.csv").read_text()
    return tuple(_alias_from_row(row) for row in csv.DictReader(text.splitlines()))


def _alias_from_row(row: Mapping[str, str]) -> Alias:
    special = (pair.split("=") for pair in row["special"].split())
    return Alias(
        name=row["name"],
        ours=row["ours"],
        scale=float(row["scale"]),
        unit=row["unit"],
        is_integer=row["type"] == "int",
        valid=(float(row["min"]), float(row["max"])) if row["min"] else None,
        default=float(row["default"]) if row["default"] else None,
        codes=_CODES.get(row["name"], {}),
        special={float(theirs): float(ours) for theirs, ours in special},
        zero_means=row["zero_means"],
    )


ALIASES = _read_table()
"""Rows of `copter_parameters.csv`."""


def defaults_of(aliases: Iterable[Alias]) -> Mapping[str, float]:
    """Return our values for a flight stack's defaults, by our names."""
    named = {alias.name: alias for alias in aliases}
    told = ((alias, alias.default) for alias in named.values() if alias.default is not None)
    values: dict[str, float] = {}
    for alias, default in told:
        # A default of 0 that stands for another parameter means that one's default.
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
"""Sources of fixes by GPS_TYPE."""


def _fix_type(view: VehicleView) -> int:
    source = view.plant.external_aids.fix_source
    return next((number for number, named in _FIX_SOURCES.items() if named is source), 1)


def _choose_fixes(view: VehicleView, value: int) -> None:
    view.plant.external_aids.fix_source = _FIX_SOURCES[value]


def _turn_fence(view: VehicleView, value: int) -> None:
    view.autopilot.fence.switch = value == 1


SETTINGS = (
    # ArduCopter's is off until it is set. Here an uploaded fence turns it on until a client sets
    # it.
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
