"""The pilot's tracks of movers in a recording: predicted boxes and velocities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from scenarios.recording import layout
from scenarios.recording.columns import set_sim_time
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    # Reading a recording should not load the planner.
    from autonomy.planning import MovingObstacles

TRACK_RGB = (255, 140, 30)


class TrackLog:
    """Writes the pilot's predictions of movers as boxes and arrows."""

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._is_empty = True

    def log(self, time_us: int, moving: MovingObstacles) -> None:
        """Write the predictions of movers from a time on.

        Args:
            time_us: Simulated time.
            moving: Predictions at that time; none clears those before.
        """
        # The end of a track is written once, not at every look.
        if len(moving) == 0 and self._is_empty:
            return
        set_sim_time(self._stream, time_us)
        self._is_empty = len(moving) == 0
        if self._is_empty:
            self._stream.log(layout.TRACKS, rr.Clear(recursive=True))
            return
        half_turn = moving.yaw_rad / 2
        zero = np.zeros_like(half_turn)
        boxes = rr.Boxes3D(
            centers=moving.position_enu_m,
            half_sizes=moving.half_extent_m + moving.radius_m[:, None],
            quaternions=np.column_stack([zero, zero, np.sin(half_turn), np.cos(half_turn)]),
            colors=TRACK_RGB,
        )
        self._stream.log(layout.TRACKS, boxes)
        arrows = rr.Arrows3D(
            origins=moving.position_enu_m, vectors=moving.velocity_enu_mps, colors=TRACK_RGB
        )
        self._stream.log(layout.TRACK_VELOCITIES, arrows)
