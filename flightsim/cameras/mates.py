"""Surfaces of the other vehicles of a world, for renderers that work with triangles."""

from __future__ import annotations

import mujoco
import numpy as np

from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.looks.geom_groups import GeomGroup
from flightsim.world import World

_MIN_OPACITY = 0.5
"""Opacity below which a part is looked through, such as the discs of spinning rotors."""


class MateShapes:
    """Visible surfaces of the vehicles that share a world with one.

    Attributes:
        geoms: Geom of each triangle (t,) in the model.
    """

    def __init__(self, world: World, model: mujoco.MjModel) -> None:
        """Take the shapes from a model of the world.

        Args:
            world: The world as one vehicle has it.
            model: Model for flying or for drawing.
        """
        looks = (GeomGroup.VEHICLE_LOOKS, GeomGroup.MOVING)
        is_shown = world.is_of_mate(model) & np.isin(model.geom_group, looks)
        is_shown &= model.geom_rgba[:, 3] >= _MIN_OPACITY
        self._parts = [(g, geom_triangles(model, g)) for g in np.flatnonzero(is_shown).tolist()]
        counts = [len(part) for _, part in self._parts]
        self.geoms = np.repeat([g for g, _ in self._parts], counts).astype(np.int32)
        self._rgb = model.geom_rgba[self.geoms, :3].astype(float)

    def triangles_enu(self, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
        """Return triangles (t, 3, 3), ENU, and colours (t, 3), 0 to 1, at the poses in `data`."""
        corners = [np.zeros((0, 3, 3))]
        for geom, triangles in self._parts:
            corners.append(triangles @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
        return np.concatenate(corners), self._rgb
