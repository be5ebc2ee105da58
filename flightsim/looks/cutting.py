"""Horizontal cut through a world, to look into a building from above."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from aeroscene.solids.shapes import Primitive

_LEAST_M = 1e-3
"""Thinnest rest of a box: floors of rooms are 2 cm thick, and paint 5 mm."""


def cut_at(
    solids: Iterable[Primitive], height_m: float, least_m: float = _LEAST_M
) -> tuple[Primitive, ...]:
    """Return the solids below a height; upright boxes are cut there, others go by their centre.

    Args:
        solids: Solids of a world.
        height_m: Height of the cut, ENU, m.
        least_m: Boxes of which less than this is left are removed whole, m.
    """
    kept = []
    for solid in solids:
        x, y, z = solid.position_enu_m
        length, width, rise = solid.size_m
        low = z - rise / 2
        if solid.kind == "box" and _is_upright(solid):
            top = min(height_m, low + rise)
            if top - low > least_m:
                middle = (x, y, (low + top) / 2)
                kept.append(
                    replace(solid, position_enu_m=middle, size_m=(length, width, top - low))
                )
        elif z < height_m:
            kept.append(solid)
    return tuple(kept)


def _is_upright(solid: Primitive) -> bool:
    _, x, y, _ = solid.quat_wxyz
    # A box that is turned about the vertical alone has level faces to cut.
    return abs(x) + abs(y) < 1e-6
