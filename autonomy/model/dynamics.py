"""Rigid-body dynamics that follow from a multirotor's parameters."""

from __future__ import annotations

import numpy as np

from autonomy.model.quadrotor import QuadrotorParams, RotorParams
from autonomy.types import Vector3


def thrust_torque_matrix(quadrotor: QuadrotorParams) -> np.ndarray:
    """Return the matrix (4, n) from rotor thrusts to collective thrust and torque about FLU axes.

    A thrust f along an axis a at r lifts by a_z f and makes the torque (r x a) f. The reaction to
    its drag makes -spin c f about the axis.
    """
    columns = [(rotor.axis_flu[2], *_torque_per_thrust_m(rotor)) for rotor in quadrotor.rotors]
    return np.array(columns).T


def _torque_per_thrust_m(rotor: RotorParams) -> Vector3:
    (x, y, z), (ax, ay, az) = rotor.position_flu_m, rotor.axis_flu
    drag_m = rotor.spin * rotor.torque_per_thrust_m
    return (
        y * az - z * ay - drag_m * ax,
        z * ax - x * az - drag_m * ay,
        x * ay - y * ax - drag_m * az,
    )
