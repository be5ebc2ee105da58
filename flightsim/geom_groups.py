"""What MuJoCo's geom groups mean in our models, and which of them a sensor sees."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class GeomGroup(IntEnum):
    """Group of a geom; decides who sees it, not whether it collides."""

    SCENE = 0
    """The world as cameras and rays meet it."""
    VEHICLE_LOOKS = 1
    """Massless, never in contact: how the vehicle looks to others."""
    DECOR = 2
    """Seen by cameras only: glazing, foliage and paint that nothing can touch."""
    VEHICLE_SHAPE = 3
    """What the vehicle touches with."""
    MOVING = 4
    """People, cars and other drones, as everybody meets them."""
    CULLED = 5
    """Outside the camera's view during one rendering; no geom stays here."""


RAY_GROUPS = np.array([1, 0, 0, 0, 1, 0], dtype=np.uint8)
"""`geomgroup` argument of `mj_ray` for a rangefinder: the solid world without the vehicle."""
