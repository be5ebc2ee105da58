"""Requirements of each class of drones on a place, and the number of places that a scene keeps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians

import numpy as np

from aeroscene.scene import AreaKind, DroneClass, InteractionArea


@dataclass(frozen=True, slots=True, kw_only=True)
class AreaNeeds:
    """Requirements on a place, m."""

    surface_radius_m: float
    """Radius of even surface around the touchdown point, for the feet and the scatter of a
    landing."""
    body_radius_m: float
    """Radius free of objects that are higher than the legs."""
    flight_radius_m: float
    """Radius of a ball that is free all the way from the start."""
    clearance_m: float
    """Free height above the surface."""

    def is_entered(self, reached: np.ndarray, cell: tuple[int, int, int], edge_m: float) -> bool:
        """True if a flood of free cells enters the clear column above a cell.

        Args:
            reached: Cells that the flood has reached.
            cell: Cell of the place.
            edge_m: Edge of the cells.
        """
        i, j, k = cell
        return bool(reached[i, j, k : k + int(self.rise_m(edge_m) / edge_m) + 1].any())

    def rise_m(self, edge_m: float) -> float:
        """Return the height of the lowest ball above the surface, for cells of some edge."""
        # Rounding to cells takes up to two of them.
        return max(self.clearance_m, self.flight_radius_m + 2 * edge_m)


# For comparison: a Hummingbird reaches 0.4 m from its centre, and an Iris 0.45 m.
NEEDS: Mapping[DroneClass, AreaNeeds] = {
    "large": AreaNeeds(
        surface_radius_m=2.6, body_radius_m=2.6, flight_radius_m=1.0, clearance_m=1.5
    ),
    "medium": AreaNeeds(
        surface_radius_m=1.2, body_radius_m=1.2, flight_radius_m=0.7, clearance_m=1.5
    ),
    "small": AreaNeeds(
        surface_radius_m=0.4, body_radius_m=0.6, flight_radius_m=0.45, clearance_m=1.5
    ),
}
"""Requirements for landing, largest class first."""

PERCH_NEEDS = AreaNeeds(
    surface_radius_m=0.22, body_radius_m=0.45, flight_radius_m=0.45, clearance_m=1.0
)
"""Requirements for perching. The feet of a Hummingbird stand on a circle of 0.17 m."""

MAX_SLOPE_RAD = radians(10.0)
"""Steepest surface: the limit of the pilot's perception, `autonomy.perception.LandingNeeds`."""
STEP_M = 0.008
"""A lower step above a surface is no obstacle: it tips an Iris by under 2 degrees."""
LEGS_M = 0.1
"""Objects lower than this beside a landed drone stay below its body."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AreaLimits:
    """Greatest numbers of areas that a scene keeps; if there are more, well spread ones stay."""

    small: int
    medium: int
    large: int
    perching: int


def needs_of(kind: AreaKind, drone_class: DroneClass) -> AreaNeeds:
    """Return the requirements that an area of a kind and class claims to meet."""
    return PERCH_NEEDS if kind == "perching" else NEEDS[drone_class]


def area_needs(area: InteractionArea) -> AreaNeeds:
    """Return the requirements that an area claims to meet."""
    return needs_of(area.kind, area.drone_class)
