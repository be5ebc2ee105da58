"""What a projection has done to a scene, stage by stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.feasibility.boxes import Boxes, forbidden_overlaps
from aeroscene.feasibility.layout import Layout

OVERLAP_M = 0.01
"""Strangers that overlap deeper than this collide."""
_MOVED_M = 0.001
_TURNED_RAD = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Displacement:
    """How far the centres of objects have moved, m; those that were dropped do not count."""

    median_m: float
    mean_m: float
    p90_m: float
    """Nine of ten have moved no further."""
    max_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StageReport:
    """What one stage has changed; all of them together for the whole."""

    name: str
    displacement: Displacement
    n_moved: int
    """By more than a millimetre, whether by themselves or with what carries them."""
    n_trimmed: int
    """Whose size has changed by more than a millimetre."""
    n_turned: int
    n_dropped: int
    collision_rate_before: float
    """Share of all pairs of objects that collide: strangers, deeper than `OVERLAP_M`."""
    collision_rate_after: float
    colliding_before: float
    """Share of objects that collide with any other."""
    colliding_after: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FeasibilityReport:
    """What a projection has changed, and whether its result can be used."""

    n_objects: int
    """Before."""
    total: StageReport
    stages: tuple[StageReport, ...]
    n_landing_areas: int
    rejection: str | None
    """Why the scene cannot be used, None if it can."""

    @property
    def dropped_share(self) -> float:
        """Of the objects that were there before."""
        return self.total.n_dropped / max(1, self.n_objects)


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """A layout as it is at one moment."""

    boxes: Boxes
    is_left: Bool[np.ndarray, " n"]
    rate: float
    colliding: float


def snapshot(layout: Layout) -> Snapshot:
    """Remember a layout."""
    boxes, is_left = layout.boxes.copy(), layout.is_left.copy()
    overlaps = forbidden_overlaps(boxes, OVERLAP_M, is_left)
    count = int(is_left.sum())
    n_pairs = max(1, count * (count - 1) // 2)
    colliding = len(np.unique(overlaps.pairs)) / max(1, count)
    return Snapshot(boxes, is_left, len(overlaps.pairs) / n_pairs, colliding)


def stage_report(name: str, before: Snapshot, after: Snapshot) -> StageReport:
    """What has happened between two moments."""
    kept = after.is_left
    moved_m = np.linalg.norm(after.boxes.centre_m - before.boxes.centre_m, axis=1)[kept]
    trimmed_m = np.abs(after.boxes.half_m - before.boxes.half_m).max(axis=1, initial=0.0)[kept]
    turned = np.abs(after.boxes.yaw_rad - before.boxes.yaw_rad)[kept]
    return StageReport(
        name=name,
        displacement=_displacement(moved_m),
        n_moved=int((moved_m > _MOVED_M).sum()),
        n_trimmed=int((2 * trimmed_m > _MOVED_M).sum()),
        n_turned=int((turned > _TURNED_RAD).sum()),
        n_dropped=int((before.is_left & ~after.is_left).sum()),
        collision_rate_before=before.rate,
        collision_rate_after=after.rate,
        colliding_before=before.colliding,
        colliding_after=after.colliding,
    )


def _displacement(moved_m: Float[np.ndarray, " n"]) -> Displacement:
    if not len(moved_m):
        return Displacement(median_m=0.0, mean_m=0.0, p90_m=0.0, max_m=0.0)
    median, p90 = np.quantile(moved_m, (0.5, 0.9)).tolist()
    return Displacement(
        median_m=median, mean_m=float(moved_m.mean()), p90_m=p90, max_m=float(moved_m.max())
    )
