"""Rigid-body dynamics that follow from a quadrotor's parameters."""

from __future__ import annotations

import numpy as np

from autonomy.model.quadrotor import QuadrotorParams


def thrust_torque_matrix(quadrotor: QuadrotorParams) -> np.ndarray:
    """Matrix (4, 4) that maps rotor thrusts to collective thrust and torque about FLU axes.

    A thrust f along body z at (x, y) makes the torque (y f, -x f); the reaction to its drag makes
    -spin c f about body z.
    """
    columns = [
        (
            1.0,
            rotor.position_flu_m[1],
            -rotor.position_flu_m[0],
            -rotor.spin * rotor.torque_per_thrust_m,
        )
        for rotor in quadrotor.rotors
    ]
    return np.array(columns).T
