"""MuJoCo geom groups of our models: the sensors and cameras that see a geom."""

from __future__ import annotations

from enum import IntEnum


class GeomGroup(IntEnum):
    """Group of a geom; it determines which sensors see the geom, not whether it collides."""

    SCENE = 0
    """The static world as cameras and rays see it."""
    VEHICLE_LOOKS = 1
    """Appearance of the vehicle, massless and without contacts."""
    DECOR = 2
    """Seen by cameras only: glazing, foliage and paint without contacts, and in drawing models the
    layers of light."""
    VEHICLE_SHAPE = 3
    """Collision shape of the vehicle."""
    MOVING = 4
    """People, cars and other drones, seen by all sensors."""
    CULLED = 5
    """Geoms outside the camera's view during one rendering; none stays in this group."""
