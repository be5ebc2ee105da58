"""Soundness of a scene: it compiles, keeps its promises and has a place to land."""

from __future__ import annotations

from aeroscene.scene import Scene
from aeroscene.validation import validate
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world

_VEHICLE = "iris"


def fault(scene: Scene) -> str | None:
    """Return the reason why a scene cannot be flown, in one line; None if it can.

    A sound scene has no forbidden overlap, and everything is supported and in the flight volume.
    The start is free, there is at least one landing area, and each is as stated and can be reached.

    Args:
        scene: Scene to check, which takes about a quarter of a second.
    """
    # The cheap check first; compiling comes last, because it takes longest.
    if not scene.landing_areas:
        return f"scene {scene.scene_id!r} has no landing area; valid: one at least"
    findings = validate(scene)
    if findings:
        return f"scene {scene.scene_id!r}: {findings[0].detail}"
    try:
        build_world(scene, airframe_by_name(_VEHICLE))
    except ValueError as error:
        # MuJoCo's compiler names what it refuses.
        return f"scene {scene.scene_id!r} does not compile ({error})"
    return None
