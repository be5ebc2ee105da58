"""Airframes, their rotor model and their battery."""

from flightsim.vehicles.airframe import Airframe, BatteryParams, CameraMount
from flightsim.vehicles.catalogue import AIRFRAMES, AirframeError, airframe_by_name

__all__ = [
    "AIRFRAMES",
    "Airframe",
    "AirframeError",
    "BatteryParams",
    "CameraMount",
    "airframe_by_name",
]
