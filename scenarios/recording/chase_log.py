"""The eye behind the vehicle in a recording: a camera that a view looks through."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from autonomy.rotation import yaw_from_quat
from scenarios.recording import layout
from scenarios.recording.columns import send_pose, sim_time

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.plant import Plant
    from scenarios.recording.chase import ChaseEye

_TICK_S = 0.02
_SIZE_PX = (1600.0, 900.0)
_PLANE_M = 0.05


class ChaseLog:
    """Gathers where the eye is at every tick of the loop, and writes it now and then."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._eye: ChaseEye | None = None
        self._times_us: list[int] = []
        self._poses: list[tuple[float, ...]] = []

    def on_tick(self, plant: Plant) -> None:
        """Follow the vehicle for a tick."""
        from flightsim.sensors.cameras import look_at  # noqa: PLC0415 - as above
        from scenarios.recording.chase import FOV_RAD, ChaseEye  # noqa: PLC0415 - as above

        last = plant.history[-1]
        if self._eye is None:
            self._eye = ChaseEye(plant.world, yaw_from_quat(last["quat_true_wxyz"]))
            self._log_lens(FOV_RAD)
        position = last["position_true_enu_m"]
        eye_enu_m = self._eye.follow(position, last["velocity_true_enu_mps"], _TICK_S)
        looks = look_at(eye_enu_m, tuple(position.tolist()), FOV_RAD)
        quat = Rotation.from_matrix(looks.rotation_enu_from_optical).as_quat(scalar_first=True)
        self._times_us.append(plant.time_us)
        self._poses.append((*eye_enu_m, *quat.tolist()))

    def flush(self) -> None:
        """Write the poses that wait."""
        if self._times_us:
            poses = np.array(self._poses)
            time = sim_time(np.array(self._times_us))
            send_pose(self._stream, layout.CHASE, time, poses[:, :3], poses[:, 3:])
            self._times_us.clear()
            self._poses.clear()

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
