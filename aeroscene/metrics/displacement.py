"""Displacement of objects from raw to feasible scenes: moved, dropped and resized objects.

Objects are recognised by their ids. The scenes themselves are measured, and not the projection's
own report, so that a fault of the report cannot hide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.landform import level
from aeroscene.scene import Scene

# Smaller changes are rounding.
_MOVED_M = 0.01


class UnlikeScenesError(ValueError):
    """A scene has objects that the scene it was made from does not have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Displacement:
    """Figures over all objects of all scenes together."""

    median_m: float
    """Median distance between an object's centres before and after; dropped ones do not count."""
    mean_m: float
    p95_m: float
    moved_share: float
    """Share of objects that moved by more than a centimetre."""
    resized_share: float
    """Share of objects whose extent changed by more than a centimetre."""
    dropped_share: float
    """Share of objects that are gone."""


def displacement(before: Sequence[Scene], after: Sequence[Scene]) -> Displacement:
    """Compare raw scenes with their feasible results, both on flat ground, in the same order.

    Raises:
        UnlikeScenesError: If an object appears from nowhere or changes its category.
    """
    # The projection may add a relief, which raises objects without moving them on the plan.
    pairs = [_pairs(level(one), level(two)) for one, two in zip(before, after, strict=True)]
    none = np.zeros(0)
    moved_m = np.concatenate([none, *(np.linalg.norm(p[1] - p[0], axis=1) for p, _ in pairs)])
    resized_m = np.concatenate([none, *(np.abs(s[1] - s[0]).max(axis=1) for _, s in pairs)])
    n_before, n_after = sum(len(scene.objects) for scene in before), len(moved_m)
    median, p95 = np.quantile(moved_m, (0.5, 0.95)).tolist() if n_after else (0.0, 0.0)
    return Displacement(
        median_m=median,
        mean_m=float(moved_m.sum()) / max(n_after, 1),
        p95_m=p95,
        moved_share=float((moved_m > _MOVED_M).sum()) / max(n_after, 1),
        resized_share=float((resized_m > _MOVED_M).sum()) / max(n_after, 1),
        dropped_share=(n_before - n_after) / max(n_before, 1),
    )


def _pairs(
    before: Scene, after: Scene
) -> tuple[Float[np.ndarray, "2 n 3"], Float[np.ndarray, "2 n 3"]]:
    """Return centres and sizes, before and after, of the objects that are still there."""
    known = before.object_by_id
    for obj in after.objects:
        if obj.id not in known or known[obj.id].category_id != obj.category_id:
            raise UnlikeScenesError(
                f"scene {after.scene_id!r}: object {obj.id} is a {obj.category}; "
                f"valid: an object that scene {before.scene_id!r} has"
            )
    boxes = [[known[obj.id].bbox, obj.bbox] for obj in after.objects]
    centres = np.array([[box.p for box in pair] for pair in boxes]).reshape(-1, 2, 3)
    sizes = np.array([[box.s for box in pair] for pair in boxes]).reshape(-1, 2, 3)
    return centres.swapaxes(0, 1), sizes.swapaxes(0, 1)
