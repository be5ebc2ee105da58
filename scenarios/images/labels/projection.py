"""Points, edges and polygons of the world in the image of a pinhole camera.

Pixel (column u, row v) looks along ((u - cx) / f, (v - cy) / f, 1) in the optical frame, and whole
numbers are centres of pixels, so that the image reaches from -0.5 to width - 0.5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from shapely import MultiPoint, Polygon, box, make_valid

from scenarios.images.poses import CameraPose

NEAR_M = 0.05
"""Depth at which lines that lead behind the camera are cut."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pinhole:
    """A camera without distortion, held at a pose."""

    pose: CameraPose
    width: int
    height: int
    focal_px: float

    @property
    def centre_px(self) -> Float[np.ndarray, " 2"]:
        """Principal point: column, row."""
        return np.array([(self.width - 1) / 2, (self.height - 1) / 2])

    def rays(self) -> Float[np.ndarray, "h w 3"]:
        """Return the direction of each pixel in the optical frame, one metre deep, float64."""
        cx, cy = self.centre_px
        rays = np.ones((self.height, self.width, 3))
        rays[..., 0] = (np.arange(self.width) - cx) / self.focal_px
        rays[..., 1] = ((np.arange(self.height) - cy) / self.focal_px)[:, None]
        return rays

    def to_optical(self, points_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
        """Return points of the world in the optical frame."""
        away = points_enu_m - self.pose.position_enu_m
        return away @ self.pose.rotation_enu_from_optical

    def pixels(self, points_optical_m: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 2"]:
        """Return column and row of points in front of the camera."""
        across, depth = points_optical_m[..., :2], points_optical_m[..., 2:]
        return self.focal_px * across / depth + self.centre_px

    def hull_px(self, corners_enu_m: Float[np.ndarray, "8 3"]) -> Polygon:
        """Return the outline of a box in the image plane, as far as it is before the camera.

        Args:
            corners_enu_m: Corners as `OrientedBox.corners` orders them.
        """
        corners = self.to_optical(corners_enu_m)
        parts = [corners[corners[:, 2] >= NEAR_M]]
        for a, b in _EDGES:
            if (corners[a, 2] < NEAR_M) != (corners[b, 2] < NEAR_M):
                parts.append(_cut(corners[a], corners[b])[None])
        points = np.concatenate(parts)
        outline = MultiPoint(self.pixels(points)).convex_hull
        # Fewer than three points span no area.
        return outline if isinstance(outline, Polygon) else Polygon()

    def rings_px(self, polygon_enu_m: Float[np.ndarray, "n 3"]) -> list[np.ndarray]:
        """Return the outlines (n, 2) of a polygon in the image, cut at the image's border."""
        points = self.to_optical(polygon_enu_m)
        ring: list[np.ndarray] = []
        # Sutherland and Hodgman: the ring is cut at the near plane, corner by corner.
        for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
            if a[2] >= NEAR_M:
                ring.append(a)
            if (a[2] < NEAR_M) != (b[2] < NEAR_M):
                ring.append(_cut(a, b))
        if len(ring) < 3:
            return []
        image = box(-0.5, -0.5, self.width - 0.5, self.height - 0.5)
        seen = make_valid(Polygon(self.pixels(np.array(ring)))).intersection(image)
        parts = getattr(seen, "geoms", [seen])
        rings = [part.exterior for part in parts if isinstance(part, Polygon) and not part.is_empty]
        return [np.array(each.coords[:-1]) for each in rings]


_EDGES = [(a, a | 1 << k) for a in range(8) for k in range(3) if not a & 1 << k]
"""Pairs of a box's corners along its edges: numbers that differ in one bit."""


def _cut(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the point of a line between two points at which it meets the near plane."""
    share = (NEAR_M - a[2]) / (b[2] - a[2])
    return a + share * (b - a)
