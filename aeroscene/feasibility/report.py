"""Report on the changes that a projection has made to a scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aeroscene.feasibility.boxes import boxes_of
from aeroscene.feasibility.layout import Layout


@dataclass(frozen=True, slots=True, kw_only=True)
class FeasibilityReport:
    """Changes by a projection, and whether its result can be used."""

    n_objects: int
    """Number of objects before the projection."""
    n_dropped: int
    median_moved_m: float
    """Median displacement of the centres of the objects that are left."""
    mean_moved_m: float
    rejection: str | None
    """Reason why the scene cannot be used; None if it can."""


def report_of(layout: Layout, rejection: str | None = None) -> FeasibilityReport:
    """Compare the present state of a layout with its scene.

    Args:
        layout: Layout after the projection.
        rejection: Reason why the scene cannot be used.
    """
    moved = layout.boxes.centre_m - boxes_of(layout.objects).centre_m
    moved_m = np.linalg.norm(moved, axis=1)[layout.is_present]
    return FeasibilityReport(
        n_objects=len(layout.objects),
        n_dropped=int((~layout.is_present).sum()),
        median_moved_m=float(np.median(moved_m)) if len(moved_m) else 0.0,
        mean_moved_m=float(moved_m.mean()) if len(moved_m) else 0.0,
        rejection=rejection,
    )
