"""Movers of a world at any time: their poses, and how they move between two images."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from flightsim.environment.motion import new_movers, place_mover
from flightsim.world import FIRST_MOVER_ID, World
from scenarios.images.labels.flow import RigidMotion


class Movers:
    """Places the movers of a world in a state of its physics."""

    def __init__(self, world: World) -> None:
        """Prepare the paths of a world's movers; there may be none."""
        self._records, self._points = new_movers(world.obstacles)

    def place(self, data: mujoco.MjData, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Put all movers where they are at a time.

        Args:
            data: State of the world, changed.
            time_s: Time since the movers began.

        Returns:
            Positions of the middles of their undersides (n, 3), and attitudes wxyz (n, 4).
        """
        for mover in self._records:
            place_mover(mover, self._points, time_s, 1.0)
        yaw_rad = self._records["yaw_rad"]
        zero = np.zeros_like(yaw_rad)
        quat = np.column_stack([np.cos(yaw_rad / 2), zero, zero, np.sin(yaw_rad / 2)])
        position = self._records["position_enu_m"].copy()
        if len(position):
            data.mocap_pos[:], data.mocap_quat[:] = position, quat
        return position, quat


def motions(
    before: tuple[np.ndarray, np.ndarray], after: tuple[np.ndarray, np.ndarray]
) -> dict[int, RigidMotion]:
    """Return the motion of each mover by its id, between two poses of all.

    Args:
        before: Positions and attitudes at first, as `Movers.place` returns them.
        after: The same later.
    """
    found = {}
    for index in range(len(before[0])):
        turns = [
            Rotation.from_quat(quats[index], scalar_first=True) for _, quats in (before, after)
        ]
        rotation = (turns[1] * turns[0].inv()).as_matrix()
        found[FIRST_MOVER_ID - index] = rotation, after[0][index] - rotation @ before[0][index]
    return found
