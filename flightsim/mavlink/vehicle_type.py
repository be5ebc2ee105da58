"""MAVLink's type of the vehicle, by its number of rotors."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.mavlink.dialect import dialect as mav
from flightsim.vehicles.airframe import Airframe

_TYPES = {
    4: mav.MAV_TYPE_QUADROTOR,
    6: mav.MAV_TYPE_HEXAROTOR,
    8: mav.MAV_TYPE_OCTOROTOR,
    10: mav.MAV_TYPE_DECAROTOR,
    12: mav.MAV_TYPE_DODECAROTOR,
}
_AUTOSTART = {6: 6001, 8: 8001}
"""PX4's default airframes (SYS_AUTOSTART) with so many rotors."""


def vehicle_type(airframe: Airframe) -> int:
    """Return the value of MAV_TYPE for a vehicle.

    Args:
        airframe: Vehicle; a number of rotors without a type of its own has the generic one.
    """
    return _TYPES.get(len(airframe.quadrotor.rotors), mav.MAV_TYPE_GENERIC_MULTIROTOR)


def vehicle_parameters(airframe: Airframe) -> Mapping[str, float]:
    """Return the parameters that state the type of the vehicle, as clients read them.

    Args:
        airframe: Vehicle; SYS_AUTOSTART is set for six and eight rotors alone.
    """
    n = len(airframe.quadrotor.rotors)
    parameters: dict[str, float] = {"MAV_TYPE": vehicle_type(airframe)}
    if n in _AUTOSTART:
        parameters["SYS_AUTOSTART"] = _AUTOSTART[n]
    return parameters
