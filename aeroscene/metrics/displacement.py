"""Displacement of objects from raw to feasible scenes: how many were moved, dropped, resized.

Objects are recognised by their ids. What is measured is the scenes themselves, not what the
projection says of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.landform import level
from aeroscene.scene import Scene

_MOVED_M = 0.01


class UnlikeScenesError(ValueError):
    """A scene with objects that the scene it was made from has not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Displacement:
    """Figures over all objects of all scenes together."""

    median_m: float
    """Median distance of an object's centres before and after; dropped ones do not count."""
    mean_m: float
    p95_m: float
    moved_share: float
    """Share of objects that moved by more than a centimetre."""
    resized_share: float
    """Share of objects whose extent changed by more than a centimetre."""
    dropped_share: float
    """Share of objects that are there no more."""


def displacement(before: Sequence[Scene], after: Sequence[Scene]) -> Displacement:
    """Compare scenes with what became of them on flat ground, in the same order.

    Raises:
        UnlikeScenesError: If an object appears from nowhere or changed its category.
    """
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
    """Centres and sizes, before and after, of the objects that are still there."""
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
