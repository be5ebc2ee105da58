"""Errors in a run's input, which the user can mend."""

from __future__ import annotations

from aeroscene.scene import SceneError
from flightsim.cameras import CameraError
from flightsim.environment.effects import EffectError
from flightsim.environment.traffic import TrafficError
from flightsim.environment.wind import WindError
from flightsim.lidars import LidarError
from flightsim.looks.weather import WeatherError
from flightsim.mavlink.links import LinkError
from flightsim.plant.timed_failures import TimedFailureError
from flightsim.testbench import TestbenchError
from flightsim.vehicles import AirframeError
from flightsim.world import WorldError

INPUT_ERRORS = (
    SceneError,
    AirframeError,
    WorldError,
    EffectError,
    WindError,
    TrafficError,
    TimedFailureError,
    LinkError,
    CameraError,
    LidarError,
    WeatherError,
    TestbenchError,
)
"""Errors of a run whose input or machine does not allow it; each has a message of one line."""
