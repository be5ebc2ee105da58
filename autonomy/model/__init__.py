"""Multirotor model that controller, planner and simulator share."""

from autonomy.model.quadrotor import QuadrotorParams, RotorParams

__all__ = ["QuadrotorParams", "RotorParams"]
