"""One scalar measurement into the filter: gate, gain, covariance, injection of the error.

Vectors with independent components are fused one component after the other, each against the
state that the one before has corrected.
"""

from __future__ import annotations

import numpy as np

from autonomy.estimation.error_state import N_PAST, N_STATES
from autonomy.jit import kernel
from autonomy.rotation import quat_from_rotation_vector, quat_multiply, quat_normalise


@kernel
def scalar_update(f: np.record, innovation: float, variance: float) -> float:
    """Fuse a scalar whose Jacobian stands in `f.measurement_row`.

    Args:
        f: The filter.
        innovation: Measurement minus prediction.
        variance: Of the measurement's noise.

    Returns:
        Squared innovation over its squared gate: refused unless at most 1.
    """
    P, h, gain = f.covariance, f.measurement_row, f.gain
    s = variance
    for i in range(N_STATES):
        total = 0.0
        for j in range(N_STATES):
            total += P[i, j] * h[j]
        gain[i] = total
        s += h[i] * total
    ratio = innovation * innovation / (f.gate_sigma * f.gate_sigma * s)
    if not ratio <= 1.0:  # refuses NaN too
        return ratio
    for i in range(N_STATES):
        scaled = gain[i] / s
        for j in range(i, N_STATES):
            P[i, j] -= scaled * gain[j]
            P[j, i] = P[i, j]
    for i in range(N_STATES):
        gain[i] *= innovation / s
    inject(f, gain)
    return ratio


@kernel
def inject(f: np.record, error: np.ndarray) -> None:
    """Add an estimated error (16,) to the nominal state and to the remembered estimates."""
    for i in range(3):
        f.position_enu_m[i] += error[i]
        f.velocity_enu_mps[i] += error[3 + i]
        f.gyro_bias_flu_radps[i] += error[9 + i]
        f.accel_bias_flu_mps2[i] += error[12 + i]
        f.angular_rate_flu_radps[i] -= error[9 + i]
    f.baro_offset_m += error[15]
    quat_from_rotation_vector(error[6], error[7], error[8], f.work_quat)
    quat_multiply(f.work_quat, f.quat_wxyz, f.quat_wxyz)
    quat_normalise(f.quat_wxyz)
    for slot in range(N_PAST):
        age = ((f.tick - slot) % N_PAST) * f.dt_s
        for i in range(3):
            f.past_position_enu_m[slot, i] += error[i] - age * error[3 + i]
            f.past_velocity_enu_mps[slot, i] += error[3 + i]
