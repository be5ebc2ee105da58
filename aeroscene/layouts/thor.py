"""Houses of AI2-THOR as ProcTHOR and Holodeck write them: one JSON object a house, y up, metres.

The fields, according to the two projects' published code (allenai/procthor and allenai/Holodeck):

- `rooms[]`: `id`, `roomType`, `floorPolygon`, a list of `{x, y, z}`.
- `walls[]`, `doors[]`, `windows[]`: not read; our walls and openings are made from the rooms.
- `objects[]`: `id`, `assetId`, `position` (the middle of the object's box), `rotation` (Euler
  angles of Unity in degrees: about z, then x, then y), `children` (objects that stand on it, placed
  in the world, not in the parent). Holodeck writes a flat list. Its `id` is a name with the room
  (`table-0 (kitchen)`); a small object has its own name before that (`plate-0|table-0 (kitchen)`).
  It adds `object_name` to some objects. Objects on the floor or on a wall also have `vertices`, the
  outline of their box in cm, 10 cm wider than the box.

Unity's frame is left-handed, x right, y up, z ahead, and turns clockwise seen from above. A model's
front is its +z. The frame becomes ours by X = x, Y = z, Z = y.

No house states the size of an object. A size comes from an `asset-database.json` of ProcTHOR beside
the file or a folder up; else from `vertices`; else it is the median of the object's type; else the
middle of our catalogue's range. In all but the first case the height follows from the position: the
object stands on the floor, or on its parent, if it is then half to twice as high as expected.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from scipy.spatial.transform import Rotation

from aeroscene.layouts import fields
from aeroscene.layouts.document import LayoutError, LayoutObject, LayoutRoom, NeutralLayout, Point2
from aeroscene.layouts.mapping import match_name
from aeroscene.layouts.thor_sizes import typical_sizes_m
from aeroscene.scene import Quaternion, Vector3
from aeroscene.scene.box import MAX_EXTENT_M, MIN_SIZE_M
from aeroscene.scene.catalogue import by_name
from aeroscene.scene.polygon import signed_area

KEYS = frozenset({"rooms", "walls", "objects"})
"""Keys that every house has, and no other form."""
_WIDER_CM = 10.0
"""Width by which Holodeck's outlines exceed the box, cm."""
_HEIGHTS = (0.5, 2.0)
"""Shares of the typical height between which the height may follow from the position."""
_WALL_TYPES = frozenset({"Painting", "LightSwitch", "TowelHolder", "HandTowelHolder"})
"""Types that hang on walls: their height does not follow from their position."""
_MOST_NESTED = 8
# Assets whose names are not those of their types.
_OTHER_NAMES = {
    "walldecor": "Painting",
    "racquet": "TennisRacket",
    "remote": "RemoteControl",
    "boot": "Boots",
    "papertowel": "PaperTowelRoll",
}

AssetSizes = Mapping[str, Vector3]


@cache
def read_asset_sizes(folder: Path) -> AssetSizes:
    """Read width, depth and height by asset from an `asset-database.json` there or one folder up.

    Returns:
        Sizes, m; empty without a readable file, because sizes have other sources.
    """
    for path in (folder / "asset-database.json", folder.parent / "asset-database.json"):
        try:
            groups = json.loads(path.read_bytes())
            listed = [asset for group in groups.values() for asset in group]
            return {str(asset["assetId"]): _size_of(asset["boundingBox"]) for asset in listed}
        except (OSError, ValueError, AttributeError, KeyError, TypeError, RecursionError):
            continue
    return {}


def _size_of(box: Mapping[str, Any]) -> Vector3:
    return (float(box["x"]), float(box["z"]), float(box["y"]))


def thor_layout(
    value: object,
    scene_id: str,
    *,
    skip_invalid: bool = False,
    asset_sizes: AssetSizes | None = None,
) -> NeutralLayout:
    """Read the layout of a house from its JSON value.

    Args:
        value: The JSON value.
        scene_id: Name of the scene; houses have none.
        skip_invalid: Leave out objects that break a rule, instead of raising.
        asset_sizes: See `read_asset_sizes`.

    Raises:
        LayoutError: If the value breaks a rule; it names scene, object and field.
    """
    record = fields.mapping(value, "house")
    try:
        return _House(skip_invalid, asset_sizes or {}).layout(scene_id, record)
    except LayoutError as error:
        raise error.within(f"scene {scene_id!r}") from None


class _House:
    """Parts of one house while it is read."""

    def __init__(self, skip_invalid: bool, asset_sizes: AssetSizes) -> None:
        self._skip_invalid = skip_invalid
        self._asset_sizes = asset_sizes
        self._objects: list[LayoutObject] = []
        self._index_of: dict[str, int] = {}
        self._invalid: list[str] = []

    def layout(self, scene_id: str, record: Mapping[str, Any]) -> NeutralLayout:
        rooms = _rooms(record)
        if not rooms:
            raise LayoutError("rooms is empty; valid: at least one with a floorPolygon")
        east, north = _middle(rooms)
        self._shift = (east, north)
        entries = fields.items(fields.need(record, "objects"), "objects")
        self._read(entries, "objects", None, depth=0)
        return NeutralLayout(
            scene_id=scene_id,
            source="AI2-THOR",
            domain="indoor",
            floor=(),
            objects=tuple(self._objects),
            rooms=tuple(_moved(room, east, north) for room in rooms),
            front="y",
            invalid=tuple(self._invalid),
        )

    def _read(self, entries: Any, where: str, parent: int | None, depth: int) -> None:
        """Read a list of objects and, after each, its children."""
        if depth > _MOST_NESTED:
            raise LayoutError(f"{where} is too deep; valid: {_MOST_NESTED} levels of children")
        for number, entry in enumerate(entries):
            here = f"{where}[{number}]"
            host = parent
            try:
                record = fields.mapping(entry, "the object")
                host = self._host(record) if parent is None else parent
                self._objects.append(self._object(record, host))
            except LayoutError as error:
                named = error.within(f"object {here}")
                if not self._skip_invalid:
                    raise named from None
                self._invalid.append(str(named))
                # Children of an object that is left out are left out with it.
                continue
            index = len(self._objects) - 1
            self._index_of[str(record.get("id"))] = index
            children = fields.items(record.get("children") or [], f"{here}.children")
            self._read(children, f"{here}.children", index, depth + 1)

    def _host(self, record: Mapping[str, Any]) -> int | None:
        """Holodeck's host of a small object, which its id names."""
        identity = str(record.get("id"))
        return self._index_of.get(identity.partition("|")[2]) if _is_holodecks(identity) else None

    def _object(self, record: Mapping[str, Any], parent: int | None) -> LayoutObject:
        asset = fields.text(fields.need(record, "assetId"), "assetId")
        name = category_of(asset, str(record.get("id")), record.get("object_name"))
        x, y, z = _xyz(fields.need(record, "position"), "position")
        position = fields.position([x - self._shift[0], z - self._shift[1], y], "position")
        floor_m = 0.0
        if parent is not None:
            host = self._objects[parent]
            floor_m = host.p[2] + host.s[2] / 2
        size = self._size(record, asset, name, y - floor_m)
        return LayoutObject(
            category=name,
            super_category="Others",
            p=(round(position[0], 4), round(position[1], 4), round(position[2], 4)),
            q=_quaternion(record.get("rotation")),
            s=size,
            parent=parent,
            name=str(record.get("id")),
        )

    def _size(self, record: Mapping[str, Any], asset: str, name: str, middle_m: float) -> Vector3:
        """Width, depth and height of an object.

        Args:
            record: The object.
            asset: Id of its asset.
            name: Its type.
            middle_m: Height of its middle above the surface on which it stands.
        """
        if asset in self._asset_sizes:
            return _within_limits(self._asset_sizes[asset])
        width_m, depth_m, height_m = typical_sizes_m().get(name) or _nominal_size_m(name)
        if record.get("vertices") is not None:
            width_m, depth_m = _outline_m(record)
        # The middle of an object that stands is at half its height.
        low, high = (share * height_m for share in _HEIGHTS)
        if name not in _WALL_TYPES and low <= 2.0 * middle_m <= high:
            height_m = 2.0 * middle_m
        return _within_limits((width_m, depth_m, height_m))


def category_of(asset: str, identity: str, object_name: object = None) -> str:
    """Type of an asset of ProcTHOR, or Holodeck's name of an object.

    ProcTHOR's assets are named after their types: `RoboTHOR_side_table_tolkning` is a SideTable.
    Assets that Holodeck takes from Objaverse are named by a hash.
    """
    if _is_holodecks(identity):
        given = object_name if isinstance(object_name, str) else re.split(r"\|| \(", identity)[0]
        name = re.sub(r"-\d+$", "", given).replace("_", " ") or asset
        # A name of ours first; otherwise a type whose typical size is known.
        return name if match_name(name) is not None else _type_in(name) or name
    squeezed = re.sub("[^a-z]", "", asset.lower())
    return next((kind for part, kind in _types() if part in squeezed), asset)


def _type_in(name: str) -> str | None:
    """AI2-THOR's type that the last one or two words of a name form."""
    words, types = name.lower().split(), dict(_types())
    return types.get("".join(words[-2:])) or types.get(words[-1] if words else "")


def _is_holodecks(identity: str) -> bool:
    return identity.endswith(")")


@cache
def _types() -> tuple[tuple[str, str], ...]:
    """Types under the letters that stand for them in assets, the longest first."""
    letters = {name.lower(): name for name in typical_sizes_m()} | _OTHER_NAMES
    return tuple(sorted(letters.items(), key=lambda pair: -len(pair[0])))


def _nominal_size_m(name: str) -> Vector3:
    """Width, depth and height of our category, whose own x axis is its front."""
    found = match_name(name)
    category = by_name()["box" if found is None else found.category]
    ranges = (category.width_m, category.length_m, category.height_m)
    x, y, z = (round(math.sqrt(low * high), 2) for low, high in ranges)
    return (x, y, z)


def _outline_m(record: Mapping[str, Any]) -> tuple[float, float]:
    """Width and depth of Holodeck's outline, along the object's own axes."""
    corners = [fields.numbers(corner, 2, "vertices") for corner in _listed(record["vertices"])]
    if len(corners) < 3:
        raise fields.refuse("vertices", record["vertices"], "at least 3 corners [x, z] in cm")
    east, north = (
        (max(values) - min(values) - _WIDER_CM) / 100.0 for values in zip(*corners, strict=True)
    )
    # Quarter turns exchange width and depth.
    turn_deg = _xyz(record.get("rotation") or {"x": 0, "y": 0, "z": 0}, "rotation")[1]
    return (north, east) if round(turn_deg / 90.0) % 2 else (east, north)


def _listed(value: object) -> list[Any]:
    return [list(v) if isinstance(v, tuple) else v for v in fields.items(value, "vertices")]


def _quaternion(value: object) -> Quaternion:
    if value is None:
        return (1.0, 0.0, 0.0, 0.0)
    x, y, z = _xyz(value, "rotation")
    # Unity turns about z, then x, then y, all about fixed axes: intrinsic YXZ.
    turn = Rotation.from_euler("YXZ", (y, x, z), degrees=True)
    w, a, b, c = turn.as_quat(canonical=True, scalar_first=True).tolist()
    # The exchange of y and z mirrors the axis of the turn.
    return (w, -a + 0.0, -c + 0.0, -b + 0.0)


def _xyz(value: object, field_name: str) -> list[float]:
    point = fields.mapping(value, field_name)
    listed = [fields.need(point, axis, f"{field_name}.") for axis in "xyz"]
    return fields.numbers(listed, 3, field_name)


def _rooms(record: Mapping[str, Any]) -> tuple[LayoutRoom, ...]:
    rooms: list[LayoutRoom] = []
    for number, entry in enumerate(fields.items(fields.need(record, "rooms"), "rooms")):
        where = f"rooms[{number}]"
        room = fields.mapping(entry, where)
        corners = fields.items(fields.need(room, "floorPolygon", f"{where}."), f"{where}.floor")
        points = [_xyz(corner, f"{where}.floorPolygon[{i}]") for i, corner in enumerate(corners)]
        outline = fields.polygon([[x, z] for x, _, z in points], f"{where}.floorPolygon")
        name = str(room.get("roomType") or room.get("id") or f"room {number}")
        rooms.append(LayoutRoom(name=name, polygon=outline))
    return tuple(rooms)


def _middle(rooms: tuple[LayoutRoom, ...]) -> Point2:
    points = [point for room in rooms for point in room.polygon]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return ((min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2)


def _moved(room: LayoutRoom, east: float, north: float) -> LayoutRoom:
    outline = tuple((round(x - east, 4), round(y - north, 4)) for x, y in room.polygon)
    assert signed_area(outline) > 0
    return LayoutRoom(name=room.name, polygon=outline)


def _within_limits(size: Vector3) -> Vector3:
    """Sizes that a box may have: assets may be as thin as paper."""
    x, y, z = (round(min(max(extent, MIN_SIZE_M), MAX_EXTENT_M), 4) for extent in size)
    return (x, y, z)
