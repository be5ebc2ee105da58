"""What stands on roofs."""

from __future__ import annotations

from math import atan2, cos, hypot, sin

from aeroscene.shapes.look import Look
from aeroscene.shapes.primitive import Part, Quaternion, block, centred, cylinder


def ac_unit(look: Look) -> list[Part]:
    """A housing with a fan on top and a grille in front."""
    x, y, z = look.size_m
    fan = 0.7 * min(x, y)
    return [
        block(centred(x - 0.02), centred(y), (0, z), "metal"),
        cylinder((0, 0, z + 0.002), fan, 0.004, "dark_metal", collides=False),
        block(
            (x / 2 - 0.01, x / 2),
            centred(0.8 * y),
            (0.2 * z, 0.8 * z),
            "dark_metal",
            collides=False,
        ),
    ]


def chimney(look: Look) -> list[Part]:
    """A brick stack with a cap."""
    x, y, z = look.size_m
    return [
        block(centred(0.86 * x), centred(0.86 * y), (0, z), "brick"),
        block(centred(x), centred(y), (z - 0.3, z - 0.15), "concrete"),
    ]


def solar_panel(look: Look) -> list[Part]:
    """A panel that leans back from low front (+x) to high rear, on two feet."""
    x, y, z = look.size_m
    thick = 0.05
    rise, run = z - 0.12 - thick, x - thick
    tilt = atan2(rise, run)
    quat: Quaternion = (cos(tilt / 2), 0.0, sin(tilt / 2), 0.0)
    length = hypot(rise, run) - thick * sin(tilt)
    panel = Part(
        kind="box",
        position_m=(0.0, 0.0, 0.12 + rise / 2),
        quat_wxyz=quat,
        size_m=(length, y, thick),
        material="solar",
    )
    feet = [
        block((-0.42 * x, -0.42 * x + 0.06), (at - 0.03, at + 0.03), (0, 0.8 * z - 0.1), "metal")
        for at in (-0.35 * y, 0.35 * y)
    ]
    return [panel, *feet, block((0.36 * x, 0.42 * x), centred(0.9 * y), (0, 0.12), "metal")]


def water_tank(look: Look) -> list[Part]:
    """A drum on a frame."""
    x, y, z = look.size_m
    diameter = min(x, y)
    frame = 0.25 * z
    reach = 0.3 * diameter
    feet = [(sx * reach, sy * reach, frame / 2) for sx in (-1, 1) for sy in (-1, 1)]
    return [
        cylinder((0, 0, (z + frame) / 2), diameter, z - frame, "corrugated"),
        *(cylinder(foot, 0.12, frame, "dark_metal") for foot in feet),
    ]


def antenna(look: Look) -> list[Part]:
    """A mast with cross bars."""
    x, y, z = look.size_m
    return [
        cylinder((0, 0, z / 2), min(0.1, x), z, "metal"),
        block(centred(0.05), centred(y), (0.72 * z, 0.72 * z + 0.05), "metal"),
        block(centred(x), centred(0.05), (0.86 * z, 0.86 * z + 0.05), "metal"),
    ]
