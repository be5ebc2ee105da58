"""Free air and areas of a world, in which episodes begin and targets lie."""

from __future__ import annotations

import copy
from functools import cached_property

import mujoco

from aeroscene.scene import InteractionArea
from autonomy.types import LEVEL, Vector3
from flightsim.world import World
from scenarios.mission.goals import draw_goals
from scenarios.trials.contacts import ContactFinder

_ROOM_M = 0.3
"""Distance from all solids at which an episode may begin, and targets may lie."""


class Place:
    """A world as episodes see it.

    A copy of MuJoCo's model answers whether a position is free: the vehicle's hull has a margin
    there, so that one collision check gives the room around it.

    Attributes:
        world: The world.
        areas: Areas to land on that fit the vehicle and are not its start, by their number.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        areas = draw_goals(world.scene, world.airframe, 0)
        self.areas: tuple[InteractionArea, ...] = tuple(sorted(areas, key=lambda area: area.id))
        self._model = copy.copy(world.model)
        is_hull = self._model.geom_bodyid == world.vehicle_body_id
        self._model.geom_margin[is_hull] = _ROOM_M
        self._data = mujoco.MjData(self._model)
        # Bounds and masks of bodies follow from those of their geoms.
        mujoco.mj_setConst(self._model, self._data)
        # Tested level, whatever attitude an episode then begins with.
        self._data.qpos[3:7] = LEVEL
        self._position_enu_m = self._data.qpos[:3]

    @cached_property
    def contacts(self) -> ContactFinder:
        """Finder of objects that a vehicle touched in this world, made on first use."""
        return ContactFinder(self.world)

    @property
    def start_enu_m(self) -> Vector3:
        """Position of the scene's start, ENU, m."""
        return self.world.scene.start_position_enu_m

    def is_free(self, position_enu_m: Vector3) -> bool:
        """Return whether a vehicle has room around itself at a position.

        Positions outside of the flight volume are not free.
        """
        (x, y, z), scene = position_enu_m, self.world.scene
        (x0, y0, z0), (x1, y1, z1) = scene.extent_min_enu_m, scene.extent_max_enu_m
        if not (x0 <= x <= x1 and y0 <= y <= y1 and z0 <= z <= z1):
            return False
        self._position_enu_m[:] = position_enu_m
        mujoco.mj_fwdPosition(self._model, self._data)
        return self._data.ncon == 0
