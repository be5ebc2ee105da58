"""Guidance, navigation and control, without simulator or MAVLink.

The names of `__all__` are the vocabulary that everything else speaks; planning, perception,
mapping, control and estimation each say their own.
"""

from autonomy.model import QuadrotorParams, RotorParams
from autonomy.types import ControlLevel, FlatReference, Setpoint, State

__all__ = ["ControlLevel", "FlatReference", "QuadrotorParams", "RotorParams", "Setpoint", "State"]
