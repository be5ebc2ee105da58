"""Coarse solids of neighbours: a house is a block under a roof, a tree a stem under a crown."""

from __future__ import annotations

import math

from aeroscene.scene import Vector3
from aeroscene.scene.box import quat_from_yaw, rotation_matrix
from aeroscene.solids.shapes.primitive import Part, Primitive, block, hull

NEIGHBOUR_OBJECT_ID = -4
"""Object id of all neighbours: they are no objects of the scene."""
_EAVES_M = 0.4
_STEM_M = 0.3
_SIDES = 6
_RINGS = ((0.12, 0.62), (0.5, 1.0), (0.82, 0.55))
"""Height and radius of the rings of a crown, as shares of its extents."""
_LINE_M = 0.15
_LINE_RISE_M = 0.01


def house(size_m: Vector3, wall: str, roof: str | None, pitch: float) -> list[Part]:
    """A block with a gable roof along its longer side, or with a flat roof.

    Args:
        size_m: Extents, roof included.
        wall: Material of the walls.
        roof: Material of a gable roof; None for a flat one.
        pitch: Rise of a gable roof over its half width.
    """
    x, y, z = size_m
    if roof is None:
        return [block(x, y, (0.0, z), wall)]
    # A roof of this pitch over the shorter side takes the rest of the height.
    eaves_m = z - pitch * min(x, y) / 2
    half_x, half_y = x / 2 + _EAVES_M, y / 2 + _EAVES_M
    foot: list[Vector3] = [(sx * half_x, sy * half_y, eaves_m) for sx in (-1, 1) for sy in (-1, 1)]
    ridge: list[Vector3] = (
        [(-half_x, 0.0, z), (half_x, 0.0, z)] if x > y else [(0.0, -half_y, z), (0.0, half_y, z)]
    )
    return [block(x, y, (0.0, eaves_m), wall), hull([*foot, *ridge], roof)]


def tree(size_m: Vector3, leaves: str) -> list[Part]:
    """Build a tree of a stem and a crown of flat faces, its foot at the origin.

    Args:
        size_m: Extents; the crown is round, so that the width counts alone.
        leaves: Material of the crown.
    """
    wide_m, _, z = size_m
    base_m = 0.25 * z
    crown: list[Vector3] = [(0.0, 0.0, base_m), (0.0, 0.0, z)]
    for height, radius in _RINGS:
        for k in range(_SIDES):
            turn = 2 * math.pi * k / _SIDES
            reach_m = radius * wide_m / 2
            up_m = base_m + height * (z - base_m)
            crown.append((reach_m * math.cos(turn), reach_m * math.sin(turn), up_m))
    # The stem ends inside the crown.
    return [block(_STEM_M, _STEM_M, (0.0, base_m + 0.3), "bark"), hull(crown, leaves)]


def street(length_m: float, width_m: float, top_m: float) -> list[Part]:
    """Paint a street of asphalt with a line along its middle; nothing collides with it.

    Args:
        length_m: Length, along x.
        width_m: Width, along y.
        top_m: Height of the asphalt above the ground.
    """
    line = block(length_m, _LINE_M, (0.0, top_m + _LINE_RISE_M), "marking_white", collides=False)
    return [block(length_m, width_m, (0.0, top_m), "asphalt", collides=False), line]


def placed(parts: list[Part], foot_enu_m: Vector3, yaw_rad: float) -> list[Primitive]:
    """Parts in the world: their origin at a foot, their x axis along a heading.

    Args:
        parts: Boxes and hulls without turns of their own.
        foot_enu_m: Place of the origin.
        yaw_rad: Heading of the x axis.
    """
    quat = quat_from_yaw(yaw_rad)
    rotation = rotation_matrix(quat)
    found: list[Primitive] = []
    for part in parts:
        x, y, z = (rotation @ part.position_m + foot_enu_m).tolist()
        found.append(
            Primitive(
                kind=part.kind,
                position_enu_m=(x, y, z),
                quat_wxyz=quat,
                size_m=part.size_m,
                material=part.material,
                object_id=NEIGHBOUR_OBJECT_ID,
                collides=part.collides,
                vertices_m=part.vertices_m,
            )
        )
    return found
