"""Landing areas of a frame: outlines in the image, and how much of them is seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, Int

from aeroscene.scene import InteractionArea
from scenarios.images.labels.objects import LEAST_PIXELS
from scenarios.images.labels.projection import Pinhole
from scenarios.images.labels.rle import encode_mask

_ON_SURFACE_M = 0.10
"""Distance from the area's plane within which a pixel shows the area; ground is not quite flat."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenArea:
    """A landing area in an image."""

    area: InteractionArea
    rings_px: list[np.ndarray]
    """Outlines in the image, cut at its border."""
    n_inside: int
    """Number of pixels within the outlines."""
    rows: Int[np.ndarray, " n"]
    """Rows of the pixels within the outlines that show the surface, and nothing before it."""
    columns: Int[np.ndarray, " n"]


def seen_areas(
    camera: Pinhole, depth_m: Float[np.ndarray, "h w"], areas: Sequence[InteractionArea]
) -> list[SeenArea]:
    """Return the areas whose surface a camera sees.

    Args:
        camera: Camera of the frame.
        depth_m: Depth of the frame, inf in the sky.
        areas: All areas of the scene.
    """
    found = (_seen(camera, depth_m, area) for area in areas)
    return [seen for seen in found if seen is not None and len(seen.rows) >= LEAST_PIXELS]


def _seen(
    camera: Pinhole, depth_m: Float[np.ndarray, "h w"], area: InteractionArea
) -> SeenArea | None:
    corners = np.array(area.polygon)
    normal = _normal(corners)
    away_m = float((camera.pose.position_enu_m - corners.mean(axis=0)) @ normal)
    # An area is seen from above only.
    rings = camera.rings_px(corners) if away_m > 0.0 else []
    if not rings:
        return None
    rows, columns = _within(camera, rings)
    x = (columns - camera.centre_px[0]) / camera.focal_px
    y = (rows - camera.centre_px[1]) / camera.focal_px
    local = camera.pose.rotation_enu_from_optical.T @ normal
    # Height of the pixel's point above the plane: the eye's, less what the ray descends.
    descent = x * local[0] + y * local[1] + local[2]
    depths_m = depth_m[rows, columns]
    # In the sky, a ray along the plane would give no number.
    off_m = np.abs(away_m + np.where(np.isinf(depths_m), 1e9, depths_m) * descent)
    is_on = off_m < _ON_SURFACE_M
    return SeenArea(
        area=area,
        rings_px=rings,
        n_inside=len(rows),
        rows=rows[is_on],
        columns=columns[is_on],
    )


def _within(camera: Pinhole, rings_px: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and columns of the pixels within outlines."""
    # Outlines reach half a pixel beyond the centres of pixels at the border.
    last = (camera.width - 1, camera.height - 1)
    rings = [np.rint(np.clip(ring, 0, last)).astype(np.int32) for ring in rings_px]
    points = np.concatenate(rings)
    # Drawn in the smallest image that holds them, because most areas are small.
    low = points.min(axis=0)
    width, height = (points.max(axis=0) - low + 1).tolist()
    inside = np.zeros((height, width), np.uint8)
    cv2.fillPoly(inside, [ring - low for ring in rings], 1)
    rows, columns = np.nonzero(inside)
    return rows + low[1], columns + low[0]


def area_labels(camera: Pinhole, seen: Sequence[SeenArea]) -> list[dict[str, Any]]:
    """Return the labels of landing and perching areas in a frame.

    Args:
        camera: Camera of the frame.
        seen: Areas that it sees.
    """
    return [_label(camera, each) for each in seen]


def _label(camera: Pinhole, seen: SeenArea) -> dict[str, Any]:
    area = seen.area
    rows, columns = seen.rows, seen.columns
    left, top = int(columns.min()), int(rows.min())
    mask = np.zeros((camera.height, camera.width), bool)
    mask[rows, columns] = True
    centre = camera.to_optical(np.array([area.centroid]))
    in_front = bool(centre[0, 2] > 0.0)
    return {
        "id": area.id,
        "kind": area.kind,
        "drone_class": area.drone_class,
        "surface": area.surface,
        "object_id": area.object_id,
        "polygons_px": [np.round(ring, 2).tolist() for ring in seen.rings_px],
        "centroid_px": np.round(camera.pixels(centre)[0], 2).tolist() if in_front else None,
        "pixels": len(rows),
        "share_seen": round(len(rows) / seen.n_inside, 3),
        "box_px": [left, top, int(columns.max()) - left + 1, int(rows.max()) - top + 1],
        "polygon_enu_m": [list(corner) for corner in area.polygon],
        "centroid_enu_m": list(area.centroid),
        "radius_m": area.radius,
        "slope_rad": area.slope_rad,
        "rle": encode_mask(mask),
    }


def _normal(corners: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " 3"]:
    """Return the upward unit normal of a polygon by Newell's method."""
    across = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    return across / np.linalg.norm(across)
