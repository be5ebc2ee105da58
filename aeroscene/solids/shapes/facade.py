"""Walls with openings: a facade of bays and storeys, made of piers, bands and panes.

Bays and openings follow from lengths alone. A generator that plans rooms therefore knows where the
openings are without building the facade: a partition meets it at a border between bays, where a
pier stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from aeroscene.solids.shapes.materials import FACADE_BAY_M
from aeroscene.solids.shapes.primitive import Interval, Part, block, centred

WALL_M = 0.25
"""Thickness of an outer wall."""
SLAB_TOP_M = 0.15
"""Height of a storey's floor above the storey's base."""
SLAB_M = 0.25
"""Thickness of a slab between storeys."""
BAY_M = 3.0
"""Length of wall for each opening."""
OPENING_M = 2.0
"""Widest window or door."""
SILL_M = 0.85
LINTEL_M = 2.75
"""Underside of the wall above every opening. `SILL_M` and this one count from the storey's base;
low storeys lower the lintel.
"""
_BAND_RECESS_M = 0.03
_PIER_M = 0.5
"""Width of a pier between the panes of a closed wall."""

Use = Literal["open", "glass"]


@dataclass(frozen=True, slots=True)
class FacadePlan:
    """One side of a building, in its own plane: u along the wall, z up."""

    length_m: float
    storeys: int
    storey_m: float
    door_bay: int | None
    """Bay on the ground floor whose opening reaches the floor."""
    use: Use

    @property
    def n_bays(self) -> int:
        """Number of openings side by side."""
        return count_bays(self.length_m)

    def opening(self, bay: int) -> Interval:
        """Ends of the opening of a bay along the wall, m.

        Args:
            bay: Number of the bay, from 0 at the low end.
        """
        middle = -self.length_m / 2 + (bay + 0.5) * self.length_m / self.n_bays
        half = opening_width(self.length_m) / 2
        return (middle - half, middle + half)


_MOST_BAYS = 60
"""Most bays of a wall; a wall of 1,000 m would have hundreds, in each of its storeys."""


def count_bays(length_m: float) -> int:
    """Number of openings side by side in a wall."""
    return min(max(1, round(length_m / BAY_M)), _MOST_BAYS)


def opening_width(length_m: float) -> float:
    """Width of each opening of a wall, m.

    It leaves a pier on both sides. A wall that is too short for one gets a width of zero or less.
    """
    return min(OPENING_M, length_m / count_bays(length_m) - 2 * WALL_M - 0.3)


def bay_borders(length_m: float) -> list[float]:
    """Places along a wall, from its middle, where a partition may meet it, m."""
    n_bays = count_bays(length_m)
    return [-length_m / 2 + bay * length_m / n_bays for bay in range(1, n_bays)]


def facade_parts(plan: FacadePlan, across: Interval, material: str) -> list[Part]:
    """Parts of a wall with openings that runs along y; z counts from the ground.

    Args:
        plan: Bays, storeys, door and glazing of the wall.
        across: Ends of its thickness in x, m.
        material: Name of the wall's material.
    """
    height = plan.storeys * plan.storey_m
    edges = [-plan.length_m / 2]
    # Openings alternate with piers, so the sorted ends pair up to the piers.
    for bay in range(plan.n_bays):
        edges += plan.opening(bay)
    edges.append(plan.length_m / 2)
    piers = zip(edges[::2], edges[1::2], strict=True)
    parts = [block(across, pier, (0.0, height), material) for pier in piers]
    # Set back on both sides: faces of bands and piers in one plane would flicker.
    band = (across[0] + _BAND_RECESS_M, across[1] - _BAND_RECESS_M)
    for y, z in _bands(plan, height):
        parts.append(block(band, y, z, material))
    if plan.use == "glass":
        middle = (across[0] + across[1]) / 2
        pane = (middle - 0.02, middle + 0.02)
        parts += [
            block(pane, plan.opening(bay), (SLAB_TOP_M, height), "glass")
            for bay in range(plan.n_bays)
        ]
    return parts


def ribbon_parts(
    length_m: float, height_m: float, rows: list[Interval], across: Interval, material: str
) -> list[Part]:
    """A closed wall that runs along y: rows of glass between bands, divided by piers.

    Args:
        length_m: Length of the wall.
        height_m: Height of the wall.
        rows: Lower and upper end of each row of glass, ascending.
        across: Ends of the wall's thickness in x, m.
        material: Name of the wall's material.
    """
    full = centred(length_m)
    edges = [0.0, *(edge for row in rows for edge in row), height_m]
    parts = [
        block(across, full, band, material) for band in zip(edges[::2], edges[1::2], strict=True)
    ]
    middle = (across[0] + across[1]) / 2
    parts += [block((middle - 0.03, middle + 0.03), full, row, "glass") for row in rows]
    for row in rows:
        for at in (-length_m / 2, *bay_borders(length_m), length_m / 2):
            low, high = max(full[0], at - _PIER_M / 2), min(full[1], at + _PIER_M / 2)
            parts.append(block(across, (low, high), row, material))
    return parts


def _bands(plan: FacadePlan, height: float) -> list[tuple[Interval, Interval]]:
    """Horizontal strips between one storey's openings and those of the next, as (y, z)."""
    full = centred(plan.length_m)
    bands: list[tuple[Interval, Interval]] = []
    for storey in range(1, plan.storeys + 1):
        low = (storey - 1) * plan.storey_m + min(LINTEL_M, plan.storey_m - 0.25)
        # The topmost band reaches to the upper edge of the wall.
        high = storey * plan.storey_m + SILL_M if storey < plan.storeys else height
        bands.append((full, (low, high)))
    # The sill of the ground floor is interrupted at the door, which gets a low threshold instead.
    if plan.door_bay is None:
        return [(full, (0.0, SILL_M)), *bands]
    door = plan.opening(plan.door_bay)
    bands.append((door, (0.0, SLAB_TOP_M)))
    sides = ((full[0], door[0]), (door[1], full[1]))
    return bands + [(side, (0.0, SILL_M)) for side in sides]


def window_panels(size_x: float, size_y: float, height: float, material: str) -> list[Part]:
    """Four skins with a texture of windows around a solid mass, each with local z outwards.

    A skin is a whole number of bays wide and of storeys high if the wall allows, so that no window
    is cut. Skins touch nothing.

    Args:
        size_x: Length of the mass along x, m.
        size_y: Length along y, m.
        height: Height, m.
        material: Name of a facade material.
    """
    # Local z to +x, -x, +y and -y; local y points up in all four.
    quats = (
        (0.5, 0.5, 0.5, 0.5),
        (0.5, 0.5, -0.5, -0.5),
        (0.0, 0.0, 0.5**0.5, 0.5**0.5),
        (0.5**0.5, 0.5**0.5, 0.0, 0.0),
    )
    bay_m, storey_m = FACADE_BAY_M
    # Without the small term a wall of exactly whole storeys could lose one to rounding.
    rise = max(1, int(height / storey_m + 1e-6)) * storey_m
    rise = min(rise, height)
    parts: list[Part] = []
    for index, quat in enumerate(quats):
        along = size_y if index < 2 else size_x
        width = min(along, max(1, int(along / bay_m + 1e-6)) * bay_m)
        reach = (size_x if index < 2 else size_y) / 2 - 0.03
        sign = 1 if index % 2 == 0 else -1
        centre = (sign * reach, 0.0, rise / 2) if index < 2 else (0.0, sign * reach, rise / 2)
        parts.append(
            Part(
                kind="box",
                position_m=centre,
                quat_wxyz=quat,
                size_m=(width, rise, 0.02),
                material=material,
                collides=False,
            )
        )
    return parts


def turned(parts: list[Part]) -> list[Part]:
    """Turn parts by a quarter about the vertical: x becomes y, y becomes minus x.

    Only for boxes along the axes, whose sizes are swapped instead of turning them.
    """
    return [
        replace(
            part,
            position_m=(-part.position_m[1], part.position_m[0], part.position_m[2]),
            size_m=(part.size_m[1], part.size_m[0], part.size_m[2]),
        )
        for part in parts
    ]
