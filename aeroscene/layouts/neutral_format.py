"""The neutral layout format: JSON lines, one scene a line, plain or gzip.

    {"scene_id": text, "source": text, "domain": "indoor" | "outdoor",
     "floor": [[x, y], ...],
     "objects": [{"category": text, "p": [x, y, z], "q": [w, x, y, z], "s": [sx, sy, sz],
                  "parent": index | null}],
     "attributes": {...}}

Metres, right-handed, z up. `p` is the centre of the oriented box, `q` the unit quaternion from the
box to the world, `s` the full extents along the box's axes. The floor is an outline, not closed,
at z = 0. `parent` is the index of an object further up in the list. Indoors the front of an
object is its +y axis; outdoors x is the long side and nothing has a front. `source`, `attributes`
and `parent` may be missing; `attributes.rooms` may list rooms as `{"room_type", "polygon"}`.

A line may also be a house of ProcTHOR or Holodeck, see `thor`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aeroscene.layouts import fields
from aeroscene.layouts.document import (
    LayoutDomain,
    LayoutError,
    LayoutObject,
    LayoutRoom,
    NeutralLayout,
)
from aeroscene.layouts.text_file import parse_json, source_name, text_lines
from aeroscene.layouts.thor import KEYS, read_asset_sizes, thor_layout


def read_neutral(
    path: str | Path, skip_invalid: bool = False, faults: list[str] | None = None
) -> Iterator[NeutralLayout]:
    """Read the scenes of a file, one after another.

    Args:
        path: File of JSON lines, gzip or not.
        skip_invalid: Leave out objects and scenes that break a rule, instead of raising.
        faults: Receives one line for every scene left out. Objects left out of a scene that is kept
            are in its `invalid`.

    Raises:
        LayoutError: If a line breaks a rule; it names file, line, scene, object and field.
    """
    for layout in read_each(Path(path), skip_invalid=skip_invalid):
        if isinstance(layout, NeutralLayout):
            yield layout
        elif not skip_invalid:
            raise layout
        elif faults is not None:
            faults.append(str(layout))


def read_each(path: Path, *, skip_invalid: bool) -> Iterator[NeutralLayout | LayoutError]:
    """Read every line of a file that is not blank: its scene, or its error.

    Args:
        path: File of JSON lines, gzip or not.
        skip_invalid: Leave out objects that break a rule.

    Raises:
        LayoutError: If the file itself cannot be read.
    """
    where = source_name(path)
    seen: set[str] = set()
    for number, line, fault in text_lines(path):
        if fault is not None:
            yield fault
            continue
        try:
            record = parse_json(line, where, number)
        except LayoutError as error:
            # Without its frames, which would keep the line and its values in memory.
            yield error.with_traceback(None)
            continue
        try:
            layout = _of_line(record, path, number, skip_invalid=skip_invalid)
            _check_new(layout.scene_id, seen)
        except LayoutError as error:
            yield LayoutError(f"{where} line {number}: {error}")
            continue
        seen.add(layout.scene_id)
        yield layout


def _of_line(record: object, path: Path, number: int, *, skip_invalid: bool) -> NeutralLayout:
    """The scene of a line; ProcTHOR-10k too is a file of lines, each a house without a name."""
    if isinstance(record, dict) and record.keys() >= KEYS:
        sizes = read_asset_sizes(path.parent)
        name = f"house-{number - 1}"
        return thor_layout(record, name, skip_invalid=skip_invalid, asset_sizes=sizes)
    return neutral_layout(record, skip_invalid=skip_invalid)


def _check_new(scene_id: str, seen: set[str]) -> None:
    if scene_id in seen:
        raise LayoutError(f"scene {scene_id!r}: scene_id is used twice; valid: an id of its own")


def neutral_layout(value: object, *, skip_invalid: bool = False) -> NeutralLayout:
    """Read one scene from its JSON value.

    Args:
        value: The JSON value.
        skip_invalid: Leave out objects that break a rule, instead of raising.

    Raises:
        LayoutError: If the value breaks a rule; it names scene, object and field.
    """
    record = fields.mapping(value, "scene")
    scene_id = fields.text(fields.need(record, "scene_id"), "scene_id")
    try:
        return _layout(scene_id, record, skip_invalid=skip_invalid)
    except LayoutError as error:
        raise error.within(f"scene {scene_id!r}") from None


def _layout(scene_id: str, record: Any, *, skip_invalid: bool) -> NeutralLayout:
    domain = _domain(fields.need(record, "domain"))
    floor = fields.polygon(fields.need(record, "floor"), "floor")
    attributes = fields.mapping(record.get("attributes") or {}, "attributes")
    entries = fields.items(fields.need(record, "objects"), "objects")
    objects, invalid = _objects(entries, skip_invalid=skip_invalid)
    return NeutralLayout(
        scene_id=scene_id,
        source=fields.text(record.get("source", ""), "source", is_empty_valid=True),
        domain=domain,
        floor=floor,
        objects=objects,
        rooms=_rooms(attributes),
        front="y" if domain == "indoor" else "x",
        attributes=attributes,
        invalid=invalid,
    )


def _domain(value: object) -> LayoutDomain:
    if value == "indoor":
        return "indoor"
    if value == "outdoor":
        return "outdoor"
    raise fields.refuse("domain", value, "indoor, outdoor")


def _rooms(attributes: Any) -> tuple[LayoutRoom, ...]:
    rooms: list[LayoutRoom] = []
    for index, entry in enumerate(fields.items(attributes.get("rooms") or [], "attributes.rooms")):
        where = f"attributes.rooms[{index}]"
        room = fields.mapping(entry, where)
        name = fields.text(room.get("room_type", "room"), f"{where}.room_type")
        outline = fields.polygon(fields.need(room, "polygon", f"{where}."), f"{where}.polygon")
        rooms.append(LayoutRoom(name=name, polygon=outline))
    return tuple(rooms)


def _objects(
    entries: Any, *, skip_invalid: bool
) -> tuple[tuple[LayoutObject, ...], tuple[str, ...]]:
    """Objects in order; children of one that is left out go to its nearest kept ancestor."""
    objects: list[LayoutObject] = []
    invalid: list[str] = []
    # New index of each entry, or of its kept ancestor if it was left out.
    new_index: list[int | None] = []
    for index, entry in enumerate(entries):
        try:
            objects.append(_object(index, entry, new_index))
            new_index.append(len(objects) - 1)
        except LayoutError as error:
            if not skip_invalid:
                raise
            invalid.append(str(error))
            new_index.append(_kept_ancestor(index, entry, new_index))
    return tuple(objects), tuple(invalid)


def _object(index: int, entry: object, new_index: list[int | None]) -> LayoutObject:
    where = f"object {index}"
    try:
        record = fields.mapping(entry, "the object")
        category = fields.text(fields.need(record, "category"), "category")
        where = f"object {index} ({fields.shown(category)[1:-1]})"
        parent = _parent(index, record.get("parent"))
        return LayoutObject(
            category=category,
            p=fields.position(fields.need(record, "p"), "p"),
            q=fields.quaternion(fields.need(record, "q"), "q"),
            s=fields.size(fields.need(record, "s"), "s"),
            parent=None if parent is None else new_index[parent],
        )
    except LayoutError as error:
        raise error.within(where) from None


def _parent(index: int, value: object) -> int | None:
    """Index of an earlier object, which rules out cycles and missing parents."""
    if value is None:
        return None
    # In Python true is an int as well.
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < index:
        raise fields.refuse("parent", value, "null or the index of an object before it")
    return value


def _kept_ancestor(index: int, entry: object, new_index: list[int | None]) -> int | None:
    try:
        parent = _parent(index, entry.get("parent") if isinstance(entry, dict) else None)
    except LayoutError:
        return None
    return None if parent is None else new_index[parent]
