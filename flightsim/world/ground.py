"""Ground of a world: the plane z = 0, or the height fields of a relief.

A relief has a grid that ends with the site, while vehicles, rays and cameras reach beyond. Its
border heights therefore continue outwards, as level strips in eight more height fields around it.
"""

from __future__ import annotations

from itertools import pairwise, product
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Float

from aeroscene.scene import Relief
from aeroscene.solids.shapes import MATERIALS
from flightsim.looks.surroundings import GROUND_MATERIAL
from flightsim.world.contact import STATIC_CONTACT, friction

GROUND_GEOM = "ground"
BEYOND_M = 2_000.0
"""Distance by which the ground continues beyond the grid of a relief."""
_DEPTH_M = 10.0
"""Thickness of the ground below the lowest point of each field."""


def add_ground(spec: mujoco.MjSpec, relief: Relief | None) -> None:
    """Add the geom "ground": the plane z = 0, or the height field of a relief.

    Args:
        spec: Model to add to.
        relief: Heights of the ground; None makes it the plane.
    """
    if relief is not None:
        _add_field(spec, relief, 1, 1, GROUND_GEOM)
        return
    spec.worldbody.add_geom(
        name=GROUND_GEOM,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        # Zero is infinite. The third number is MuJoCo's grid spacing for drawing.
        size=(0.0, 0.0, 1.0),
        **_contact(),
    )


def add_ground_beyond(spec: mujoco.MjSpec, relief: Relief | None) -> None:
    """Continue the ground of a relief beyond its grid by eight height fields.

    A height field has one spacing along each axis, so each side and each corner is a field of its
    own, two nodes wide. They reach `BEYOND_M` outwards; the plane needs none, since it has no end.
    """
    if relief is not None:
        for row, column in product(range(3), repeat=2):
            if (row, column) != (1, 1):
                _add_field(spec, relief, row, column, f"{GROUND_GEOM}_{row}{column}")


def _add_field(spec: mujoco.MjSpec, relief: Relief, row: int, column: int, name: str) -> None:
    """Add one of the three by three height fields; the one in the middle is the relief's grid.

    Args:
        spec: Model to add to.
        relief: Heights on the grid.
        row: 0 for the south, 1 for the grid's own part, 2 for the north.
        column: 0 for the west, 1 for the grid's own part, 2 for the east.
        name: Name of the geom and of its data.
    """
    (south, north), (west, east) = (
        tuple(pairwise(_borders_m(relief, axis)))[part] for axis, part in ((0, row), (1, column))
    )
    heights = _part(_part(relief.heights_m, row).T, column).T
    low_m, rise_m = float(heights.min()), float(np.ptp(heights))
    spec.add_hfield(
        name=name,
        nrow=heights.shape[0],
        ncol=heights.shape[1],
        # MuJoCo scales the data to a range from 0 to 1, and a level field to 0.
        size=((east - west) / 2, (north - south) / 2, rise_m or 1.0, _DEPTH_M),
        userdata=heights.ravel(),
    )
    spec.worldbody.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname=name,
        pos=((west + east) / 2, (south + north) / 2, low_m),
        **_contact(),
    )


def _borders_m(relief: Relief, axis: int) -> tuple[float, float, float, float]:
    """Return the coordinates of the borders of the three fields along an axis.

    Args:
        relief: Heights on the grid.
        axis: Axis of the grid's array: 0 is north, 1 is east.
    """
    first = relief.origin_enu_m[1 - axis]
    last = first + (relief.heights_m.shape[axis] - 1) * relief.spacing_m
    return first - BEYOND_M, first, last, last + BEYOND_M


def _part(heights_m: Float[np.ndarray, "n _"], part: int) -> Float[np.ndarray, "k _"]:
    """Return the rows of the field before the grid (0), on it (1) or after it (2)."""
    # Twice the border's row, so heights stay the same all the way outwards.
    return heights_m if part == 1 else np.repeat(heights_m[[0 if part == 0 else -1]], 2, axis=0)


def _contact() -> dict[str, Any]:
    rgba = MATERIALS[GROUND_MATERIAL].rgba
    return {"rgba": rgba, "friction": friction(GROUND_MATERIAL), **STATIC_CONTACT}
