"""Quadrotor model shared by controller, planner and simulator."""

from autonomy.model.quadrotor import QuadrotorParams, RotorParams

__all__ = ["QuadrotorParams", "RotorParams"]
