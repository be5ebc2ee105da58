"""Classes of pixels: the categories of the scene, and classes of things that are in no scene."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from jaxtyping import Int32, UInt8

from aeroscene.scene.catalogue import CATALOGUE, category_id
from flightsim.cameras.view import NO_OBJECT_ID
from flightsim.world import (
    FIRST_MATE_ID,
    FIRST_MOVER_ID,
    GROUND_ID,
    NEIGHBOUR_ID,
    VEHICLE_ID,
    World,
)

NOTHING_CLASS = 0
"""Class of the sky."""
_FIRST_OTHER = max(CATALOGUE) + 1
GROUND_CLASS, VEHICLE_CLASS, PERSON_CLASS, DRONE_CLASS, NEIGHBOUR_CLASS = range(
    _FIRST_OTHER, _FIRST_OTHER + 5
)
CLASS_NAMES: Mapping[int, str] = MappingProxyType(
    {NOTHING_CLASS: "sky"}
    | {number: category.name for number, category in CATALOGUE.items()}
    | {
        GROUND_CLASS: "bare ground",
        VEHICLE_CLASS: "own vehicle",
        PERSON_CLASS: "person",
        DRONE_CLASS: "drone",
        NEIGHBOUR_CLASS: "surroundings",
    }
)
"""Name of each class: 1 to 70 are the categories of `category_id` in a scene's document."""
_MOVER_CLASSES = {"person": PERSON_CLASS, "car": category_id("car"), "drone": DRONE_CLASS}


class Classes:
    """Class of each object in a world, by its id in `World.geom_object_id`."""

    def __init__(self, world: World) -> None:
        """Look up every object, mover and other vehicle of a world."""
        classes = {obj.id: obj.category_id for obj in world.scene.objects}
        classes |= {NO_OBJECT_ID: NOTHING_CLASS, GROUND_ID: GROUND_CLASS, VEHICLE_ID: VEHICLE_CLASS}
        classes[NEIGHBOUR_ID] = NEIGHBOUR_CLASS
        for index, mover in enumerate(world.obstacles):
            classes[FIRST_MOVER_ID - index] = _MOVER_CLASSES[mover.kind]
        classes |= {FIRST_MATE_ID - k: DRONE_CLASS for k in range(world.n_vehicles)}
        # A table from the least id on: negative ids would count from its end.
        self._least = min(classes)
        self._table = np.zeros(max(classes) - self._least + 1, dtype=np.uint8)
        for number, kind in classes.items():
            self._table[number - self._least] = kind

    def of(self, object_ids: Int32[np.ndarray, "*shape"]) -> UInt8[np.ndarray, "*shape"]:
        """Return the class of each object id.

        Args:
            object_ids: Ids as in `World.geom_object_id`, in an array of any shape.

        Returns:
            Classes in the same shape; `NOTHING_CLASS` for ids that are not in the world.
        """
        row = object_ids - self._least
        is_known = (row >= 0) & (row < len(self._table))
        return np.where(is_known, self._table[np.where(is_known, row, 0)], NOTHING_CLASS)
