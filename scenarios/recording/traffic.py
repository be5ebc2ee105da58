"""Movers in a recording: shapes once, poses at every tick of the loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from scenarios.recording import layout
from scenarios.recording.columns import send_pose, sim_time
from scenarios.recording.entity_stream import EntityStream
from scenarios.recording.scene import flat_mesh

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.plant import Plant


class TrafficLog:
    """Gathers the true poses of movers, and writes them at each `flush`."""

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._entities: list[str] = []
        self._times_us: list[int] = []
        self._poses: list[np.ndarray] = []

    def on_tick(self, plant: Plant) -> None:
        """Sample the movers after a tick.

        Args:
            plant: Plant of the first vehicle; all vehicles share its movers.
        """
        if not plant.world.obstacles:
            return
        # The shapes belong to the plant's world, which is known from the first tick on.
        if not self._entities:
            self._log_shapes(plant)
        states = plant.obstacles_true
        # The meshes have their origin on the ground, the states theirs in the middle.
        ground_m = states.position_enu_m - states.size_m * (0.0, 0.0, 0.5)
        self._times_us.append(plant.time_us)
        self._poses.append(np.column_stack([ground_m, states.yaw_rad]))

    def flush(self) -> None:
        """Write the buffered poses."""
        if not self._times_us:
            return
        time = sim_time(np.array(self._times_us))
        poses = np.array(self._poses)
        self._times_us.clear()
        self._poses.clear()
        for index, entity in enumerate(self._entities):
            send_pose(self._stream, entity, time, poses[:, index, :3], _turned(poses[:, index, 3]))

    def _log_shapes(self, plant: Plant) -> None:
        from flightsim.environment.movers import mover_name

        obstacles = plant.world.obstacles
        for index, looks in enumerate(plant.world.movers.looks):
            entity = layout.mover(mover_name(index, obstacles))
            self._entities.append(entity)
            mesh = flat_mesh(looks.corners_m, np.round(255 * looks.rgb))
            self._stream.log(entity, mesh, static=True)


def _turned(yaw_rad: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 4"]:
    """Return the quaternions wxyz of turns about the vertical."""
    zero = np.zeros_like(yaw_rad)
    return np.column_stack([np.cos(yaw_rad / 2), zero, zero, np.sin(yaw_rad / 2)])
