"""Perfect perception: the areas of the place that a description fits, read from the scene."""

from __future__ import annotations

import math

from aeroscene.scene import InteractionArea, Scene
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.goals import fits
from scenarios.words.goal import Description
from scenarios.words.grounding import the_one
from scenarios.words.site import site_of


def perceived_areas(
    scene: Scene, description: Description, airframe: Airframe
) -> list[InteractionArea]:
    """Return the areas of the only place that a description fits, the nearest to the start first.

    The scene graph itself is read. A vehicle with faultless segmentation and tracking would know
    the same after it had seen everything.

    Args:
        scene: Scene with its objects and the start of the flight.
        description: Meaning of the text.
        airframe: Vehicle that must fit on the areas.

    Returns:
        The areas; empty if the description fits no place, or several.
    """
    place = the_one(description, site_of(scene))
    areas = [] if place is None else [area for area in place.areas if fits(area, airframe)]
    return sorted(areas, key=lambda area: math.dist(area.centroid, scene.start_position_enu_m))
