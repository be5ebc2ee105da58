"""Demands of a trajectory on the vehicle, by differential flatness with rotor drag.

Samples alone would miss a peak between them. Each limit, however, bounds a convex function of a
vector that moves smoothly. Between two samples such a function exceeds neither sample's value by
more than the vector strays from the chord: dt^2 / 8 times its largest second derivative there. That
stray is added to each sample.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.model.flatness import effort
from autonomy.model.quadrotor import QuadrotorParams
from autonomy.planning.limits import FlightLimits
from autonomy.planning.trajectory import Trajectory, coefficients_from_nodes, derivative_at

# Fine for the proof; coarser while the optimiser searches, because it evaluates this often.
_PROOF_STEP_S = 0.02
_SEARCH_STEP_S = 0.06
_DRAG_STRAY = 1.2
"""Factor on the stray that allows for the drag coefficient's change between samples."""
_MOST_EXCESS = 0.5  # most that one tightening may ask for


def limit_peaks(trajectory: Trajectory, quadrotor: QuadrotorParams) -> dict[str, float]:
    """Largest values of limited quantities, between samples included, by field of `Certificate`."""
    piece, since, dt = _samples(trajectory.durations_s, _PROOF_STEP_S)
    d = [derivative_at(trajectory.coefficients, piece, since, order) for order in range(1, 6)]
    asked = effort(d[0].T, d[1].T, d[2].T, quadrotor)
    # Largest derivative near each sample; the fifth is constant within a piece.
    crackle = np.linalg.norm(d[4], axis=1)
    snap = np.linalg.norm(d[3], axis=1) + crackle * dt
    jerk = np.linalg.norm(d[2], axis=1) + snap * dt
    bend = dt**2 / 8
    drag = _DRAG_STRAY * asked.drag_per_s
    force = bend * (snap + drag * jerk)
    tilt = np.arccos(np.clip(asked.cos_tilt, -1.0, 1.0)) + force / asked.force_mps2
    rate = asked.tilt_rate_radps + bend * (crackle + drag * snap) / asked.force_mps2
    return {
        "max_speed_horizontal_mps": _peak(np.hypot(d[0][:, 0], d[0][:, 1]) + bend * jerk),
        "max_speed_vertical_mps": _peak(np.abs(d[0][:, 2]) + bend * jerk),
        "max_acceleration_mps2": _peak(np.hypot(d[1][:, 0], d[1][:, 1]) + bend * snap),
        "max_specific_thrust_mps2": _peak(asked.specific_thrust_mps2 + force),
        "max_tilt_rad": _peak(tilt),
        "max_body_rate_radps": _peak(rate),
    }


def excess(
    nodes: Float[np.ndarray, "n_plus_1 3 3"],
    durations_s: Float[np.ndarray, " n"],
    limits: FlightLimits,
    quadrotor: QuadrotorParams,
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Shares by which each piece must lower its accelerations and its body rates.

    Gravity and drag cannot be lowered, so the lack of thrust and tilt is given as a share of the
    acceleration at that point. Both shares are between 0 and `_MOST_EXCESS`; the second one may be
    zero where the first is not.
    """
    piece, since, _ = _samples(durations_s, _SEARCH_STEP_S)
    coefficients = coefficients_from_nodes(nodes, durations_s)
    v, a, j = (derivative_at(coefficients, piece, since, order) for order in (1, 2, 3))
    asked = effort(v.T, a.T, j.T, quadrotor)
    upright = asked.force_mps2 * asked.cos_tilt
    across = np.sqrt(np.maximum(asked.force_mps2**2 - upright**2, 0.0))
    slope = math.tan(limits.tilt_rad)
    own = np.linalg.norm(a, axis=1) * math.hypot(1.0, slope) + 1e-6
    lack = np.maximum(
        across - slope * upright,
        asked.specific_thrust_mps2 - limits.max_specific_thrust_mps2(quadrotor),
    )
    # First sample of each piece: `reduceat` takes the maximum of the samples from there to the
    # next.
    first = np.flatnonzero(np.diff(piece, prepend=-1))
    force = np.maximum.reduceat(np.clip(lack / own, 0.0, _MOST_EXCESS), first)
    rate = np.maximum.reduceat(asked.tilt_rate_radps, first) / limits.body_rate_radps - 1
    return force, np.clip(rate, 0.0, _MOST_EXCESS)


def _samples(
    durations_s: Float[np.ndarray, " n"], step_s: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Samples evenly spaced in each piece, both of its ends included.

    Returns:
        Piece, time since its beginning and spacing there, of each sample.
    """
    counts = np.maximum(2, np.ceil(durations_s / step_s).astype(int) + 1)
    piece = np.repeat(np.arange(len(counts)), counts)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    dt = (durations_s / (counts - 1))[piece]
    return piece, (np.arange(len(piece)) - first[piece]) * dt, dt


def _peak(values: np.ndarray) -> float:
    return float(values.max())
