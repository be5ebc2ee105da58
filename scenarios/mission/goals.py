"""Start and goal of a flight: as the user names them, or as the seed draws them.

A name is checked against the vehicle's class before anything is simulated. A draw depends only on
seed and scene, so that a flight can be repeated.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from aeroscene.scene import InteractionArea, Scene
from aeroscene.scene.polygon import distance_inside
from autonomy.types import Vector3
from flightsim.draws import generator
from flightsim.testbench import TestbenchError
from flightsim.vehicles.airframe import Airframe

Target = Literal["landing", "perching", "any"]
"""Desired kind of area."""

_CLASSES = ("small", "medium", "large")  # by size: an area for one class fits all smaller ones
_AREA = "area:"
_STANDING_M = 0.5
"""Height of the start over an area within which the vehicle stands on it."""


class GoalError(TestbenchError):
    """The scene has no such start or goal for the vehicle; one line says what would be valid."""


def fits(area: InteractionArea, airframe: Airframe) -> bool:
    """Return whether an area is large enough for a vehicle's class."""
    return _CLASSES.index(area.drone_class) >= _CLASSES.index(airframe.drone_class)


def fitting_areas(
    scene: Scene, airframe: Airframe, target: Target = "landing"
) -> list[InteractionArea]:
    """Return the areas of a scene that are of the desired kind and fit the vehicle."""
    return [
        area
        for area in scene.interaction_areas
        if target in {area.kind, "any"} and fits(area, airframe)
    ]


def is_indoor(scene: Scene, area: InteractionArea) -> bool:
    """Return whether the object under an area is indoors; False for areas on the ground."""
    return area.object_id is not None and scene.object_by_id[area.object_id].domain == "indoor"


def draw_goals(
    scene: Scene, airframe: Airframe, seed: int, target: Target = "landing"
) -> list[InteractionArea]:
    """Return all areas that a flight may be sent to, in the order in which the seed draws them.

    As long as there are areas indoors and outdoors, each draw falls on either side with equal
    chance, so that a few rooms full of tables do not outweigh a site. Within a side all areas have
    equal chance. The area that the vehicle stands on is left out.
    """
    rng = generator(seed, scene.scene_id, "goal")
    groups: dict[bool, list[InteractionArea]] = {False: [], True: []}
    # Sorted by number, so that the draw does not depend on the order in the document.
    for area in sorted(fitting_areas(scene, airframe, target), key=lambda area: area.id):
        if not _is_start(scene, area):
            groups[is_indoor(scene, area)].append(area)
    drawn: list[InteractionArea] = []
    while any(groups.values()):
        candidates = [group for group in groups.values() if group]
        # First the side, then the area on it.
        group = candidates[rng.integers(len(candidates))]
        drawn.append(group.pop(rng.integers(len(group))))
    return drawn


def _is_start(scene: Scene, area: InteractionArea) -> bool:
    """Return whether the vehicle stands on an area at the start."""
    x, y, z = scene.start_position_enu_m
    outline = [(corner_x, corner_y) for corner_x, corner_y, _ in area.polygon]
    return abs(z - area.centroid[2]) < _STANDING_M and distance_inside(outline, x, y) > 0.0


def find_area(scene: Scene, airframe: Airframe, number: int, option: str) -> InteractionArea:
    """Return the area of a scene by its number.

    Args:
        scene: Scene to look in.
        airframe: Vehicle that must fit.
        number: Number of the area.
        option: Name of the option that asks for it, for the message.

    Raises:
        GoalError: If there is no such area, or it is too small.
    """
    area = next((area for area in scene.interaction_areas if area.id == number), None)
    if area is not None and fits(area, airframe):
        return area
    valid = ", ".join(str(each.id) for each in fitting_areas(scene, airframe, "any")) or "none"
    if area is None:
        problem = f"is not in scene {scene.scene_id}"
    else:
        kind = airframe.drone_class
        problem = f"is for class {area.drone_class}, {airframe.name} is of class {kind}"
    raise GoalError(f"{option} {number} {problem}; valid: {valid}")


def with_start(scene: Scene, airframe: Airframe, start: str) -> Scene:
    """Return the same scene with another start.

    Args:
        scene: Scene to fly in.
        airframe: Vehicle that starts there.
        start: `area:ID`, or a point to stand on as `x,y,z`, ENU, m.

    Raises:
        GoalError: If the text is neither, or the place is not in the scene's flight volume.
    """
    valid = "valid: area:ID, or x,y,z in m within the scene"
    if start.startswith(_AREA):
        number = start.removeprefix(_AREA)
        if not number.isdecimal():
            raise GoalError(f"start {start!r} names no area; {valid}")
        place = find_area(scene, airframe, int(number), "start area").centroid
    else:
        place = _point(start)
        if place is None:
            raise GoalError(f"start {start!r} is no place; {valid}")
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    if not all(a <= c <= b for a, c, b in zip(low, place, high, strict=True)):
        where = f"outside of scene {scene.scene_id}, which reaches from {low} to {high}"
        raise GoalError(f"start {start!r} is {where}; {valid}")
    return replace(scene, start_position_enu_m=place)


def _point(text: str) -> Vector3 | None:
    """Return three finite numbers separated by commas; None if the text is anything else."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        return None
    return (x, y, z) if all(math.isfinite(c) for c in (x, y, z)) else None
