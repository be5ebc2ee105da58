"""Cost of one filter step, without the plant around it."""

from __future__ import annotations

import time

import numpy as np

from autonomy.estimation.fusion import fuse_barometer, fuse_gnss, fuse_magnetometer
from autonomy.estimation.odometry import fuse_vio
from autonomy.estimation.past import restart_past
from autonomy.estimation.predict import predict
from autonomy.estimation.terrain import fuse_range
from autonomy.estimation.wind import fuse_drag
from autonomy.jit import kernel

_N_STEPS = 5000
_N_TRIES = 5


def step_us(filters: np.ndarray, *, has_all: bool) -> float:
    """CPU time of one step of a flying filter in us, the least of several tries.

    The least, because other processes can only slow a try down.

    Args:
        filters: Filter in flight, in an array of shape (1,); it is not changed.
        has_all: True for all measurements in every step, false for each at its own rate.
    """
    least = np.inf
    for attempt in range(_N_TRIES + 1):
        f = filters.copy()
        start_s = time.process_time()
        run_filter(f, _N_STEPS, has_all)
        if attempt > 0:  # the first one may have compiled
            least = min(least, time.process_time() - start_s)
    return float(1e6 * least / _N_STEPS)


@kernel
def run_filter(filters: np.ndarray, n_steps: int, has_all: bool) -> None:
    """Step a hovering filter with consistent measurements.

    Consistent ones leave its state where it is, so that every step takes the usual way.

    Args:
        filters: Array with one filter, which is changed.
        n_steps: Number of steps.
        has_all: True for all measurements in every step, false for each at its rate in the plant.
    """
    f = filters[0]
    _hover(f)
    accel, gyro = np.zeros(3), np.zeros(3)
    # At rest an accelerometer feels the ground's push, upwards.
    accel[2] = f.gravity_mps2
    rotors = np.full(4, 800.0)
    sigma = np.full(3, 0.05)
    vio = np.zeros(3)
    field = np.zeros(3)
    for i in range(3):
        field[i] = f.field_enu_ut[i]
    for k in range(n_steps):
        predict(f, accel, gyro)
        fuse_drag(f, accel, rotors)
        if has_all or k % 25 == 0:
            fuse_gnss(f, f.position_enu_m, f.velocity_enu_mps, 30, sigma, sigma)
        if has_all or k % 10 == 0:
            fuse_vio(f, vio, 0.0, 10)
        if has_all or k % 5 == 0:
            fuse_barometer(f, f.position_enu_m[2] + f.baro_offset_m)
            fuse_magnetometer(f, field)
            fuse_range(f, 3.0, 0.02)


@kernel
def _hover(f: np.record) -> None:
    """Put the filter level and at rest, with an odometry frame that begins here."""
    f.quat_wxyz[:] = 0.0
    f.quat_wxyz[0] = 1.0
    f.velocity_enu_mps[:] = 0.0
    f.gyro_bias_flu_radps[:] = 0.0
    f.accel_bias_flu_mps2[:] = 0.0
    f.wind_enu_mps[:] = 0.0
    f.gnss_wander_enu_m[:] = 0.0
    f.vio_yaw_rad = 0.0
    for i in range(3):
        f.vio_origin_enu_m[i] = f.position_enu_m[i]
    restart_past(f)
