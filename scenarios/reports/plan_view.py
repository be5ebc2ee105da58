"""Paths of trials over the plan of their scene, in metres: x is east, y is south, as SVG has it.

The plan consists of outlines and points only, which the page's template draws, so that a reader can
zoom in without loss.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import (
    CANOPIES,
    FENCES,
    FLOORS,
    LAWNS,
    LEAFY,
    PARKING,
    ROOFS,
    ROOMS,
    SHELLS,
    TERRAIN,
    WALLS,
    WATER,
    WAYS,
)
from scenarios.reports.charts import nice_step

_MARGIN_M = 1.0
_LOOKS: Mapping[str, frozenset[str]] = {
    "water": WATER,
    "green": LAWNS | TERRAIN,
    "leaves": LEAFY,
    "road": WAYS | PARKING,
    "shell": SHELLS | ROOFS | ROOMS | FLOORS | CANOPIES,
    "wall": WALLS | FENCES,
}
"""Categories by the way they are drawn; all others are things."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """A trial's path, planned and flown."""

    trial_id: str
    success: bool
    says: str
    """Trial and verdict in words."""
    flown: str
    """Flown path, as the path data of SVG."""
    planned: str | None
    end: tuple[float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class PlanView:
    """A scene from above with paths over it."""

    scene: str
    title: str
    view_box: str
    size_m: tuple[float, float]
    shapes: Sequence[tuple[str, str]]
    """Look and points of each object's outline; the lowest objects come first."""
    areas: Sequence[str]
    """Outlines of the areas that the trials were to land on."""
    starts: Sequence[tuple[float, float]]
    ways: Sequence[Way]
    """Successful trials before failed ones, which are therefore drawn over them."""
    n_trials: int
    """Number of trials of the scene that flew; the paths may be a part of them."""
    scale_m: float
    """Length of the scale."""
    corner: tuple[float, float]
    """Lower left corner, where the scale is."""


def plan_view(
    scene: Scene, name: str, rows: Iterable[Mapping[str, Any]], n_trials: int
) -> PlanView:
    """Return the plan view of a scene and of trials in it.

    Args:
        scene: The scene.
        name: Name by which the trials know it.
        rows: Rows of trials with their tracks.
        n_trials: Number of trials of the scene that flew.
    """
    # Sorting is stable: successes first, each group in its own order.
    rows = sorted(rows, key=lambda row: not row["success"])
    (left, south, _), (right, north, _) = scene.extent_min_enu_m, scene.extent_max_enu_m
    left, south, right, north = (
        left - _MARGIN_M,
        south - _MARGIN_M,
        right + _MARGIN_M,
        north + _MARGIN_M,
    )
    wanted = {row["area"] for row in rows}
    return PlanView(
        scene=name,
        title=f"{scene.domain}{f', {scene.theme}' if scene.theme else ''}".replace("_", " "),
        # SVG's y points down, so every north coordinate is negated.
        view_box=f"{left:.2f} {-north:.2f} {right - left:.2f} {north - south:.2f}",
        size_m=(right - left, north - south),
        shapes=[(_look(each), _points(_outline(each))) for each in _from_below(scene.objects)],
        areas=[
            _points(np.array(area.polygon)) for area in scene.interaction_areas if area.id in wanted
        ],
        starts=sorted({(row["start"][0], -row["start"][1]) for row in rows}),
        ways=[_way(row) for row in rows],
        n_trials=n_trials,
        scale_m=nice_step((right - left) / 10),
        corner=(left + _MARGIN_M, -south - _MARGIN_M),
    )


def _way(row: Mapping[str, Any]) -> Way:
    flown = row["flown_enu_m"]
    east, north, _ = flown[-1]
    return Way(
        trial_id=row["trial_id"],
        success=row["success"],
        says=f"{row['trial_id']}: {row['reason']}",
        flown=_path(flown),
        planned=_path(row["planned_enu_m"]) if row["planned_enu_m"] else None,
        end=(round(east, 2), round(-north, 2)),
    )


def _from_below(objects: Iterable[SceneObject]) -> list[SceneObject]:
    """Return objects by the heights of their tops, because that is how they hide each other."""
    return sorted(objects, key=lambda each: each.bbox.p[2] + each.bbox.s[2] / 2)


def _look(each: SceneObject) -> str:
    return next((look for look, names in _LOOKS.items() if each.category in names), "thing")


# The hull of a tilted box's corners is its outline from above.
def _outline(each: SceneObject) -> np.ndarray:
    corners = each.bbox.corners()[:, :2]
    return corners[ConvexHull(corners).vertices]


def _points(outline: np.ndarray) -> str:
    return " ".join(f"{x:.2f},{-y:.2f}" for x, y, *_ in outline.tolist())


def _path(track: Sequence[Sequence[float]]) -> str:
    return "M" + " ".join(f"{x:.2f},{-y:.2f}" for x, y, _ in track)
