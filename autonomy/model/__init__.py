"""Quadrotor model: what the controller, the planner and the simulator agree on."""

from autonomy.model.quadrotor import QuadrotorParams, RotorParams

__all__ = ["QuadrotorParams", "RotorParams"]
