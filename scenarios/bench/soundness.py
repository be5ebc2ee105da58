"""Soundness of a scene: it compiles, keeps its promises and has a place to land."""

from __future__ import annotations

from aeroscene.scene import Scene
from aeroscene.validation import validate
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world

_VEHICLE = "iris"


def fault(scene: Scene) -> str | None:
    """Reason why a scene cannot be flown, in one line; None if it can.

    It has no forbidden overlap, everything is supported and lies in the flight volume, the start is
    free, every landing area can be reached and is as stated, and there is at least one.
    """
    if not scene.landing_areas:
        return f"scene {scene.scene_id!r} has no landing area; valid: one at least"
    findings = validate(scene)
    if findings:
        return f"scene {scene.scene_id!r}: {findings[0].detail}"
    try:
        build_world(scene, airframe_by_name(_VEHICLE))
    except ValueError as error:
        # MuJoCo's compiler says what it refuses.
        return f"scene {scene.scene_id!r} does not compile ({error})"
    return None
