"""Filters in known states, with errors on their manifold."""

import numpy as np
from scipy.spatial.transform import Rotation

from autonomy.estimation import EstimatorCfg, new_filter
from autonomy.estimation.error_state import N_STATES
from autonomy.estimation.past import restart_past
from autonomy.estimation.predict import predict

DT = 0.004
G = 9.81


def filter_at(rng, **cfg):
    """A filter in a random state with a random covariance."""
    f = new_filter(EstimatorCfg(**cfg), dt_s=DT, field_enu_ut=(0.8, 21.5, -42.8), gravity_mps2=G)[0]
    f["position_enu_m"] = rng.normal(size=3)
    f["velocity_enu_mps"] = rng.normal(size=3)
    f["quat_wxyz"] = Rotation.random(random_state=int(rng.integers(2**31))).as_quat(
        scalar_first=True
    )
    f["gyro_bias_flu_radps"] = 0.01 * rng.normal(size=3)
    f["accel_bias_flu_mps2"] = 0.1 * rng.normal(size=3)
    f["wind_enu_mps"] = rng.normal(size=2)
    root = 0.1 * rng.normal(size=(N_STATES, N_STATES))
    f["covariance"] = root @ root.T
    f["is_aligned"] = 1
    return f


def add_error(f, e):
    f["position_enu_m"] += e[0:3]
    f["velocity_enu_mps"] += e[3:6]
    q = Rotation.from_rotvec(e[6:9]) * Rotation.from_quat(f["quat_wxyz"], scalar_first=True)
    f["quat_wxyz"] = q.as_quat(scalar_first=True)
    f["gyro_bias_flu_radps"] += e[9:12]
    f["accel_bias_flu_mps2"] += e[12:15]
    f["baro_offset_m"] += e[15]
    f["gnss_wander_enu_m"] += e[16:19]
    f["vio_origin_enu_m"] += e[19:22]
    f["vio_yaw_rad"] += e[22]
    f["wind_enu_mps"] += e[23:25]


def error_between(g, f):
    q = Rotation.from_quat(g["quat_wxyz"], scalar_first=True)
    turn = q * Rotation.from_quat(f["quat_wxyz"], scalar_first=True).inv()
    return np.concatenate(
        [
            g["position_enu_m"] - f["position_enu_m"],
            g["velocity_enu_mps"] - f["velocity_enu_mps"],
            turn.as_rotvec(),
            g["gyro_bias_flu_radps"] - f["gyro_bias_flu_radps"],
            g["accel_bias_flu_mps2"] - f["accel_bias_flu_mps2"],
            [g["baro_offset_m"] - f["baro_offset_m"]],
            g["gnss_wander_enu_m"] - f["gnss_wander_enu_m"],
            g["vio_origin_enu_m"] - f["vio_origin_enu_m"],
            [g["vio_yaw_rad"] - f["vio_yaw_rad"]],
            g["wind_enu_mps"] - f["wind_enu_mps"],
        ]
    )


def moving_filter(velocity, sigma=1.0, **cfg):
    """Level flight at constant velocity with an exact estimate and a wide covariance.

    The filter knows that its receiver hardly wanders.
    """
    f = filter_at(np.random.default_rng(0), **{"gnss_wander_sigma_m": (1e-3, 1e-3)} | cfg)
    for name in ("position_enu_m", "gyro_bias_flu_radps", "accel_bias_flu_mps2", "wind_enu_mps"):
        f[name] = 0.0
    f["quat_wxyz"] = (1.0, 0.0, 0.0, 0.0)
    f["velocity_enu_mps"] = velocity
    f["covariance"] = np.diag([sigma**2] * 6 + [1e-4] * 9 + [0.01] + [1e-6] * 3 + [0.0] * 6)
    restart_past(f)
    return f


def fly(f, ticks):
    """Go on without turning or speeding up."""
    for _ in range(ticks):
        predict(f, np.array([0.0, 0.0, G]), np.zeros(3))
