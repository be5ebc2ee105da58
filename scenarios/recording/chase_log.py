"""The eye behind the vehicle in a recording: a camera that a view looks through."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from autonomy.rotation import yaw_from_quat
from scenarios.recording import layout
from scenarios.recording.columns import send_pose, sim_time

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.plant import Plant
    from scenarios.recording.chase import ChaseEye

_PERIOD_US = 40_000
"""Simulated time between two poses of the eye: 25 a second."""
_SIZE_PX = (1600.0, 900.0)
_PLANE_M = 0.05


class ChaseLog:
    """Gathers the eye's pose at every tick of the loop, and writes the poses now and then."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._eye: ChaseEye | None = None
        self._times_us: list[int] = []
        self._eyes_and_targets: list[tuple[float, ...]] = []

    def on_tick(self, plant: Plant) -> None:
        """Follow the vehicle for a tick."""
        from scenarios.recording.chase import FOV_RAD, ChaseEye  # noqa: PLC0415 - as above

        if plant.time_us % _PERIOD_US:
            return
        last = plant.history[-1]
        if self._eye is None:
            self._eye = ChaseEye(plant.world, yaw_from_quat(last["quat_true_wxyz"]))
            self._log_lens(FOV_RAD)
        position = last["position_true_enu_m"]
        eye_enu_m = self._eye.follow(position, last["velocity_true_enu_mps"], 1e-6 * _PERIOD_US)
        self._times_us.append(plant.time_us)
        self._eyes_and_targets.append((*eye_enu_m, *position.tolist()))

    def flush(self) -> None:
        """Write the poses that wait."""
        if self._times_us:
            eyes_m, targets_m = np.hsplit(np.array(self._eyes_and_targets), 2)
            time = sim_time(np.array(self._times_us))
            quats = _quats_enu_from_optical(targets_m - eyes_m)
            send_pose(self._stream, layout.CHASE, time, eyes_m, quats)
            self._times_us.clear()
            self._eyes_and_targets.clear()

    def _log_lens(self, vertical_fov_rad: float) -> None:
        width, height = _SIZE_PX
        lens = rr.Pinhole(
            focal_length=height / 2 / math.tan(vertical_fov_rad / 2),
            width=width,
            height=height,
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=_PLANE_M,
            color=(0, 0, 0, 0),
        )
        self._stream.log(layout.CHASE, lens, static=True)


def _quats_enu_from_optical(ahead_enu: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 4"]:
    """Attitudes wxyz of upright cameras that look along these directions, none of them vertical."""
    ahead = ahead_enu / np.linalg.norm(ahead_enu, axis=1, keepdims=True)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    columns = np.stack([right, np.cross(ahead, right), ahead], axis=2)
    return Rotation.from_matrix(columns).as_quat(scalar_first=True)
