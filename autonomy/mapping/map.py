"""The map as a pilot needs it, given before the flight or growing with depth images.

The pilot asks both kinds of map the same questions. They differ in unseen space: a given map knows
all of it, while a growing one takes it for an obstacle when a plan is proved, and for free when a
goal is chosen.
"""

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
    """Interface of a map of the obstacles, as far as they are known."""

    @property
    def is_given(self) -> bool:
        """True if the whole map was known before the flight, False if it grows with each image."""
        ...

    @property
    def obstacles(self) -> Obstacles:
        """Obstacles to avoid; in a growing map everything nearby that was not seen free."""
        ...

    @property
    def field(self) -> DistanceField:
        """Distance field of these obstacles; a wide given map has computed only parts of it."""
        ...

    def find_openings(self) -> Sequence[Opening]:
        """Doors, windows and other narrow passages, the widest first; none in a growing map."""
        ...

    def observe(self, image: DepthImage, *, is_ahead: bool = True) -> None:
        """Update the map with a depth image.

        Args:
            image: Image, posed in the map.
            is_ahead: True for the camera that looks ahead, whose images are counted as looks.
        """
        ...

    def be_at(self, position_enu_m: Vector3, radius_m: float, sole_m: float) -> None:
        """Take the air that a vehicle fills for free, down to its soles.

        Args:
            position_enu_m: Position of the vehicle's origin.
            radius_m: Radius of the sphere of air.
            sole_m: Height of the origin over the soles; the ground under them stays as it is.
        """
        ...

    def distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the distance from positions to obstacles to avoid, at most 0 within them.

        A growing map counts unseen space as an obstacle and knows no distance above its cap.
        """
        ...

    def rough_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the same for many points, quickly.

        In a growing map it is measured from the middle of the point's cell, so up to 0.22 m off.
        """
        ...

    def distance_to_seen_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the distance to known obstacles; unseen space counts as free.

        A growing map looks five cells far and returns that distance if nothing is nearer.
        """
        ...

    def static_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the distance to obstacles known not to move.

        It is 0 where nothing was ever seen free: what comes into view there need not move.
        """
        ...

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Return whether free cells may join a point of the field to the start."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenObstacles:
    """Base of the maps that are given before the flight: all obstacles are known."""

    obstacles: Obstacles
    is_given: bool = True

    def observe(self, image: DepthImage, *, is_ahead: bool = True) -> None:
        """Ignore an image: a given map has nothing to learn."""

    def be_at(self, position_enu_m: Vector3, radius_m: float, sole_m: float) -> None:
        """Ignore the place of a vehicle: all free air is known."""

    def distance_to_seen_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return exact distances from positions to the obstacles, negative within them."""
        return self.obstacles.signed_distance(points_enu_m)[0]

    # Nothing is unseen, nothing on a given map moves, and exact distances are quick enough.
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
        """Find the passages, the widest first.

        This takes 1 to 5 s of CPU, so `Surroundings` asks once and keeps the answer.
        """
        return tuple(find_openings(self.field, self.obstacles))

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Return whether free cells join a point to the start.

        Args:
            point_enu_m: Position within the field.
        """
        return bool(self.is_reachable[tuple(self.field.cells(np.array(point_enu_m)))])
