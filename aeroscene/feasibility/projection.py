"""The projection: from a sampled scene to the nearest one that can be built and flown in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np
from shapely.errors import ShapelyError

from aeroscene.areas.landing import AreaLimits, derive_interaction_areas
from aeroscene.areas.reachability import FIELD_CAP_M
from aeroscene.areas.start import AWAY_M, NO_START, grounds_of, with_start
from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.report import FeasibilityReport, report_of
from aeroscene.feasibility.stages import finished, project, project_beside
from aeroscene.feasibility.wishes.passages import too_narrow
from aeroscene.landform import raise_relief
from aeroscene.scene import Scene, SceneError
from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation import Finding, validate
from aeroscene.validation.claims import unlandable

_LAND = 0x1A2D
"""Number of the random stream of the land."""


@dataclass(frozen=True, kw_only=True)
class FeasibilityCfg:
    """Demands on a scene after its projection."""

    limits: AreaLimits | None = None
    """Most landing and perching areas of each class; unlimited by default."""
    least_landing_areas: int = 1
    """Least number of landing areas, without those beside the start; else the scene is rejected."""
    most_dropped_share: float = 0.1
    """Largest share of objects that a scene may lose; else it is rejected."""
    least_passage_m: float = 0.0
    """Least width of doors and corridors; else the scene is rejected."""
    pinned: frozenset[int] = frozenset()
    """Ids of objects that stay exactly as they are; all others move to make room, or are dropped.

    If you pin any object, list the ids of all coarse objects too. They are not pinned by
    themselves, and the stages that fit walls, floors and roofs do not run beside pinned objects."""
    land_seed: int | None = None
    """Seed of the relief that is raised in the projected scene; without it the ground stays."""
    is_validated: bool = True
    """Check the result by `aeroscene.validation`, and reject it if it fails."""


@dataclass(frozen=True, slots=True)
class Feasible:
    """A projected scene."""

    scene: Scene
    """The projected scene with its areas.

    It is the sampled scene, unchanged, if `report.rejection` names a layout that no document can
    hold, a geometry without area, or a scene without a start. After any other rejection it is the
    projected scene that was refused."""
    report: FeasibilityReport
    """Changes by the projection. `report.rejection` is the reason why the scene cannot be used;
    None if it can."""


def make_feasible(scene: Scene, cfg: FeasibilityCfg | None = None) -> Feasible:
    """Project a scene: coarse objects first, then fine ones on their bearers.

    Boxes of the sampled scene may overlap, float or lie outside of the extent; its areas are
    ignored, and derived anew from the geometry. Objects for which there is no place are dropped. A
    scene without a start pad starts on free ground from which a landing area can be reached.

    Args:
        scene: Sampled scene.
        cfg: Demands; the defaults if None.

    Returns:
        The projected scene with a report. Nothing is raised for a poor draw. Instead,
        `Feasible.report.rejection` is a text that says why the scene cannot be used; it is None if
        the scene is fine.
    """
    cfg = cfg or FeasibilityCfg()
    layout = layout_of(scene, cfg.pinned)
    try:
        (project_beside if cfg.pinned else project)(layout)
        found, findings = _with_areas(_with_land(finished(layout), cfg), cfg)
        rejection = _rejection(scene, found, findings, cfg)
    except (SceneError, ShapelyError) as error:
        # A poor draw: no document can hold the layout, or outlines have no area.
        found, rejection = scene, str(error)
    return Feasible(found, report_of(layout, rejection))


def _with_land(scene: Scene, cfg: FeasibilityCfg) -> Scene:
    if cfg.land_seed is None:
        return scene
    return raise_relief(scene, np.random.default_rng((cfg.land_seed, _LAND)))


def _with_areas(scene: Scene, cfg: FeasibilityCfg) -> tuple[Scene, list[Finding]]:
    """The scene with the areas of its geometry, and findings about it.

    A scene without a start pad gets a start as well. Areas that fail to be what they claim are left
    out, and so are their findings.
    """
    primitives = scene_primitives(scene)
    field = build_distance_field(scene, primitives=primitives, cap_m=FIELD_CAP_M)
    if _has_home(scene):
        areas = derive_interaction_areas(scene, primitives, field, cfg.limits)
        scene = replace(scene, interaction_areas=areas)
    else:
        found = with_start(scene, grounds_of(scene), cfg.limits, primitives, field)
        if found is None:
            raise SceneError(f"the scene has {NO_START}")
        scene = found
    findings = (
        validate(scene, primitives, field)
        if cfg.is_validated
        else tuple(unlandable(scene, colliding(primitives)))
    )
    wrong = {finding.area_id for finding in findings if finding.kind == "unlandable"}
    sound = [area for area in scene.interaction_areas if area.id not in wrong]
    # Numbers without gaps, as in scenes of the corpus.
    numbered = (replace(area, id=number) for number, area in enumerate(sound))
    remaining = [f for f in findings if f.area_id is None or f.area_id not in wrong]
    return replace(scene, interaction_areas=tuple(numbered)) if wrong else scene, remaining


def _rejection(
    began: Scene, found: Scene, findings: Sequence[Finding], cfg: FeasibilityCfg
) -> str | None:
    """Reason why a scene cannot be used; None if it can."""
    n_dropped, n = len(began.objects) - len(found.objects), len(began.objects)
    if n_dropped > cfg.most_dropped_share * n:
        return f"{n_dropped} of {n} objects have no place; valid: {cfg.most_dropped_share:.0%}"
    if _has_home(began) and not _has_home(found):
        return "the home pad has no place; valid: open ground of 7 m to a side"
    # Areas beside the start would be landings without a flight.
    x, y, _ = found.start_position_enu_m
    places = [area.centroid for area in found.landing_areas]
    n_away = sum(hypot(place[0] - x, place[1] - y) >= AWAY_M for place in places)
    if n_away < cfg.least_landing_areas:
        return (
            f"{n_away} landing areas away from the start can be reached; "
            f"valid: from {cfg.least_landing_areas}"
        )
    narrow = too_narrow(found, cfg.least_passage_m) if cfg.least_passage_m > 0 else None
    if narrow is not None:
        return narrow
    if findings:
        return f"{len(findings)} findings, the first: {findings[0].detail}"
    return None


def _has_home(scene: Scene) -> bool:
    return any(obj.attributes.get("is_start") is True for obj in scene.objects)
