"""Request for a district, and the ranges of its values; loads nothing heavy.

Commands check a request before anything is loaded or laid out. Therefore this module knows how much
ground objects and buildings need, and refuses a request that could not be met.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aeroscene.ranges import SEEDS, Range
from aeroscene.scene.errors import SceneError

SIDE_M = Range(60.0, 400.0, "m")
"""Range of a side of a district."""
OBJECTS = Range(20, 2500)
"""Range of the number of objects of a district."""
HOUSES = Range(1, 150)
"""Range of the number of buildings."""
STOREYS = Range(1, 10)
"""Range of the number of furnished storeys of its tower."""
AREAS = Range(1, 1000)
"""Range of the most landing areas that it keeps."""
M2_PER_OBJECT = (40.0, 300.0)
"""Least and most ground for each object."""
_USUAL_M2_PER_OBJECT = 65.0
_LEAST_M2_PER_HOUSE, _USUAL_M2_PER_HOUSE = 350.0, 420.0
"""Least and usual ground for each building, with its share of the streets."""
_OBJECTS_PER_HOUSE = 11
"""Typical number of objects of a dwelling with its garden and its piece of street."""
_TOWER_OBJECTS = 45
"""Typical number of objects of a furnished storey."""
_PLAIN_SIDE_M = 110.0
"""Side of a district if only the tower is asked for."""


class DistrictError(SceneError):
    """A district that cannot be made; one line names the field, the value and what is valid."""


@dataclass(frozen=True, kw_only=True)
class DistrictRequest:
    """A district to be composed; fields that are None follow from the others.

    Raises:
        DistrictError: If a value is out of range, or the ground has no room for the numbers.
    """

    seed: int
    """Number that decides everything else: equal requests with equal seeds give equal scenes."""
    outline_m: tuple[float, float] | None = None
    """Sides along east and north, m."""
    n_objects: int | None = None
    """Approximate number of objects, coarse and fine."""
    n_houses: int | None = None
    """Approximate number of buildings."""
    n_storeys: int | None = None
    """Storeys of a tower that is furnished on all of them."""
    n_areas: int | None = None
    """Most landing areas."""

    def __post_init__(self) -> None:
        SEEDS.require("seed", self.seed, DistrictError)
        for side_m in self.outline_m or ():
            SIDE_M.require("outline", side_m, DistrictError)
        for name, value, limits in (
            ("objects", self.n_objects, OBJECTS),
            ("houses", self.n_houses, HOUSES),
            ("storeys", self.n_storeys, STOREYS),
            ("areas", self.n_areas, AREAS),
        ):
            if value is not None:
                limits.require(name, value, DistrictError)
        self._require_room()

    def _require_room(self) -> None:
        """Refuse more, or fewer, objects and buildings than the ground can carry."""
        ground_m2 = math.prod(self.sides_m)
        where = "outline {:g},{:g}".format(*self.sides_m)
        # Indoor objects of the tower need no ground.
        least = max(int(OBJECTS.low), math.ceil(ground_m2 / M2_PER_OBJECT[1])) + self._n_indoors
        most = min(int(OBJECTS.high), int(ground_m2 / M2_PER_OBJECT[0]) + self._n_indoors)
        if self.n_objects is not None and not least <= self.n_objects <= most:
            raise DistrictError(
                f"objects is {self.n_objects} beside {where}; valid: {least} to {most} there"
            )
        n_most = min(int(HOUSES.high), int(ground_m2 / _LEAST_M2_PER_HOUSE))
        if self.n_houses is not None and self.n_houses > n_most:
            raise DistrictError(
                f"houses is {self.n_houses} beside {where}; valid: 1 to {n_most} there"
            )

    @property
    def sides_m(self) -> tuple[float, float]:
        """Sides along east and north, m: as asked for, or as the other wishes need.

        A request without any of them gets a district of `_PLAIN_SIDE_M`.
        """
        if self.outline_m is not None:
            return self.outline_m
        ground_m2 = _PLAIN_SIDE_M**2
        if self.n_objects is not None:
            n_outdoors = max(0, self.n_objects - self._n_indoors)
            ground_m2 = _USUAL_M2_PER_OBJECT * n_outdoors
        if self.n_houses is not None:
            # Without a wish for objects the buildings alone decide on the ground.
            ground_m2 = max(ground_m2 * (self.n_objects is not None), self._houses_m2)
        side_m = min(max(SIDE_M.low, math.ceil(math.sqrt(ground_m2))), SIDE_M.high)
        return (side_m, side_m)

    @property
    def wanted_objects(self) -> int:
        """Number of objects of the district: the wish, or the usual number for its ground."""
        if self.n_objects is not None:
            return self.n_objects
        usual = round(math.prod(self.sides_m) / _USUAL_M2_PER_OBJECT)
        # Houses bring their objects with them, however little ground they have.
        usual = max(usual, _OBJECTS_PER_HOUSE * (self.n_houses or 0))
        return min(usual + self._n_indoors, int(OBJECTS.high))

    @property
    def _n_indoors(self) -> int:
        return _TOWER_OBJECTS * (self.n_storeys or 0)

    @property
    def _houses_m2(self) -> float:
        return _USUAL_M2_PER_HOUSE * (self.n_houses or 0)
