"""Upward faces, level or sloping: the surfaces on which a drone might stand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import atan, cos, hypot

import numpy as np
import shapely
from jaxtyping import Float
from shapely.geometry.base import BaseGeometry

from aeroscene.areas.needs import MAX_SLOPE_RAD, PERCH_NEEDS
from aeroscene.solids.outlines import outline_of
from aeroscene.solids.solids import Solids, hull_faces

_LEVEL = 1e-4
"""Gradient below which a face is level."""
_ROUND = 16
"""Corners of a circle's outline."""
_MERGE_M = 0.002
"""Faces of one object are one face if their heights differ by less; gradients likewise."""
# A face of exactly the greatest slope must not fail by rounding.
_SLACK_RAD = 1e-6
_RECTANGLE = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A plane upward face of an object or of the ground, with at most `MAX_SLOPE_RAD` of slope."""

    object_id: int | None
    """Id of the object; None for the bare ground of a relief."""
    outline: BaseGeometry
    """Outline from above, ENU, m."""
    gradient: tuple[float, float]
    """Rise towards east and towards north."""
    height_at_origin_m: float
    """Height of the face's plane over the origin."""

    @property
    def slope_rad(self) -> float:
        """Angle to the horizontal; exactly 0 for a level face."""
        return atan(hypot(*self.gradient))

    @property
    def is_level(self) -> bool:
        """True if one height holds for all of it."""
        return self.gradient == (0.0, 0.0)

    def height_m(self, x: float, y: float) -> float:
        """Return the height of the plane at a place."""
        return self.height_at_origin_m + self.gradient[0] * x + self.gradient[1] * y


_Piece = tuple[int, Float[np.ndarray, " 3"], Float[np.ndarray, "k 3"]]
"""Solid, upward unit normal, corners."""


def upward_faces(solids: Solids, is_wanted: Callable[[int], bool]) -> list[Face]:
    """Return the upper faces of boxes, cylinders and hulls.

    Faces of one object in one plane are united, so that an area may span several solids. Faces that
    are too small even for a perch are left out.

    Args:
        solids: Solids of a scene.
        is_wanted: True for an object, given by its id, that may bear an area.
    """
    groups: dict[tuple[int, ...], list[tuple[_Piece, tuple[float, float, float]]]] = {}
    for piece in _pieces(solids, is_wanted):
        index, normal, corners = piece
        gx, gy = (-normal[:2] / normal[2]).tolist()
        if hypot(gx, gy) < _LEVEL:
            gx = gy = 0.0
        x, y, z = corners[0].tolist()
        height = z - gx * x - gy * y
        object_id = int(solids.object_id[index])
        # Planes are compared by rounded numbers, which a dictionary can look up.
        key = (object_id, *(round(value / _MERGE_M) for value in (gx, gy, height)))
        groups.setdefault(key, []).append((piece, (gx, gy, height)))
    least_m2 = np.pi * PERCH_NEEDS.surface_radius_m**2
    # A cheap bound first: uniting outlines takes longer.
    wide = [(key[0], group) for key, group in groups.items() if _about_m2(group) > least_m2]
    faces = [_united(object_id, group) for object_id, group in wide]
    return [face for face in faces if face.outline.area > least_m2]


def _about_m2(group: list[tuple[_Piece, tuple[float, float, float]]]) -> float:
    """Return an upper bound of the pieces' area: that of the rectangles around them."""
    return sum(float(np.ptp(piece[2][:, :2], axis=0).prod()) for piece, _ in group)


def _united(object_id: int, group: list[tuple[_Piece, tuple[float, float, float]]]) -> Face:
    outlines = [outline_of(piece[2]) for piece, _ in group]
    outline = outlines[0] if len(outlines) == 1 else shapely.union_all(outlines)
    # The highest plane counts, so that no piece stands above the face.
    gx, gy, height = max((plane for _, plane in group), key=lambda plane: plane[2])
    return Face(object_id, outline, (gx, gy), height)


def _pieces(solids: Solids, is_wanted: Callable[[int], bool]) -> Iterator[_Piece]:
    steepest = cos(MAX_SLOPE_RAD + _SLACK_RAD)
    upness = np.abs(solids.rotation[:, 2, :])
    # A cylinder has flat faces at its ends alone; a box takes the axis that points most upwards.
    axis = np.where(solids.is_cylinder, 2, upness.argmax(axis=1))
    is_flat = np.take_along_axis(upness, axis[:, None], axis=1)[:, 0] >= steepest
    for i in np.flatnonzero(solids.is_mesh | (is_flat & (solids.is_box | solids.is_cylinder))):
        if not is_wanted(int(solids.object_id[i])):
            continue
        if solids.is_mesh[i]:
            yield from _hull_pieces(solids, int(i), steepest)
        else:
            yield _flat_piece(solids, int(i), int(axis[i]))


def _flat_piece(solids: Solids, index: int, axis: int) -> _Piece:
    """Return the upper face of a box, or the upper cap of a cylinder as a polygon inside it."""
    rotation, half = solids.rotation[index], solids.half_m[index]
    normal = rotation[:, axis] * np.sign(rotation[2, axis])
    first, second = (i for i in range(3) if i != axis)
    if solids.is_cylinder[index]:
        turns = 2 * np.pi * np.arange(_ROUND) / _ROUND
        plane = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    else:
        plane = _RECTANGLE
    across = plane[:, :1] * half[first] * rotation[:, first]
    along = plane[:, 1:] * half[second] * rotation[:, second]
    return index, normal, solids.centre_m[index] + half[axis] * normal + across + along


def _hull_pieces(solids: Solids, index: int, steepest: float) -> Iterator[_Piece]:
    rotation, centre = solids.rotation[index], solids.centre_m[index]
    vertices_m = solids.primitives[index].vertices_m
    faces = hull_faces(vertices_m)
    normals = faces.planes[:, :3] @ rotation.T
    for number in np.flatnonzero(normals[:, 2] >= steepest):
        corners = np.asarray(vertices_m)[faces.corners[number]]
        yield index, normals[number], corners @ rotation.T + centre
