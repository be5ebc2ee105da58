"""Geometric tracking control of a multirotor: from a setpoint and an estimate to rotor speeds."""

from autonomy.control.cfg import ControllerCfg
from autonomy.control.record import CONTROLLER_DTYPE, SETPOINT_DTYPE, STATE_DTYPE, new_controller

__all__ = ["CONTROLLER_DTYPE", "SETPOINT_DTYPE", "STATE_DTYPE", "ControllerCfg", "new_controller"]
