"""Coarse-to-fine consistency: the distance of fine objects from their coarse regions.

The paper averages "the normalized distance between fine placements and their assigned coarse
regions", and leaves open the region and the norm. There are two readings:

- `centroid`, after the paper's guidance. The region is the coarse object whose centre is nearest.
  The distance is to its centroid, in units of the region's half diagonal. It is least if all fine
  objects sit in the middle of their regions, so it says little alone.
- `border`, ours. The region is the nearest coarse ancestor (if there is none, as above). The
  distance is how far the object's centre lies beyond the region's outline seen from above, in units
  of the outline's half diagonal. It is 0 if everything is where it belongs.

`astray_share` counts the fine objects whose centres are more than a centimetre outside.

Source: AeroScene, "Evaluation Metrics", CFC, and section "Coarse-to-Fine Guidance".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.arrays import NO_PARENT, SceneArrays, scene_arrays
from aeroscene.scene import Scene

# Objects on the border, and rounding, do not count as outside.
_ASTRAY_M = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class Consistency:
    """Distances of fine objects from their regions; means over fine objects, less is better."""

    centroid: float
    """Distance to the nearest coarse centre, in half diagonals of that coarse box."""
    border: float
    """Distance beyond the outline of the coarse ancestor, in half diagonals of the outline."""
    astray_share: float
    """Share of fine objects with their centres outside their ancestor's outline."""


def coarse_to_fine_consistency(scene: Scene) -> Consistency:
    """Return the consistency of one scene.

    A scene without fine objects has zeros; a scene without coarse ones is one region as a whole.
    """
    return consistency(scene_arrays(scene))


def consistency(arrays: SceneArrays) -> Consistency:
    """Return the consistency of a scene's arrays, see `coarse_to_fine_consistency`."""
    fine = np.flatnonzero(~arrays.is_coarse)
    if not len(fine):
        return Consistency(centroid=0.0, border=0.0, astray_share=0.0)
    centres, sizes, yaws_rad = _regions(arrays)
    nearest, apart_m = _nearest(arrays, fine, centres)
    # Row of each fine object's region, counted among the coarse objects alone.
    own = np.cumsum(arrays.is_coarse)[arrays.region[fine]] - 1
    own = np.where(arrays.region[fine] == NO_PARENT, nearest, own)
    outside_m = _outside(arrays, fine, centres[own], sizes[own], yaws_rad[own])
    return Consistency(
        centroid=float((apart_m / (np.linalg.norm(sizes[nearest], axis=1) / 2)).mean()),
        border=float((outside_m / (np.hypot(*sizes[own, :2].T) / 2)).mean()),
        astray_share=float((outside_m > _ASTRAY_M).mean()),
    )


def mean_consistency(parts: Sequence[Consistency]) -> Consistency:
    """Average consistencies over scenes, each scene alike."""
    return Consistency(
        centroid=fmean(part.centroid for part in parts),
        border=fmean(part.border for part in parts),
        astray_share=fmean(part.astray_share for part in parts),
    )


def _regions(arrays: SceneArrays) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return centre, size and yaw of the coarse objects; a scene without any is one region."""
    low, high = arrays.extent_enu_m
    coarse = np.flatnonzero(arrays.is_coarse)
    if not len(coarse):
        return (low + high)[None] / 2, (high - low)[None], np.zeros(1)
    return arrays.centre_enu_m[coarse], arrays.size_m[coarse], arrays.yaw_rad[coarse]


def _nearest(
    arrays: SceneArrays, fine: np.ndarray, centres: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the region with the nearest centre for each fine object, and its distance."""
    apart = np.linalg.norm(arrays.centre_enu_m[fine, None] - centres, axis=-1)
    return apart.argmin(axis=1), apart.min(axis=1)


def _outside(
    arrays: SceneArrays, fine: np.ndarray, centre: np.ndarray, size: np.ndarray, yaw_rad: np.ndarray
) -> Float[np.ndarray, " f"]:
    """Horizontal distance of objects' centres beyond their regions' outlines, m."""
    east, north = (arrays.centre_enu_m[fine] - centre)[:, :2].T
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    local = np.stack([cos * east + sin * north, cos * north - sin * east], axis=1)
    return np.hypot(*np.maximum(np.abs(local) - size[:, :2] / 2, 0.0).T)
