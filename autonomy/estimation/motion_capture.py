"""Motion capture: position and heading in the world, to millimetres."""

from __future__ import annotations

import numpy as np

from autonomy.estimation.past import past_position, past_yaw, write_past_position_row
from autonomy.estimation.update import scalar_update, write_heading_row
from autonomy.jit import kernel
from autonomy.rotation import wrap_angle

_MOCAP_POSITION, _MOCAP_YAW = 6, 7  # rows of MEASUREMENTS


@kernel
def fuse_mocap(f: np.record, position_enu_m: np.ndarray, yaw_rad: float, age_ticks: int) -> None:
    """Fuse a pose (position (3,), heading) that was valid `age_ticks` ago, below `N_PAST`."""
    h = f.measurement_row
    worst = 0.0
    for i in range(3):
        write_past_position_row(f, h, age_ticks, i)
        innovation = position_enu_m[i] - past_position(f, age_ticks, i)
        worst = max(worst, scalar_update(f, _MOCAP_POSITION, innovation, f.mocap_variance_m2))
    h[:] = 0.0
    if write_heading_row(f.quat_wxyz, h):
        innovation = wrap_angle(yaw_rad - past_yaw(f, age_ticks))
        scalar_update(f, _MOCAP_YAW, innovation, f.mocap_yaw_variance_rad2)
    if worst <= 1.0:
        f.last_position_tick = f.tick
