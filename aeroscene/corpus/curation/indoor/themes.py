"""What indoor scenes are: offices, schools, apartments, sports halls, fairs, stations, shops."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.plans import Programme, plan_hall, plan_spine
from aeroscene.corpus.curation.indoor.zones import Zone

_Range = tuple[float, float]
Planner = Callable[[Draw, tuple[float, float], float, Programme], tuple[Zone, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """A kind of building."""

    name: str
    weight: float
    category: str = "building"
    """Category of the building."""
    planner: Planner
    size_m: tuple[_Range, _Range, _Range]
    """Ranges of the length, the width and the ceiling's height, which a tall building exceeds."""
    tall_chance: float = 1.0
    """How often the building has two storeys."""
    programme: Programme
    fulness: float = 1.15
    """How many fine objects it has, relative to the average scene."""
    features: tuple[str, ...]
    """Coarse structures that enrich the halls and galleries, the most telling first."""


TALL_M = (7.25, 7.75)
"""Range of the ceiling's height over two storeys."""

THEMES: tuple[Theme, ...] = (
    Theme(
        name="office",
        weight=0.22,
        planner=plan_spine,
        size_m=((26, 33), (22, 25), (4.75, 5.25)),
        tall_chance=0.5,
        programme=Programme(
            halls=("lobby", "cafe"),
            small=("office", "meeting", "office", "kitchen", "store"),
            wide=("open_office", "cafe", "open_office", "library"),
            upper=("open_office", "lounge"),
            rear=("meeting", "store", "office"),
            rear_chance=0.6,
        ),
        features=("kiosk", "garden", "screen", "podium", "pavilion", "bleachers"),
    ),
    Theme(
        name="apartments",
        weight=0.16,
        planner=plan_spine,
        size_m=((26, 32), (22, 25), (4.75, 5.25)),
        tall_chance=0.4,
        programme=Programme(
            halls=("garden", "lounge"),
            small=("bedroom", "kitchen", "living", "store"),
            wide=("living", "living", "dining"),
            upper=("lounge", "library"),
            rear=("bedroom", "bedroom", "office"),
            rear_chance=0.85,
        ),
        features=("garden", "pond", "pavilion", "podium", "screen", "kiosk"),
    ),
    Theme(
        name="school",
        weight=0.14,
        planner=plan_spine,
        size_m=((28, 35), (22, 25), (4.75, 5.25)),
        tall_chance=0.35,
        programme=Programme(
            halls=("lobby", "library"),
            small=("classroom", "office", "store", "classroom", "meeting"),
            wide=("classroom", "gym", "cafe", "classroom"),
            upper=("library", "lounge"),
            rear=("classroom", "store", "workshop"),
            rear_chance=0.6,
        ),
        fulness=1.25,
        features=("bleachers", "podium", "garden", "screen", "kiosk"),
    ),
    Theme(
        name="sports",
        weight=0.12,
        planner=plan_hall,
        size_m=((27, 34), (22, 25), (7.5, 8.5)),
        programme=Programme(
            halls=("court", "court", "court", "gym"),
            small=("changing", "store", "kitchen"),
            wide=("changing", "gym", "cafe"),
            upper=("stand",),
        ),
        fulness=1.1,
        features=("bleachers", "net", "shelter", "bleachers", "podium", "net", "kiosk"),
    ),
    Theme(
        name="fair",
        weight=0.12,
        planner=plan_hall,
        size_m=((27, 34), (23, 26), (7.5, 8.5)),
        programme=Programme(
            halls=("lobby", "booths", "booths", "booths", "booths", "cafe"),
            small=("store", "office", "kitchen"),
            wide=("cafe", "meeting", "store"),
            upper=("lounge",),
        ),
        fulness=1.3,
        features=("stall", "stall", "kiosk", "stall", "podium", "stall", "pavilion", "garden"),
    ),
    Theme(
        name="station",
        weight=0.08,
        planner=plan_hall,
        size_m=((28, 36), (23, 26), (7.5, 8.5)),
        programme=Programme(
            halls=("concourse", "concourse", "cafe", "concourse", "lobby", "concourse"),
            small=("office", "store", "kitchen"),
            wide=("cafe", "office", "store"),
            upper=("lounge", "cafe"),
        ),
        fulness=1.2,
        features=("platform", "kiosk", "shelter", "platform", "kiosk", "net", "garden"),
    ),
    Theme(
        name="warehouse",
        weight=0.1,
        category="warehouse",
        planner=plan_hall,
        size_m=((28, 36), (23, 26), (7.25, 8.5)),
        programme=Programme(
            halls=("goods", "racks", "racks", "goods", "racks", "racks"),
            small=("office", "store", "kitchen"),
            wide=("workshop", "cafe", "open_office", "store"),
            upper=("storage",),
        ),
        fulness=1.2,
        features=("container", "dock", "net", "container", "cabin", "dock"),
    ),
    Theme(
        name="supermarket",
        weight=0.06,
        planner=plan_hall,
        size_m=((26, 34), (22, 25), (7.25, 7.75)),
        programme=Programme(
            halls=("checkout", "produce", "aisles", "aisles"),
            small=("store", "kitchen", "office"),
            wide=("store", "kitchen", "workshop"),
            upper=("storage", "cafe"),
        ),
        fulness=1.3,
        features=("kiosk", "stall", "screen", "pavilion", "podium"),
    ),
)

FINISHES: dict[str, tuple[str, ...]] = {
    "office": ("carpet", "parquet"),
    "open_office": ("carpet",),
    "meeting": ("carpet", "parquet"),
    "lounge": ("carpet", "parquet"),
    "library": ("parquet", "carpet"),
    "classroom": ("parquet", "floor_tiles"),
    "living": ("parquet", "pale_wood"),
    "bedroom": ("carpet", "parquet"),
    "dining": ("parquet",),
    "gym": ("rubber", "pale_wood"),
    "court": ("pale_wood", "parquet"),
    "garden": ("paving", "red_paving"),
    "concourse": ("paving", "floor_tiles"),
    "racks": ("concrete",),
    "goods": ("concrete",),
    "storage": ("concrete",),
    "store": ("concrete", "floor_tiles"),
    "workshop": ("concrete",),
    "booths": ("carpet", "red_paving"),
    "stand": ("concrete",),
    "changing": ("floor_tiles",),
}
"""Floors that suit a kind of zone; others are tiled."""
