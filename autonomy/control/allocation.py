"""Rotor thrusts from collective thrust and torque, by priority if not everything fits.

A demand may exceed what the rotors can give. Clipping each rotor by itself would then turn the
torque into another one, and the vehicle could tumble. Instead the demands are met in order of
importance: roll and pitch torque first, because they decide survival, then the collective, then
yaw. Each gets the largest share of its demand that leaves the earlier ones unchanged:

    f = s_rp (A1 Mx + A2 My) + A0 T' + s_y A3 Mz,      A = allocation, columns of the inverse

with f within [min, max] for each rotor and T' the feasible collective nearest to T.
"""

from __future__ import annotations

import numpy as np

from autonomy.jit import kernel


@kernel
def allocate(
    A: np.ndarray,
    collective_n: float,
    torque_flu_nm: np.ndarray,
    low_n: np.ndarray,
    high_n: np.ndarray,
    thrust_n: np.ndarray,
) -> None:
    """Fill `thrust_n` with rotor thrusts inside [low_n, high_n] for a collective and a torque.

    Args:
        A: Shape (n, 4), the inverse of `thrust_torque_matrix`. For more than four rotors it is the
            pseudo-inverse, which gives the least sum of squared thrusts. Its first column must be
            positive.
        collective_n: Demanded collective thrust.
        torque_flu_nm: Demanded torque about the body axes, shape (3,).
        low_n: Least thrust of each rotor, shape (n,).
        high_n: Greatest thrust of each rotor, shape (n,).
        thrust_n: Receives the thrusts, shape (n,).
    """
    mx, my, mz = torque_flu_nm[0], torque_flu_nm[1], torque_flu_nm[2]
    n = len(thrust_n)
    for i in range(n):
        thrust_n[i] = A[i, 1] * mx + A[i, 2] * my
    share = _largest_tilt_share(A, thrust_n, low_n, high_n)
    # Bounds of the collective for which every rotor stays within its limits, given the tilt
    # torques.
    least, most = -np.inf, np.inf
    for i in range(n):
        thrust_n[i] *= share
        least = max(least, (low_n[i] - thrust_n[i]) / A[i, 0])
        most = min(most, (high_n[i] - thrust_n[i]) / A[i, 0])
    collective = min(max(collective_n, least), most)
    yaw_share = 1.0
    for i in range(n):
        thrust_n[i] += A[i, 0] * collective
        yaw_share = min(yaw_share, _fitting_share(thrust_n[i], A[i, 3] * mz, low_n[i], high_n[i]))
    for i in range(n):
        total = thrust_n[i] + yaw_share * A[i, 3] * mz
        thrust_n[i] = min(max(total, low_n[i]), high_n[i])  # against rounding errors only


@kernel
def _largest_tilt_share(
    A: np.ndarray, tilt_n: np.ndarray, low_n: np.ndarray, high_n: np.ndarray
) -> float:
    """Largest share s <= 1 of the tilt torques at which some collective T fits all rotors.

    Rotor i asks for low_i <= s tilt_i + A0_i T <= high_i, so for each pair the greatest lower bound
    of T must not exceed the least upper bound.
    """
    share = 1.0
    for i in range(len(tilt_n)):
        for j in range(len(tilt_n)):
            slope = tilt_n[j] / A[j, 0] - tilt_n[i] / A[i, 0]
            room = high_n[j] / A[j, 0] - low_n[i] / A[i, 0]
            if slope * share > room:
                share = max(room / slope, 0.0)
    return share


@kernel
def _fitting_share(base: float, step: float, low: float, high: float) -> float:
    """Largest s >= 0 with low <= base + s step <= high; infinite if no limit is met."""
    if step > 0.0:
        return max(0.0, (high - base) / step)
    if step < 0.0:
        return max(0.0, (low - base) / step)
    return np.inf


@kernel
def lead_command(
    speed_radps: float, wanted_radps: float, tau_s: float, response_s: float, dt_s: float
) -> float:
    """Return the speed command that makes a rotor of lag `tau_s` respond like one of `response_s`.

    The command overshoots the wanted speed by the ratio of the two exponential steps. A rotor that
    is quick enough already gets the wanted speed itself.
    """
    if tau_s <= response_s:
        return wanted_radps
    lead = (1.0 - np.exp(-dt_s / response_s)) / (1.0 - np.exp(-dt_s / tau_s))
    return speed_radps + lead * (wanted_radps - speed_radps)
