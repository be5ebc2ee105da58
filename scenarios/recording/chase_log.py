"""The eye behind the vehicle in a recording, as a camera that a view looks through."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from autonomy.rotation import yaw_from_quat
from scenarios.recording import layout
from scenarios.recording.columns import send_pose, sim_time
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.world import World
    from scenarios.recording.chase import ChaseEye

_PERIOD_US = 40_000
"""Simulated time between two poses of the eye: 25 a second."""
_SIZE_PX = (1600.0, 900.0)  # only the ratio counts: the camera has no image
_PLANE_M = 0.05  # size at which viewers draw the camera itself, nearly nothing


class ChaseLog:
    """Lets an eye follow the flown trajectory, and writes its poses."""

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._eye: ChaseEye | None = None

    def send(self, world: World, history: np.ndarray) -> None:
        """Write the poses of the eye along a stretch of history.

        Args:
            world: World of the flight, in which the eye looks for walls.
            history: Rows of `Plant.history`, oldest first, that continue those of the last call.
        """
        # Control ticks are 4 ms apart, so the period picks every tenth row.
        steps = np.flatnonzero(history["time_us"] % _PERIOD_US == 0)
        if not len(steps):
            return
        eye = self._eye or self._begin(world, history["quat_true_wxyz"][steps[0]])
        positions, velocities = history["position_true_enu_m"], history["velocity_true_enu_mps"]
        eyes_enu_m, quats_wxyz = [], []
        for step in steps.tolist():
            eyes_enu_m.append(eye.follow(positions[step], velocities[step], 1e-6 * _PERIOD_US))
            quats_wxyz.append(eye.quat_wxyz)
        time = sim_time(history["time_us"][steps])
        send_pose(self._stream, layout.CHASE, time, np.array(eyes_enu_m), np.array(quats_wxyz))

    def _begin(self, world: World, quat_wxyz: np.ndarray) -> ChaseEye:
        from scenarios.recording.chase import FOV_RAD, ChaseEye

        self._eye = ChaseEye(world, yaw_from_quat(quat_wxyz))
        self._log_lens(FOV_RAD)
        return self._eye

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
