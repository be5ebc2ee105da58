"""Guidance, navigation and control of a multirotor, without any simulator or MAVLink.

`__all__` names the vocabulary that the rest of the code shares: states, references, setpoints and
the parameters of a vehicle. The subpackages (planning, perception, mapping, control, estimation)
list their own public names.
"""

from autonomy.model import QuadrotorParams, RotorParams
from autonomy.types import ControlLevel, FlatReference, Setpoint, State

__all__ = ["ControlLevel", "FlatReference", "QuadrotorParams", "RotorParams", "Setpoint", "State"]
