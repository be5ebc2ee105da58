"""What tells the filter where the vehicle is: GNSS, visual-inertial odometry, motion capture."""

from __future__ import annotations

import numpy as np

from autonomy.estimation.alignment import collect_fix
from autonomy.estimation.fusion import fuse_gnss
from autonomy.estimation.motion_capture import fuse_mocap
from autonomy.estimation.odometry import fuse_vio
from autonomy.jit import kernel
from flightsim.sensors.gnss import follow_gnss, hears_satellites, sample_gnss
from flightsim.sensors.mocap import sample_mocap
from flightsim.sensors.vio import sample_vio


@kernel
def sense_satellites(
    e: np.record,
    f: np.record,
    gnss: np.record,
    rooms: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    gnss_normals: np.ndarray,
) -> None:
    """Let the receiver follow the vehicle, and fuse its fix where one is due."""
    follow_gnss(gnss, e.tick, qpos[0:3], qvel[0:3])
    if e.tick % gnss.period_ticks != 0 or e.tick <= gnss.delay_ticks or gnss.is_enabled == 0:
        return
    if not hears_satellites(gnss, rooms, qpos[0:3]):
        return
    row = gnss_normals[(e.tick - 1) % e.tick_hz // gnss.period_ticks]
    sample_gnss(gnss, e.tick, row)
    if f.is_aligned == 0:
        collect_fix(f, gnss.position_enu_m, gnss.present_sigma_m)
        return
    fuse_gnss(
        f,
        gnss.position_enu_m,
        gnss.velocity_enu_mps,
        gnss.delay_ticks,
        gnss.present_sigma_m,
        gnss.velocity_sigma_mps,
    )


@kernel
def sense_pose(
    e: np.record,
    f: np.record,
    vio: np.record,
    mocap: np.record,
    qpos: np.ndarray,
    vio_normals: np.ndarray,
    mocap_normals: np.ndarray,
) -> None:
    """Fuse the poses that arrive just now, then take the next ones."""
    if vio.is_enabled == 1:
        if vio.tick >= 0 and e.tick == vio.tick + vio.delay_ticks and f.is_aligned == 1:
            fuse_vio(f, vio.position_vio_m, vio.yaw_vio_rad, vio.delay_ticks)
        if e.tick % vio.period_ticks == 0:
            row = vio_normals[(e.tick - 1) % e.tick_hz // vio.period_ticks]
            sample_vio(vio, e.tick, qpos[0:3], qpos[3:7], row)
    if mocap.is_enabled == 1:
        if mocap.tick >= 0 and e.tick == mocap.tick + mocap.delay_ticks and f.is_aligned == 1:
            fuse_mocap(f, mocap.position_enu_m, mocap.yaw_rad, mocap.delay_ticks)
        if e.tick % mocap.period_ticks == 0:
            row = mocap_normals[(e.tick - 1) % e.tick_hz // mocap.period_ticks]
            sample_mocap(mocap, e.tick, qpos[0:3], qpos[3:7], row)
