"""Contact parameters of all solids that stand still."""

from __future__ import annotations

from typing import Any

from aeroscene.solids.shapes import MATERIALS
from flightsim.looks.geom_groups import GeomGroup

STATIC_CONTACT: dict[str, Any] = {
    "contype": 1,
    "conaffinity": 1,
    "condim": 3,
    # The vehicle's softness applies, with the larger friction of the two.
    "solmix": 0.0,
    "group": int(GeomGroup.SCENE),
}


def friction(material: str) -> tuple[float, float, float]:
    """Return a surface's friction: sliding, torsional and rolling; the last two are MuJoCo's own.

    Args:
        material: A key of `MATERIALS`.
    """
    return (MATERIALS[material].friction, 0.005, 0.0001)
