"""Objects at points of a map: category, form, size and direction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from aeroscene.maps.document import Tags
from aeroscene.scene import Vector3


@dataclass(frozen=True, slots=True)
class PointKind:
    """One kind of object at a point."""

    category: str
    size_m: Vector3
    form: str | None = None
    faces_way: bool = False
    """True if its front is turned to the street or path beside it."""
    foot_x_m: float = 0.0
    """Place along its box at which it touches the ground: the map has the place of its foot."""
    is_movable: bool = True
    """True if it may be moved beside a street in whose middle the map has it."""


_BENCH = PointKind("bench", (0.6, 1.8, 0.85), "rest", faces_way=True)
_BIN = PointKind("bin", (0.45, 0.45, 1.0), "litter")
_CONTAINER_BIN = PointKind("bin", (0.8, 1.2, 1.3), "wheelie")
_LAMP = PointKind("street_lamp", (1.6, 0.3, 5.5), "arm", faces_way=True, foot_x_m=-0.65)
_LIGHT = PointKind("traffic_light", (0.35, 0.35, 3.2), "vehicle", faces_way=True)
_CROSSING_LIGHT = PointKind("traffic_light", (0.35, 0.35, 2.6), "pedestrian", faces_way=True)
_BICYCLE = PointKind("bicycle", (1.8, 0.6, 1.1), "city")
_SIGN = PointKind("sign", (0.08, 0.8, 2.4), "plate", faces_way=True)
_BOARD = PointKind("sign", (0.15, 1.6, 2.4), "board", faces_way=True)
_KIOSK = PointKind("kiosk", (2.5, 3.0, 2.8), "hatch", faces_way=True)
_SHELTER = PointKind("canopy", (2.0, 4.0, 2.8), "flat", faces_way=True)
_TABLE = PointKind("table", (0.9, 1.8, 0.75), "trestle")
_PLANTER = PointKind("planter", (0.8, 0.8, 0.8), "flowers")
_BUSH = PointKind("bush", (1.4, 1.4, 1.2), "clumps")
_POST_BOX = PointKind("bin", (0.5, 0.5, 1.2), "dome")
_TANK = PointKind("water_tank", (2.5, 2.5, 3.0), "drum")
_FOUNTAIN = PointKind("water", (3.0, 3.0, 0.5), "basin")
_BOAT = PointKind("boat", (6.0, 2.2, 1.6), "motor", is_movable=False)

_BY_TAG: Mapping[str, Mapping[str, PointKind]] = {
    "amenity": {
        "bench": _BENCH,
        "lounger": _BENCH,
        "waste_basket": _BIN,
        "waste_disposal": _CONTAINER_BIN,
        "recycling": _CONTAINER_BIN,
        "bicycle_parking": _BICYCLE,
        "bicycle_rental": _BICYCLE,
        "post_box": _POST_BOX,
        "vending_machine": _KIOSK,
        "telephone": _SIGN,
        "fountain": _FOUNTAIN,
        "shelter": _SHELTER,
        "parcel_locker": _CONTAINER_BIN,
        "clock": _SIGN,
    },
    "highway": {
        "street_lamp": _LAMP,
        "traffic_signals": _LIGHT,
        "bus_stop": _SIGN,
        "stop": _SIGN,
        "give_way": _SIGN,
        "speed_camera": _SIGN,
    },
    "crossing": {"traffic_signals": _CROSSING_LIGHT},
    "natural": {"shrub": _BUSH},
    "man_made": {
        "planter": _PLANTER,
        "storage_tank": _TANK,
        "water_tank": _TANK,
        "street_cabinet": _CONTAINER_BIN,
    },
    "leisure": {"picnic_table": _TABLE},
    "tourism": {"information": _BOARD},
    "advertising": {"billboard": _BOARD, "board": _BOARD, "column": _BOARD, "poster_box": _BOARD},
    "traffic_sign": {},
    "building": {"kiosk": _KIOSK},
    "barrier": {"planter": _PLANTER},
    "power": {"pole": _LAMP},
    "seamark:type": {"small_craft_facility": _BOAT},
}
_BUS_SHELTER = PointKind("canopy", (1.8, 4.0, 2.8), "flat", faces_way=True)


def kind_at(tags: Tags) -> PointKind | None:
    """The kind of object at a point with these tags; None if nothing of ours resembles it."""
    # A shelter is larger than the sign that other stops have.
    if tags.get("highway") == "bus_stop" and tags.get("shelter") == "yes":
        return _BUS_SHELTER
    if "traffic_sign" in tags and "highway" not in tags:
        return _SIGN
    if tags.get("indoor") == "yes" or tags.get("location") in {"underground", "indoor"}:
        return None
    return next(
        (kinds[tags[key]] for key, kinds in _BY_TAG.items() if tags.get(key) in kinds), None
    )
