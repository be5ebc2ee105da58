"""Themes of indoor scenes: homes, work, care, learning, guests, shops, sport, traffic, goods."""

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
    tall_chance: float = 0.0
    """Probability that the building has two storeys."""
    tall_share: float = 0.75
    """Length of a building of two storeys, relative to one of a single storey."""
    programme: Programme
    fulness: float = 1.15
    """Number of fine objects, relative to the average scene."""
    features: tuple[str, ...]
    """Coarse structures that enrich the halls and galleries, the most characteristic first."""


TALL_M = (7.25, 7.75)
"""Range of the ceiling's height over two storeys."""
_CEILING_M = (4.75, 5.25)

THEMES: tuple[Theme, ...] = (
    Theme(
        name="office",
        weight=0.14,
        planner=plan_spine,
        size_m=((23, 26), (14.5, 16), _CEILING_M),
        tall_chance=0.35,
        programme=Programme(
            halls=("lobby",),
            near=("office", "meeting", "office", "kitchen", "office", "washroom"),
            far=("open_office", "meeting", "store", "open_office"),
            upper=("open_office", "lounge"),
            depth_m=(5.25, 5.75),
        ),
        fulness=1.2,
        features=("screen", "garden", "kiosk", "podium"),
    ),
    Theme(
        name="apartments",
        weight=0.16,
        planner=plan_spine,
        size_m=((21, 24.5), (12, 13), _CEILING_M),
        programme=Programme(
            halls=("lobby",),
            near=("bedroom", "bathroom", "kitchen", "bedroom", "bathroom", "dining"),
            far=("living", "bedroom", "kitchen", "bedroom", "living"),
            upper=("lounge",),
            depth_m=(4.0, 4.5),
            corridor_m=2.75,
        ),
        fulness=1.12,
        features=("screen", "garden", "podium"),
    ),
    Theme(
        name="school",
        weight=0.11,
        planner=plan_spine,
        size_m=((27, 30), (16, 17.5), _CEILING_M),
        tall_chance=0.2,
        programme=Programme(
            halls=("lobby",),
            near=("classroom", "classroom", "library", "classroom"),
            far=("office", "washroom", "meeting", "workshop", "kitchen", "store"),
            upper=("library", "lounge"),
            depth_m=(6.75, 7.5),
        ),
        fulness=1.18,
        features=("bleachers", "podium", "garden", "screen"),
    ),
    Theme(
        name="hotel",
        weight=0.08,
        planner=plan_spine,
        size_m=((23, 26.5), (13.5, 14.5), _CEILING_M),
        tall_chance=0.2,
        programme=Programme(
            halls=("lobby",),
            near=("bedroom", "bedroom", "bathroom", "bedroom", "store"),
            far=("restaurant", "galley", "bedroom", "lounge"),
            upper=("lounge", "restaurant"),
            depth_m=(4.25, 5.0),
            corridor_m=2.75,
        ),
        fulness=1.1,
        features=("garden", "podium", "screen", "kiosk"),
    ),
    Theme(
        name="clinic",
        weight=0.08,
        planner=plan_spine,
        size_m=((21, 23.5), (15, 16), _CEILING_M),
        programme=Programme(
            halls=("lobby",),
            near=("ward", "practice", "ward", "washroom", "ward", "office"),
            far=("waiting", "ward", "practice", "ward", "store"),
            upper=("lounge",),
            depth_m=(5.25, 5.75),
        ),
        fulness=1.1,
        features=("screen", "garden", "kiosk"),
    ),
    Theme(
        name="library",
        weight=0.06,
        planner=plan_hall,
        size_m=((23, 26), (16, 17.5), _CEILING_M),
        tall_chance=0.4,
        programme=Programme(
            halls=("lobby", "library", "library", "cafe"),
            near=("office", "washroom", "meeting", "store"),
            upper=("library", "lounge"),
            depth_m=(4.25, 5.0),
        ),
        fulness=1.2,
        features=("screen", "podium", "garden"),
    ),
    Theme(
        name="restaurant",
        weight=0.06,
        planner=plan_hall,
        size_m=((20, 22.5), (15, 16), _CEILING_M),
        programme=Programme(
            halls=("lobby", "restaurant", "restaurant", "cafe"),
            near=("galley", "store", "washroom", "office"),
            upper=("lounge",),
            depth_m=(4.75, 5.5),
        ),
        fulness=1.36,
        features=("podium", "pavilion", "garden", "screen"),
    ),
    Theme(
        name="sports",
        weight=0.08,
        planner=plan_hall,
        size_m=((25, 29), (18, 20), (7.5, 8.5)),
        tall_chance=0.6,
        programme=Programme(
            halls=("court", "court", "court", "gym"),
            near=("changing", "washroom", "changing", "store"),
            upper=("stand",),
            depth_m=(4.75, 6.0),
            hall_m=(8.0, 9.5),
            n_open=3,
        ),
        fulness=1.0,
        features=("bleachers", "net", "shelter", "bleachers", "podium", "net", "kiosk"),
    ),
    Theme(
        name="fair",
        weight=0.06,
        planner=plan_hall,
        size_m=((27, 31), (17, 19), (7.5, 8.5)),
        tall_chance=0.4,
        programme=Programme(
            halls=("lobby", "booths", "booths", "booths", "booths", "cafe"),
            near=("store", "office", "washroom", "kitchen"),
            upper=("lounge",),
            depth_m=(4.25, 5.0),
            n_open=1,
        ),
        fulness=1.2,
        features=("stall", "stall", "kiosk", "stall", "podium", "stall", "pavilion", "garden"),
    ),
    Theme(
        name="station",
        weight=0.06,
        planner=plan_hall,
        size_m=((27, 31), (17, 19), (7.5, 8.5)),
        tall_chance=0.3,
        programme=Programme(
            halls=("concourse", "concourse", "cafe", "concourse", "lobby", "concourse"),
            near=("office", "store", "washroom", "waiting"),
            upper=("lounge", "cafe"),
            depth_m=(4.25, 5.0),
            n_open=1,
        ),
        fulness=1.22,
        features=("platform", "kiosk", "shelter", "platform", "kiosk", "net", "garden"),
    ),
    Theme(
        name="warehouse",
        weight=0.06,
        category="warehouse",
        planner=plan_hall,
        size_m=((27, 31), (18, 20), (7.25, 8.5)),
        tall_chance=0.4,
        programme=Programme(
            halls=("goods", "racks", "racks", "goods", "racks", "racks"),
            near=("office", "store", "washroom", "kitchen"),
            upper=("storage",),
            depth_m=(4.25, 5.0),
            n_open=2,
        ),
        fulness=1.16,
        features=("container", "dock", "net", "container", "cabin", "dock"),
    ),
    Theme(
        name="supermarket",
        weight=0.06,
        planner=plan_hall,
        size_m=((23, 26), (16, 17.5), (5.25, 6.0)),
        programme=Programme(
            halls=("checkout", "produce", "aisles", "aisles"),
            near=("store", "office", "washroom", "store"),
            upper=("storage",),
            depth_m=(4.0, 4.75),
        ),
        fulness=1.25,
        features=("kiosk", "stall", "screen", "podium"),
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
    "restaurant": ("parquet", "pale_wood"),
    "waiting": ("parquet", "floor_tiles"),
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
}
"""Floors that suit a kind of zone; all others are tiled."""
