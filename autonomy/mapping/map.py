"""The map as a pilot needs it, given before the flight or growing with depth images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float

from autonomy.perception.depth_image import DepthImage
from autonomy.planning.field import DistanceField
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.openings import Opening, find_openings
from autonomy.types import Vector3


class Map(Protocol):
    """Interface of a map: the obstacles, as far as they are known."""

    @property
    def is_given(self) -> bool:
        """Whether the whole map was known before the flight; else it grows with each image."""
        ...

    @property
    def obstacles(self) -> Obstacles:
        """Obstacles to avoid; in a growing map everything nearby that was not seen free."""
        ...

    @property
    def field(self) -> DistanceField:
        """Distance field of these obstacles."""
        ...

    def find_openings(self) -> Sequence[Opening]:
        """Doors, windows and other narrow passages, the widest first; none in a growing map."""
        ...

    def observe(self, image: DepthImage, *, is_ahead: bool = True) -> None:
        """Update the map with a depth image, of the camera that looks ahead or of another one."""
        ...

    def be_at(self, position_enu_m: Vector3, radius_m: float, sole_m: float) -> None:
        """Take the air that a vehicle fills for free, down to its soles."""
        ...

    def distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance to obstacles to avoid, at most 0 within them."""
        ...

    def rough_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """The same for many points, quickly: up to a cell off in a growing map."""
        ...

    def distance_to_seen_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance to known obstacles; unseen space counts as free."""
        ...

    def static_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance to obstacles known not to move; 0 where nothing was ever known to be free."""
        ...

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Whether free cells may join a point of the field to the start."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenObstacles:
    """What maps that are given before the flight have in common: all obstacles are known."""

    obstacles: Obstacles
    is_given: bool = True

    def observe(self, image: DepthImage, *, is_ahead: bool = True) -> None:
        """Learn nothing from an image."""

    def be_at(self, position_enu_m: Vector3, radius_m: float, sole_m: float) -> None:
        """Learn nothing from the place of a vehicle."""

    def distance_to_seen_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Exact distances to the obstacles."""
        return self.obstacles.signed_distance(points_enu_m)[0]

    static_distance_m = distance_to_seen_m
    distance_m = distance_to_seen_m
    rough_distance_m = distance_to_seen_m


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenMap(GivenObstacles):
    """A map that was given before the flight."""

    field: DistanceField
    is_reachable: Bool[np.ndarray, "nx ny nz"]
    """Cells of the field that the vehicle can fly to from the start."""

    def find_openings(self) -> Sequence[Opening]:
        """Find the passages, the widest first; takes 1 to 5 s."""
        return tuple(find_openings(self.field, self.obstacles))

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Whether free cells join a point to the start."""
        return bool(self.is_reachable[tuple(self.field.cells(np.array(point_enu_m)))])
