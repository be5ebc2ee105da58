"""What no place may be, though everything in it is sound: such a draw is drawn again."""

from __future__ import annotations

from aeroscene.metrics.places.ground import remote_parking
from aeroscene.metrics.places.roads import idle_bridges
from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene import Scene


def senseless(scene: Scene) -> str | None:
    """Why a scene is no place, None where it is one: no car gets to a lot, or a bridge is idle."""
    view = TopView(scene)
    if remote_parking(view).any():
        return "a parking lot is off every road, sidewalk and plaza"
    if idle_bridges(view).any():
        return "a bridge is over neither water nor road"
    return None
