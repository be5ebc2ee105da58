"""The JSON that the AeroScene authors publish beside their USD scenes.

Their repository (aioz-ai/AeroScene, README) describes it like this, and nothing else is known here:

    {"id": sample id, "mesh_floor": mesh floor id,
     "outdoor_scene": [{"name": object id, "translation": translation vector,
                        "rotation": rotation vector, "scale": scale vector,
                        "indoor": null or list of indoor objects, containing translation,
                                  rotation and scale infor}]}

The description leaves the following open. This module reads it so:

- Frame: Isaac Sim's, z up, right-handed.
- `rotation`: three numbers are those of Isaac Sim's property panel, angles about x, then y, then z
  in degrees, or in radians in a file where none exceeds 2 pi. Four are a quaternion w, x, y, z.
- Units: metres, or centimetres if the outdoor objects lie more than 1 km apart, because the assets
  of NVIDIA's town, which they use, are made in centimetres.
- Sizes: the file has none, they are in the meshes. `scale` multiplies the nominal size of our
  category (the geometric middle of the catalogue's range). A scale that most objects share, such as
  0.01, converts units and counts as 1.
- `translation` is the middle of an object's bottom; the ground is at the median of the outdoor
  objects.
- `indoor` objects are children of the building's frame, like prims in USD, unless that puts fewer
  of them into the building than reading them as objects of the world.
- Names: outdoors they are their buildings ("props"), indoors furniture of 3D-FRONT. A known word in
  a name decides; otherwise an outdoor object is a building and an indoor one a box.
- `rotation`, `scale`, `indoor` and the `name` of an indoor object may be missing or null.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from aeroscene.layouts import fields
from aeroscene.layouts.document import LayoutError, LayoutObject, NeutralLayout
from aeroscene.layouts.mapping import match_name
from aeroscene.scene import Quaternion, Vector3
from aeroscene.scene.box import quat_product, rotation_matrix
from aeroscene.scene.catalogue import by_name

OUTDOOR_SUPER_CATEGORY = "building"
INDOOR_SUPER_CATEGORY = "Others"
_CENTIMETRES_FROM = 1000.0
"""Spread of the outdoor objects from which their unit must be the centimetre."""
_UNIT_SCALE = (0.2, 5.0)
"""Range outside of which a scale that most objects share is a change of unit."""
_INSIDE_MARGIN_M = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Thing:
    """One object of the file, in the file's own terms."""

    where: str
    name: str
    translation: Vector3
    rotation: tuple[float, ...]
    scale: Vector3
    indoor: tuple[_Thing, ...] = ()


def aeroscene_layout(value: object, *, skip_invalid: bool = False) -> NeutralLayout:
    """Read the layout in the authors' JSON value.

    Args:
        value: The JSON value.
        skip_invalid: Leave out objects that break a rule, instead of raising.

    Raises:
        LayoutError: If the value breaks a rule; it names scene, object and field.
    """
    record = fields.mapping(value, "scene")
    scene_id = str(record.get("id", "aeroscene"))
    try:
        return _layout(scene_id, record, skip_invalid=skip_invalid)
    except LayoutError as error:
        raise error.within(f"scene {scene_id!r}") from None


def _layout(scene_id: str, record: Mapping[str, Any], *, skip_invalid: bool) -> NeutralLayout:
    invalid: list[str] = []
    faults = invalid if skip_invalid else None
    entries = fields.items(fields.need(record, "outdoor_scene"), "outdoor_scene")
    things = _things(entries, "outdoor_scene", faults)
    if not things:
        raise LayoutError("outdoor_scene has no object that can be used; valid: at least one")
    to_layout = _Conversion(things)
    objects: list[LayoutObject] = []
    for thing in things:
        building = to_layout.in_world(thing)
        objects.append(building)
        objects += to_layout.contents(thing, building, parent=len(objects) - 1)
    return NeutralLayout(
        scene_id=scene_id,
        source="AeroScene authors' JSON",
        domain="outdoor",
        floor=(),
        objects=tuple(objects),
        attributes={"mesh_floor": record.get("mesh_floor")},
        invalid=tuple(invalid),
    )


def _things(entries: Sequence[Any], place: str, faults: list[str] | None) -> tuple[_Thing, ...]:
    things: list[_Thing] = []
    for index, entry in enumerate(entries):
        where = f"{place}[{index}]"
        try:
            things.append(_thing(entry, where, faults))
        except LayoutError as error:
            # Callers without a list of faults want the first fault as an error.
            if faults is None:
                raise
            faults.append(str(error))
    return tuple(things)


def _thing(entry: object, where: str, faults: list[str] | None) -> _Thing:
    # The place tells: indoor objects lie in the list of a building.
    is_indoor = ".indoor[" in where
    named = f"object {where}"
    try:
        record = fields.mapping(entry, "the object")
        name = record.get("name")
        if name is None and not is_indoor:
            fields.need(record, "name")
        name = "object" if name is None else str(name)
        named = f"object {where} ({fields.shown(name)[1:-1]})"
        translation = fields.position(fields.need(record, "translation"), "translation")
        rotation = _rotation(record.get("rotation"))
        scale = _scale(record.get("scale"))
        inside = record.get("indoor")
        indoor_entries = [] if inside is None else fields.items(inside, "indoor")
    except LayoutError as error:
        raise error.within(named) from None
    return _Thing(
        where=where,
        name=name,
        translation=translation,
        rotation=rotation,
        scale=scale,
        indoor=_things(indoor_entries, f"{where}.indoor", faults),
    )


def _rotation(value: object) -> tuple[float, ...]:
    if value is None:
        return (0.0, 0.0, 0.0)
    if isinstance(value, list) and len(value) == 4:
        return fields.quaternion(value, "rotation")
    if not isinstance(value, list) or len(value) != 3:
        raise fields.refuse("rotation", value, "three angles or a quaternion w, x, y, z")
    return tuple(fields.numbers(value, 3, "rotation"))


def _scale(value: object) -> Vector3:
    if value is None:
        return (1.0, 1.0, 1.0)
    if isinstance(value, int | float) and not isinstance(value, bool):
        value = [value] * 3
    x, y, z = fields.numbers(value, 3, "scale")
    if min(x, y, z) <= 0:
        raise fields.refuse("scale", value, "three numbers above 0")
    return (x, y, z)


class _Conversion:
    """Conventions that hold for a whole file: units, angles, ground."""

    def __init__(self, things: Sequence[_Thing]) -> None:
        inner = [child for thing in things for child in thing.indoor]
        spread = max(
            max(thing.translation[axis] for thing in things)
            - min(thing.translation[axis] for thing in things)
            for axis in (0, 1)
        )
        self._unit_m = 0.01 if spread > _CENTIMETRES_FROM else 1.0
        # One angle above 2 pi shows that all of them are degrees.
        angles = [abs(a) for t in (*things, *inner) if len(t.rotation) == 3 for a in t.rotation]
        is_radian = max(angles, default=0.0) <= 2 * math.pi
        self._radians = 1.0 if is_radian else math.pi / 180
        self._unit_scale = {False: _shared_scale(things), True: _shared_scale(inner)}
        self._ground = statistics.median(thing.translation[2] for thing in things)

    def in_world(self, thing: _Thing, parent: int | None = None) -> LayoutObject:
        """Object of the world; it is indoors if it has a parent."""
        x, y, z = thing.translation
        foot = (x * self._unit_m, y * self._unit_m, (z - self._ground) * self._unit_m)
        return self._object(thing, foot, self._quat(thing), parent)

    def contents(self, thing: _Thing, building: LayoutObject, parent: int) -> list[LayoutObject]:
        """Contents of a building, in the reading of its frame that puts more of them inside."""
        # Both readings are tried, because the description leaves it open.
        local = [self._in_building(child, building, parent) for child in thing.indoor]
        world = [self.in_world(child, parent) for child in thing.indoor]
        if _n_inside(world, building) > _n_inside(local, building):
            return world
        return local

    def _in_building(self, child: _Thing, building: LayoutObject, parent: int) -> LayoutObject:
        rotation = rotation_matrix(building.q)
        offset = rotation @ [v * self._unit_m for v in child.translation]
        # The frame's origin is in the middle of the building's bottom.
        down = rotation @ (0.0, 0.0, building.s[2] / 2)
        x, y, z = (float(p + o - d) for p, o, d in zip(building.p, offset, down, strict=True))
        w, i, j, k = quat_product(building.q, self._quat(child))
        return self._object(child, (x, y, z), (w, i, j, k), parent)

    def _quat(self, thing: _Thing) -> Quaternion:
        if len(thing.rotation) == 4:
            w, x, y, z = thing.rotation
            return (w, x, y, z)
        # About x first, then y, then z, each about a fixed axis: later turns multiply from the
        # left.
        quat: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
        for axis, angle in enumerate(thing.rotation):
            half = angle * self._radians / 2
            turn = [math.cos(half), 0.0, 0.0, 0.0]
            turn[1 + axis] = math.sin(half)
            quat = quat_product(tuple(turn), quat)
        norm = math.hypot(*quat)
        w, x, y, z = (v / norm for v in quat)
        return (w, x, y, z)

    def _object(
        self, thing: _Thing, foot: Vector3, quat: Quaternion, parent: int | None
    ) -> LayoutObject:
        is_indoor = parent is not None
        wider = INDOOR_SUPER_CATEGORY if is_indoor else OUTDOOR_SUPER_CATEGORY
        scales = zip(thing.scale, self._unit_scale[is_indoor], strict=True)
        nominal = _nominal_size(thing.name, is_indoor=is_indoor)
        sized = [a * b / c for a, (b, c) in zip(nominal, scales, strict=True)]
        try:
            size = fields.size(sized, "scale times nominal size")
        except LayoutError as error:
            raise error.within(f"object {thing.where} ({thing.name})") from None
        up = rotation_matrix(quat) @ (0.0, 0.0, size[2] / 2)
        x, y, z = (round(float(f + u), 4) for f, u in zip(foot, up, strict=True))
        return LayoutObject(
            category=thing.name,
            super_category=wider,
            p=(x, y, z),
            q=quat,
            s=size,
            parent=parent,
            name=thing.name,
        )


def _shared_scale(things: Sequence[_Thing]) -> Vector3:
    """Scale that counts as 1: the median if it is a change of unit."""
    if not things:
        return (1.0, 1.0, 1.0)
    medians = [statistics.median(thing.scale[axis] for thing in things) for axis in range(3)]
    low, high = _UNIT_SCALE
    # A median near 1 is a size, not a unit, and is kept in the sizes.
    x, y, z = (1.0 if low <= m <= high else m for m in medians)
    return (x, y, z)


def _nominal_size(name: str, *, is_indoor: bool) -> Vector3:
    found = match_name(name)
    fallback = "box" if is_indoor else "building"
    category = by_name()[fallback if found is None else found.category]
    ranges = (category.length_m, category.width_m, category.height_m)
    # The geometric middle, because ranges of sizes span a factor rather than a difference.
    x, y, z = (round(math.sqrt(low * high), 2) for low, high in ranges)
    return (x, y, z)


def _n_inside(objects: Sequence[LayoutObject], building: LayoutObject) -> int:
    rotation = rotation_matrix(building.q)
    half = [extent / 2 + _INSIDE_MARGIN_M for extent in building.s]
    count = 0
    for obj in objects:
        offset = [a - b for a, b in zip(obj.p, building.p, strict=True)]
        local = (rotation.T @ offset).tolist()
        count += all(abs(v) <= reach for v, reach in zip(local, half, strict=True))
    return count
