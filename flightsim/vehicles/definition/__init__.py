"""Airframes as TOML files; docs/airframes.md explains every field."""

from flightsim.vehicles.definition.reader import read_airframe

__all__ = ["read_airframe"]
