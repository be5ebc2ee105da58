"""Flight without a rotor: the vehicle aims its thrust while it spins on the others.

With one of four lost, three thrusts make a collective and the torques of roll and pitch, and the
torque of yaw is what remains: the vehicle spins up until air resistance holds it. A controller that
fought the spin would use up the thrust. This one aims the axis of spin instead of body z.

    symbol  name                                                       here
    J, J_z  moments of inertia across and along body z
    a       (J_z - J) / J
    r       rate of spin, body z                                       rate[2]
    omega   rate across body z, as the complex number p + i q
    h       direction to aim the thrust at, in the body, h_x + i h_y
    tau     torque across body z over J, as a complex number
    b       torque of the balanced thrusts over J

Balanced thrusts have the rotor opposite of the lost one at half of the other two, so that it has
room up and down. Their torque b makes the vehicle spin about an axis n near body z, along which
omega = i b / (a r) and n = omega / r. About that, with d = omega - r n and e = h - n,

    e' = -i r e + i d,     d' = i a r d + u,     tau = b + u,

whose poles are placed at -i r - s_1 (the direction, at rest in the world) and i a r - s_2 (damped
nutation) by u = -(s_1 + s_2) d + ((1 + a) r s_1 + i s_1 s_2) e. Without spin this is a control of
tilt with proportional and derivative terms.

The same law flies more than four rotors on the rest of them, whose balanced thrusts need no torque
(b = 0). Of six, the one opposite the lost one then idles, and its torque turns the vehicle slowly;
of eight, the rest brake a turn as well.

Sources: Mueller and D'Andrea 2014, "Stability and control of a quadrocopter despite the complete
loss of one, two, or three propellers", for the idea of a spinning equilibrium and of the share of
the opposite rotor; the placement of poles is ours.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.control.reference import start_reference
from autonomy.jit import kernel
from autonomy.model.dynamics import thrust_torque_matrix
from autonomy.model.layout import LEAST_ROTORS
from autonomy.model.quadrotor import QuadrotorParams

_LOST_SHARE = 0.7
"""A rotor whose measured speed is below this share of its model's does not turn as commanded."""
_LOST_TICKS = 8  # on end, so that one wrong reading loses no rotor
_OPPOSITE_SHARE = 0.5  # thrust of the rotor opposite the lost one, over that of the others
_FIRST = 1e3
"""Weight of collective, roll and pitch over that of yaw."""
_HELD_SHARE = 0.25
"""Least thrust of a rotor over the mean of the rest, with which these hold the yaw as well."""
_YAW_RADPS = 2.0
"""Rate at which a turn is braked where the yaw is held."""
_TILT_RADPS, _NUTATION_RADPS = 4.0, 12.0
"""s_1 and s_2."""
_MOST_LEAN = 0.3  # greatest |n|: the sine of the lean of the spin axis
# Gains and limits of the position loop, much softer than in whole flight: the thrust is aimed
# slowly.
_POSITION_RADPS = 0.8
_POSITION_DAMPING = 1.0
_CLIMB_RADPS = 1.6
_MOST_AHEAD_MPS2 = 2.0
_MOST_UP_MPS2 = 2.0
_INTEGRAL_GAIN = 0.15
"""Position error to acceleration a second, 1/s^3: a seventh of what would make it oscillate."""
_MOST_HELD_MPS2, _MOST_HELD_UP_MPS2 = 3.0, 1.5
"""Greatest steady force of the air that is leant against, and that is carried."""
_LEAST_SPIN_RADPS = 1e-3  # below it there is no axis of spin to speak of


def spare_allocations(quadrotor: QuadrotorParams) -> tuple[np.ndarray, np.ndarray]:
    """Compute the allocation that remains without each of n rotors.

    Returns:
        Thrusts (n, n, 4) by lost rotor, rotor, and collective and torques; the yaw column is zero
        where the other rotors cannot hold the yaw. Then the torque (n, 2) of roll and pitch that
        balanced thrusts make, over their sum, in metres.
    """
    matrix = thrust_torque_matrix(quadrotor)
    n = matrix.shape[1]
    spare, balance = np.zeros((n, n, 4)), np.zeros((n, 2))
    share_out = _among_three if n == LEAST_ROTORS else _among_many
    for lost in range(n):
        others = [rotor for rotor in range(n) if rotor != lost]
        rest = matrix[:, others]
        hubs_flu_m = np.array([quadrotor.rotors[rotor].position_flu_m for rotor in others])
        apart = np.linalg.norm(
            hubs_flu_m[:, :2] - np.array(quadrotor.rotors[lost].position_flu_m[:2]), axis=1
        )
        spare[lost, others], shares = share_out(rest, apart)
        balance[lost] = (rest[1] @ shares, rest[2] @ shares)
    return spare, balance


def _among_three(rest: np.ndarray, apart_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return allocation (3, 4) and balanced shares (3,) of three rotors, given their distances."""
    allocation = np.zeros((3, 4))
    # Rotors that lie on one line leave a matrix without an inverse.
    is_whole = np.linalg.matrix_rank(rest[:3]) == 3
    allocation[:, :3] = np.linalg.inv(rest[:3]) if is_whole else np.linalg.pinv(rest[:3])
    shares = np.where(apart_m == apart_m.max(), _OPPOSITE_SHARE, 1.0)
    return allocation, shares / shares.sum()


def _among_many(rest: np.ndarray, _apart_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return allocation (m, 4) and balanced shares (m,) of four rotors or more.

    Balanced thrusts have no torque of roll and pitch, and as little of yaw as is possible without a
    thrust below zero.
    """
    from scipy.optimize import nnls

    tilt, whole = np.linalg.pinv(rest[:3]), np.linalg.pinv(rest)
    if whole[:, 0].min() * rest.shape[1] > _HELD_SHARE:
        return whole, whole[:, 0]
    unit = np.array([1.0, 0.0, 0.0, 0.0])
    weights = np.array([_FIRST, _FIRST, _FIRST, 1.0]) / np.abs(rest).max(axis=1)
    shares, _ = nnls(weights[:, None] * rest, weights * unit)
    # The least squares leave a small torque of roll and pitch, because weights are finite; take it
    # out.
    shares += tilt @ (unit - rest @ shares)[:3]
    return np.column_stack([shares, tilt[:, 1:], np.zeros(len(shares))]), shares


@kernel
def watch_rotors(c: np.record, x: np.record) -> None:
    """Find rotors that do not turn as commanded, by the telemetry of their speeds.

    A loss is final until `forget_losses`: after one the reference restarts at the vehicle. Without
    telemetry nothing is found.
    """
    if x.has_rotor_speeds == 0:
        return
    for i in range(c.n_rotors):
        # Only rotors that are commanded well above idle speed are judged.
        is_commanded = c.rotor_model_radps[i] > 2.0 * c.idle_speed_radps[i]
        if is_commanded and x.rotor_speed_radps[i] < _LOST_SHARE * c.rotor_model_radps[i]:
            c.n_lost_ticks[i] += 1
        else:
            c.n_lost_ticks[i] = 0
        if c.n_lost_ticks[i] == _LOST_TICKS and c.is_lost[i] == 0:
            c.is_lost[i] = 1
            c.n_lost += 1
            start_reference(c, x)
            c.is_recovering = 0


@kernel
def forget_losses(c: np.record) -> None:
    """Trust every rotor again; the controller calls it at the level OFF."""
    c.n_lost = 0
    c.is_lost[:] = 0
    c.n_lost_ticks[:] = 0


@kernel
def demand_gently(c: np.record, x: np.record) -> None:
    """Demand a specific thrust (m/s^2, world) that gently follows the reference.

    An integral leans against wind, because the wind's force on a spinning vehicle is not modelled.
    The result is `c.force_enu_mps2`.
    """
    force, lag = c.force_enu_mps2, c.position_error_enu_m
    for i in range(3):
        w = _CLIMB_RADPS if i == 2 else _POSITION_RADPS
        lag[i] = c.reference_position_enu_m[i] - x.position_enu_m[i]
        e_v = c.reference_velocity_enu_mps[i] - x.velocity_enu_mps[i]
        if c.is_free[i] == 1:
            lag[i] = e_v = 0.0
        force[i] = w * w * lag[i] + 2.0 * _POSITION_DAMPING * w * e_v
    across = math.hypot(force[0], force[1])
    if across > _MOST_AHEAD_MPS2:
        force[0] *= _MOST_AHEAD_MPS2 / across
        force[1] *= _MOST_AHEAD_MPS2 / across
    force[2] = c.gravity_mps2 + min(max(force[2], -_MOST_UP_MPS2), _MOST_UP_MPS2)
    held = c.integral_mps2
    for i in range(3):
        held[i] += _INTEGRAL_GAIN * lag[i] * c.dt_s
    across = math.hypot(held[0], held[1])
    if across > _MOST_HELD_MPS2:
        held[0] *= _MOST_HELD_MPS2 / across
        held[1] *= _MOST_HELD_MPS2 / across
    held[2] = min(max(held[2], -_MOST_HELD_UP_MPS2), _MOST_HELD_UP_MPS2)
    for i in range(3):
        force[i] += held[i]


@kernel
def fly_without(c: np.record, x: np.record) -> None:
    """Aim the demanded thrust without a rotor; the thrusts are written to `c.rotor_thrust_n`.

    `c.R` must be the vehicle's attitude, and at least one rotor must be lost. If several are lost,
    the first one counts.
    """
    lost = 0
    while c.is_lost[lost] == 0:
        lost += 1
    force, R, J = c.force_enu_mps2, c.R, c.inertia_flu_kgm2
    norm = math.sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2])
    hx = (R[0, 0] * force[0] + R[1, 0] * force[1] + R[2, 0] * force[2]) / norm
    hy = (R[0, 1] * force[0] + R[1, 1] * force[1] + R[2, 1] * force[2]) / norm
    hz = (R[0, 2] * force[0] + R[1, 2] * force[1] + R[2, 2] * force[2]) / norm
    h = complex(hx, hy)
    if hz < 0.0 and abs(h) > 0.0:  # beyond 90 degrees the error no longer shrinks
        h /= abs(h)
    inertia = 0.5 * (J[0] + J[1])
    a = J[2] / inertia - 1.0
    rate = x.angular_rate_flu_radps
    r, omega = rate[2], complex(rate[0], rate[1])
    c.collective_n = c.mass_kg * norm
    n = complex(0.0, 0.0)
    if abs(r) > _LEAST_SPIN_RADPS and a > 0.0:
        b = complex(c.balance_m[lost, 0], c.balance_m[lost, 1]) * c.collective_n / inertia
        n = 1j * b / (a * r * r)
        if abs(n) > _MOST_LEAN:
            n *= _MOST_LEAN / abs(n)
    c.collective_n /= math.sqrt(1.0 - abs(n) ** 2)  # of what only its part along n lasts
    d, e = omega - r * n, h - n
    s1, s2 = _TILT_RADPS, _NUTATION_RADPS
    u = -(s1 + s2) * d + ((1.0 + a) * r * s1 + 1j * s1 * s2) * e
    tau = inertia * (u - 1j * a * r * r * n)
    yaw_nm = -J[2] * _YAW_RADPS * r
    c.torque_flu_nm[0], c.torque_flu_nm[1], c.torque_flu_nm[2] = tau.real, tau.imag, yaw_nm
    for i in range(c.n_rotors):
        thrust = c.spare_allocation[lost, i, 0] * c.collective_n
        thrust += c.spare_allocation[lost, i, 1] * tau.real
        thrust += c.spare_allocation[lost, i, 2] * tau.imag
        thrust += c.spare_allocation[lost, i, 3] * yaw_nm
        c.rotor_thrust_n[i] = min(max(thrust, c.min_rotor_thrust_n[i]), c.max_rotor_thrust_n[i])
