"""Checks that no sound scene may fail, because a person would not take it for a place.

The projection makes scenes that can be built and flown. It cannot see that a parking lot has no
access. A scene that fails here is drawn again.
"""

from __future__ import annotations

from aeroscene.metrics.places.ground import remote_parking
from aeroscene.metrics.places.roads import idle_bridges
from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene import Scene


def senseless(scene: Scene) -> str | None:
    """Return the reason why a scene is no plausible place, or None.

    Reasons are a start without a pad, a parking lot off every road, and a bridge over nothing.
    """
    if not any(obj.attributes.get("is_start") is True for obj in scene.objects):
        return "there is no pad to start from"
    view = TopView(scene)
    if remote_parking(view).any():
        return "a parking lot is off every road, sidewalk and plaza"
    if idle_bridges(view).any():
        return "a bridge is over neither water nor road"
    return None
