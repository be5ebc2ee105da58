"""Layouts of rotors that can be flown, and how they share a demand of thrust and torque.

A vehicle whose rotors do not tilt by themselves needs at least four of them, because each adds one
thrust, and collective thrust, roll, pitch and yaw are four demands. A file of an airframe may
describe anything, so a layout is checked before a world is built. The checks reject what could
hover on paper only.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from autonomy.model.dynamics import thrust_torque_matrix
from autonomy.model.quadrotor import GRAVITY_MPS2, MAX_ROTORS, QuadrotorParams

LEAST_ROTORS = 4
_DEMANDS = ("collective thrust", "roll", "pitch", "yaw")
_LEAST_GAIN = 1e-3
"""A demand counts as met if its singular value is at least this share of the greatest."""
_LEAST_SHARE = 0.2
"""Least thrust of a rotor in hover, over the mean of all: it must be able to lose some."""
_MOST_HOVER_SHARE = 0.8
"""Greatest share of its thrust that a rotor may spend on hovering; the rest is for control."""
_MOST_SIDEWAYS = 0.02
"""Greatest sideways force of rotors that hover level, over the weight."""


class LayoutError(ValueError):
    """Rotors that cannot hold or turn the vehicle; one line says why and what would be valid."""


def inverse_allocation(quadrotor: QuadrotorParams) -> Float[np.ndarray, "n 4"]:
    """Return rotor thrusts (n, 4) from collective thrust and torques.

    This is the inverse of `thrust_torque_matrix`. For more than four rotors it is the
    pseudo-inverse, whose thrusts have the least sum of squares.
    """
    matrix = thrust_torque_matrix(quadrotor)
    return np.linalg.inv(matrix) if matrix.shape[1] == LEAST_ROTORS else np.linalg.pinv(matrix)


def check_layout(quadrotor: QuadrotorParams) -> None:
    """Check that the rotors can hover and be controlled about every axis.

    Raises:
        LayoutError: If they cannot; the message names the rotor or the demand, and a valid range.
    """
    n = len(quadrotor.rotors)
    if not LEAST_ROTORS <= n <= MAX_ROTORS:
        raise LayoutError(
            f"{n} rotors do not control collective thrust, roll, pitch and yaw; valid: "
            f"{LEAST_ROTORS} to {MAX_ROTORS}"
        )
    _check_rank(thrust_torque_matrix(quadrotor))
    hover = inverse_allocation(quadrotor)[:, 0]
    weight_n = quadrotor.mass_kg * GRAVITY_MPS2
    for number, (rotor, share) in enumerate(zip(quadrotor.rotors, hover, strict=True), start=1):
        if share * n < _LEAST_SHARE:
            raise LayoutError(
                f"rotor {number} would carry {share:.1%} of the weight in level hover; valid: at "
                f"least {_LEAST_SHARE / n:.1%}, with the centre of mass well between the rotors"
            )
        most_n = rotor.thrust_constant * rotor.max_speed_radps**2
        if share * weight_n > _MOST_HOVER_SHARE * most_n:
            raise LayoutError(
                f"rotor {number} needs {share * weight_n:.3g} N in hover, of at most {most_n:.3g} "
                f"N; valid: at most {_MOST_HOVER_SHARE:.0%} of it"
            )
    across = hover @ np.array([rotor.axis_flu[:2] for rotor in quadrotor.rotors])
    if float(np.linalg.norm(across)) > _MOST_SIDEWAYS:
        raise LayoutError(
            f"the rotors push sideways with {np.linalg.norm(across):.1%} of the weight in level "
            f"hover; valid: axes that balance to {_MOST_SIDEWAYS:.0%}"
        )


def _check_rank(matrix: Float[np.ndarray, "4 n"]) -> None:
    """Check that each demand can be met alone; lengths count by the greatest lever about an axis.

    The diagonal of M M^+ is the share of each demand that the rotors can meet without the others.

    Raises:
        LayoutError: Naming the first demand that cannot be met.
    """
    levers_m = np.abs(matrix).max(axis=1)
    scaled = matrix / np.where(levers_m > 0.0, levers_m, 1.0)[:, None]
    met = scaled @ np.linalg.pinv(scaled, rcond=_LEAST_GAIN)
    # From the last demand to the first: if several are missing, the message names yaw before roll.
    for name, share in reversed(list(zip(_DEMANDS, np.diag(met), strict=True))):
        if share < 1.0 - 1e-6:
            raise LayoutError(
                f"the rotors have no control of {name} of its own; valid: rotors of both spins, "
                "not on one line"
            )
