"""Wind and traffic parameters for changes in flight, with ArduPilot's names where it has them.

PX4 sets the wind of its simulators in world files. ArduPilot's SIM_WIND_SPD, SIM_WIND_DIR and
SIM_WIND_TURB are the names that ground stations and scripts know.
"""

from __future__ import annotations

from dataclasses import fields, replace

from flightsim.autopilot.parameters import Parameters, ParameterSpec
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant

_TRAFFIC_SPEED = "SIM_TRAFFIC_SPD"
# The configuration names the parameter of each field in its metadata, so the two cannot part.
_WIND_FIELDS = {
    field.metadata["parameter"]: field.name for field in fields(WindCfg) if field.metadata
}


def wind_parameters(wind: WindCfg) -> dict[str, float]:
    """Values of the parameters that describe a wind, by parameter name."""
    values = {name: getattr(wind, field) for name, field in _WIND_FIELDS.items()}
    # SIM_WIND_DIR is valid from 0 to 360 degrees only.
    return values | {"SIM_WIND_DIR": wind.from_deg % 360.0}


def follow_parameters(parameters: Parameters, plant: Plant) -> None:
    """Apply an autopilot's wind and traffic parameters to the plant, now and after each change."""

    def listen(spec: ParameterSpec, value: float) -> None:
        if spec.name in _WIND_FIELDS:
            plant.wind = replace(plant.wind, **{_WIND_FIELDS[spec.name]: value})
        elif spec.name == _TRAFFIC_SPEED:
            plant.traffic_speed = value

    parameters.add_listener(listen)
