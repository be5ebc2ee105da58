"""Airframes, their rotor model and their battery."""

from flightsim.vehicles.airframe import (
    Airframe,
    AirframeError,
    BatteryParams,
    BodyMesh,
    BodyModel,
    CameraMount,
)
from flightsim.vehicles.catalogue import AIRFRAMES, airframe_by_name

__all__ = [
    "AIRFRAMES",
    "Airframe",
    "AirframeError",
    "BatteryParams",
    "BodyMesh",
    "BodyModel",
    "CameraMount",
    "airframe_by_name",
]
