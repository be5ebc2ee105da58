"""Looks of the neighbourhood: few paints of its own, so that it needs few skins."""

from __future__ import annotations

from collections.abc import Sequence

from aeroscene.solids.shapes import Primitive
from aeroscene.solids.shapes.materials import FACADE_BAY_M
from flightsim.looks.dressing import ALL_FACES, SIDES, TOP, Piece
from flightsim.looks.mesh import MeshBuilder
from flightsim.looks.paint import Colour, Paint, material_paint
from flightsim.looks.surfaces import FAST, surface_enu

_TINT: Colour = (0.97, 0.99, 0.98)
"""Tint that makes a paint differ from the site's of the same material: the skins of a site's paint
are divided into tiles, and the neighbourhood would add many."""
_FACADES = {
    "plaster_cream": "punched",
    "plaster_ochre": "balconies",
    "brick": "brickwork",
    "cladding_white": "ribbon",
}
"""Pattern of walls by their material."""
_TWO_BAYS_M = (2 * FACADE_BAY_M[0], 2 * FACADE_BAY_M[1])
_ROOFING = material_paint("roofing").tinted(_TINT)


def add_neighbours(builder: MeshBuilder, neighbours: Sequence[Primitive]) -> None:
    """Add the surfaces of the neighbourhood's solids."""
    boxes: list[Piece] = []
    for solid in neighbours:
        paint = material_paint(solid.material).tinted(_TINT)
        if solid.kind != "box":
            builder.add_surface(surface_enu(solid, FAST), paint, is_flat=True)
        elif solid.material in _FACADES:
            facade = Paint(_FACADES[solid.material], paint.rgb, _TWO_BAYS_M)
            # No underside: it lies on the ground.
            boxes += [Piece(solid, facade, SIDES), Piece(solid, _ROOFING, (TOP,))]
        else:
            boxes.append(Piece(solid, paint, ALL_FACES))
    builder.add_boxes(boxes)
