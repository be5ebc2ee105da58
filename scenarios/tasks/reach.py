"""Reachable places of a vehicle in a scene, whoever flies it.

A task must be possible, but the planner that later flies it must not decide that: a benchmark that
only asks what its own pilot can plan measures nothing beyond that pilot. So the vehicle is a sphere
here, and a place can be reached if free cells in which the sphere fits join it to the start. No
margin, no hovering height and no dynamics are asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.solids.field_cache import cached_distance_field
from aeroscene.solids.freespace import NoFreeSpaceError
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.wide_field import is_wide
from autonomy.mapping import WideMap
from autonomy.mapping.coarse_path import SEARCH_EXCESS
from autonomy.mapping.wide_map import FAR_M
from autonomy.planning import DistanceField, Obstacles, PlanningError
from autonomy.planning.corridor import straighten
from autonomy.planning.search import shortest_path
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.maps import given_map
from scenarios.mission.obstacles import distance_field, scene_obstacles
from scenarios.mission.surroundings import FIELD_RESOLUTION_M, sphere_radius_m

_MOST_ABOVE_M = 3.0
"""Height above a surface up to which the sphere must fit somewhere."""
_RISE_M = 2.2
"""Height above a surface, less the sphere's, at which a path begins and ends if there is room."""
_COMFORTABLE_M = 2.0
"""Room beside the sphere from which on a path is no longer drawn to the open: as much as pilots
usually keep from walls and from the ground."""


class NoTaskError(ValueError):
    """A scene has no task for a vehicle; the message says why."""


@dataclass(frozen=True, eq=False)
class Reach:
    """Free space of a vehicle's sphere in a scene."""

    field: DistanceField
    obstacles: Obstacles
    radius_m: float
    """Radius of the sphere that contains rotors and soles."""
    wide: WideMap | None = None
    """Map that computes the cells of a large scene on demand; `field` has them only along searched
    paths."""

    @classmethod
    def from_scene(cls, scene: Scene, airframe: Airframe) -> Reach:
        """The free space of a vehicle in a scene; the distances are kept for the next vehicle.

        Args:
            scene: The scene.
            airframe: Vehicle whose sphere must fit.

        Raises:
            NoTaskError: If the vehicle cannot leave the start of a large scene.
        """
        if is_wide(scene, FIELD_RESOLUTION_M):
            return cls._of_wide(scene, sphere_radius_m(airframe))
        primitives = scene_primitives(scene)
        voxels = cached_distance_field(scene, FIELD_RESOLUTION_M, primitives)
        return cls(
            field=distance_field(voxels),
            obstacles=scene_obstacles(scene, primitives),
            radius_m=sphere_radius_m(airframe),
        )

    @classmethod
    def _of_wide(cls, scene: Scene, radius_m: float) -> Reach:
        try:
            known = given_map(scene, radius_m, FIELD_RESOLUTION_M)
        except NoFreeSpaceError as error:
            raise NoTaskError(str(error)) from None
        wide = known if isinstance(known, WideMap) else None
        return cls(field=known.field, obstacles=known.obstacles, radius_m=radius_m, wide=wide)

    @property
    def whole_field(self) -> DistanceField:
        """Distances in the whole scene; in coarse cells if it is a large one."""
        return self.field if self.wide is None else self.wide.coarse

    def place_above(self, surface_enu_m: Vector3) -> Vector3 | None:
        """The centre of the sphere straight above a point of a surface; None if it fits nowhere.

        It is the lowest free place and the climb from there, up to a height at which the surface no
        longer counts as a narrow place, because every take-off and landing passes through it.

        Args:
            surface_enu_m: Point that the vehicle stands on.
        """
        x, y, z = surface_enu_m
        step_m = self.field.resolution_m
        rises_m = np.arange(self.radius_m, _MOST_ABOVE_M + step_m, step_m)
        column = np.stack([np.full_like(rises_m, x), np.full_like(rises_m, y), z + rises_m], axis=1)
        # A surface near the top of the flight volume has no cells above it.
        column = column[self.field.contains(column)]
        if self.wide is not None:
            # Cells of a large scene are computed before they are read.
            self.wide.build(column, 0.0)
        fits = self.field.distance_m[tuple(self.field.cells(column).T)] >= self.radius_m
        if not fits.any():
            return None
        lowest = int(np.argmax(fits))
        # Cells above the lowest free one, up to the first that is blocked.
        n_joined = int(np.argmin(np.append(fits[lowest:], False)))
        highest = min(lowest + n_joined - 1, max(lowest, int(_RISE_M / step_m)))
        first = column[highest].tolist()
        return (first[0], first[1], first[2])

    def shortest_path(
        self, start_enu_m: Vector3, goal_enu_m: Vector3
    ) -> Float[np.ndarray, "n 3"] | None:
        """The corners of the shortest path between two places of the sphere; None without any.

        Closeness costs a little, so that the path keeps to the middle of narrow places.
        """
        ends = np.array([start_enu_m, goal_enu_m])
        if self.wide is not None:
            self.wide.build_between(start_enu_m, goal_enu_m, FAR_M)
        start_cell, goal_cell = self.field.cells(ends)
        try:
            cells = shortest_path(
                self.field,
                start_cell,
                goal_cell,
                required_m=self.radius_m,
                comfortable_m=self.radius_m + _COMFORTABLE_M,
                excess=0.0 if self.wide is None else SEARCH_EXCESS,
            )
        except PlanningError:
            return None
        # Start and goal themselves instead of the centres of their cells.
        points = np.concatenate([ends[:1], self.field.centres(cells)[1:-1], ends[1:]])
        return straighten(points, self.obstacles, enough_m=self.radius_m + _COMFORTABLE_M)
