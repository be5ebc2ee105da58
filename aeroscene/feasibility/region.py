"""A region of a scene: a box along the axes of the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import shapely

from aeroscene.scene import OrientedBox, Scene, SceneError, Vector3


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A box between two corners, ENU, m.

    Raises:
        SceneError: If the lower corner is not below the upper one, or x or y is infinite.
    """

    low_enu_m: Vector3
    high_enu_m: Vector3
    """Upper corner; heights may be infinite."""

    def __post_init__(self) -> None:
        for axis, low, high in zip("xyz", self.low_enu_m, self.high_enu_m, strict=True):
            is_finite = axis == "z" or (math.isfinite(low) and math.isfinite(high))
            if not (is_finite and low < high):
                raise SceneError(
                    f"region goes from {low:g} to {high:g} along {axis}; valid: finite metres, the "
                    "lower one first"
                )

    @property
    def outline(self) -> shapely.Polygon:
        """Region seen from above."""
        return shapely.box(*self.low_enu_m[:2], *self.high_enu_m[:2])

    def holds(self, point_enu_m: Vector3) -> bool:
        """Return true if a point lies within, border included.

        Args:
            point_enu_m: Point.
        """
        corners = zip(self.low_enu_m, point_enu_m, self.high_enu_m, strict=True)
        return all(low <= value <= high for low, value, high in corners)

    def is_over(self, box: OrientedBox) -> bool:
        """Return true if a box, seen from above, extends into the region."""
        outline = shapely.convex_hull(shapely.MultiPoint(box.corners()[:, :2]))
        return bool(shapely.area(shapely.intersection(outline, self.outline)) > 0)

    def share_of(self, scene: Scene) -> float:
        """Share of the flight volume's ground plan that lies in the region; 0 beside it."""
        share = 1.0
        for axis in (0, 1):
            low, high = scene.extent_min_enu_m[axis], scene.extent_max_enu_m[axis]
            inner = min(high, self.high_enu_m[axis]) - max(low, self.low_enu_m[axis])
            share *= max(0.0, inner) / (high - low)
        return share

    def __str__(self) -> str:
        """Text as users write it: `X0,Y0,X1,Y1`, with heights if they are finite."""
        numbers = [*self.low_enu_m[:2], *self.high_enu_m[:2]]
        heights = [self.low_enu_m[2], self.high_enu_m[2]]
        numbers += heights if all(map(math.isfinite, heights)) else []
        return ",".join(f"{number:g}" for number in numbers)
