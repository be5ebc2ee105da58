"""Wind and traffic parameters for changes in flight, with ArduPilot's names where it has them.

PX4 sets the wind of its simulators in world files; ArduPilot's SIM_WIND_SPD, SIM_WIND_DIR
and SIM_WIND_TURB are what ground stations and scripts know.
"""

from __future__ import annotations

from dataclasses import fields, replace

from flightsim.autopilot.parameters import Parameters, ParameterSpec
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant

_TRAFFIC_SPEED = "SIM_TRAFFIC_SPD"
_WIND_FIELDS = {
    field.metadata["parameter"]: field.name for field in fields(WindCfg) if field.metadata
}


def wind_parameters(wind: WindCfg) -> dict[str, float]:
    """Values of the parameters that describe a wind."""
    values = {name: getattr(wind, field) for name, field in _WIND_FIELDS.items()}
    return values | {"SIM_WIND_DIR": wind.from_deg % 360.0}


def follow_parameters(parameters: Parameters, plant: Plant) -> None:
    """Apply an autopilot's wind and traffic parameters to the plant from now on."""

    def listen(spec: ParameterSpec, value: float) -> None:
        if spec.name in _WIND_FIELDS:
            plant.wind = replace(plant.wind, **{_WIND_FIELDS[spec.name]: value})
        elif spec.name == _TRAFFIC_SPEED:
            plant.traffic_speed = value

    parameters.add_listener(listen)
