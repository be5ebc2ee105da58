"""Rotor thrusts from collective thrust and torque, by priority if not everything fits.

Roll and pitch torque come first, since they decide survival; then the collective; then yaw. Each
gets the largest share of its demand that leaves the earlier ones unchanged:

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
    """Fill `thrust_n` (n,) with thrusts inside [low_n, high_n] for a collective and a torque (3,).

    A (n, 4) is the inverse of `thrust_torque_matrix`, for more than four rotors the pseudo-inverse,
    which shares with the least squares of thrusts; its first column is positive.
    """
    mx, my, mz = torque_flu_nm[0], torque_flu_nm[1], torque_flu_nm[2]
    n = len(thrust_n)
    for i in range(n):
        thrust_n[i] = A[i, 1] * mx + A[i, 2] * my
    share = _largest_tilt_share(A, thrust_n, low_n, high_n)
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
    """Largest s <= 1 for which some collective T fits: low <= s tilt + A0 T <= high."""
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
    """Largest s >= 0 with low <= base + s step <= high, infinite without a limit."""
    if step > 0.0:
        return max(0.0, (high - base) / step)
    if step < 0.0:
        return max(0.0, (low - base) / step)
    return np.inf


@kernel
def lead_command(
    speed_radps: float, wanted_radps: float, tau_s: float, response_s: float, dt_s: float
) -> float:
    """Speed command that moves a rotor of lag tau as a rotor of lag `response_s` would move."""
    if tau_s <= response_s:
        return wanted_radps
    lead = (1.0 - np.exp(-dt_s / response_s)) / (1.0 - np.exp(-dt_s / tau_s))
    return speed_radps + lead * (wanted_radps - speed_radps)
