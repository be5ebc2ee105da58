"""3D-FRONT's own JSON: one file for each house, y up, metres.

Its fields, according to the data set's published toolbox (3D-FRONT-ToolBox) and the reader of
ATISS:

- `furniture[]`: `uid` (the reference of children), `jid` (the 3D-FUTURE model), `size` (extents of
  the model, x, y up, z; older files call it `bbox`), `category` or `title` (often missing: then
  `model_info.json` of 3D-FUTURE states it by `jid`), `valid` (false: the model is not public, and
  every reader leaves the piece out; missing counts as true here).
- `mesh[]`: the architecture as triangles: `uid`, `type` (Floor, WallInner, WallOuter, Ceiling,
  Door, Window, ...), `xyz` and `faces`, both flat lists.
- `scene.room[]`: `type`, `instanceid`, and `children[]`, each with `ref` (a `uid` of furniture or
  mesh; others are lights and the like, ignored), `pos`, `rot` (quaternion x, y, z, w), `scale`.
  Positions are those of the house; no reader applies the rooms' own `pos` and `rot`.
- A model's origin is the middle of its bottom, its front +z.

The frame becomes ours by X = -x, Y = z, Z = y, a proper rotation, with the origin in the middle of
the floors. Floors become rooms. Walls are built from their outlines, because meshes of walls are
open shells with door leaves in them. There is no hierarchy: `parent` is always None.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from aeroscene.files import UnpackError, read_bounded
from aeroscene.files.bounds import MOST_VALUES
from aeroscene.layouts import fields
from aeroscene.layouts.document import LayoutError, LayoutObject, LayoutRoom, NeutralLayout, Point2
from aeroscene.layouts.text_file import MOST_BYTES, parse_json
from aeroscene.scene import Quaternion, Vector3
from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.polygon import signed_area

if TYPE_CHECKING:
    import shapely

_CLOSE_M = 0.005
_SIMPLIFY_M = 0.02
_LEAST_ROOM_M2 = 0.5
_MOST_RECORDS = 100_000
"""Most meshes, pieces of furniture and children of a house."""
_MOST_TRIANGLES = 50_000
"""Most triangles of all floors of a house."""
_MARGIN_M = 0.5
"""Width of floor around the furniture of a house without floors."""

ModelInfo = Mapping[str, Mapping[str, Any]]


def read_model_info(folder: Path) -> ModelInfo:
    """Read 3D-FUTURE's `model_info.json`, if it lies in the folder or the one above.

    Returns:
        Its records under `model_id`; empty without a readable file, because a layout can be mapped
        without it.
    """
    for path in (folder / "model_info.json", folder.parent / "model_info.json"):
        try:
            records = parse_json(read_bounded(path, MOST_BYTES), str(path))
        except (OSError, UnpackError, LayoutError):
            continue
        if isinstance(records, list):
            entries = [record for record in records if isinstance(record, dict)]
            return {str(entry.get("model_id")): entry for entry in entries}
    return {}


class _Mesh(msgspec.Struct):
    """A mesh as text: only the few meshes of floors are decoded."""

    uid: msgspec.Raw = msgspec.Raw(b"null")
    type: msgspec.Raw = msgspec.Raw(b'""')
    xyz: msgspec.Raw = msgspec.Raw(b"null")
    faces: msgspec.Raw = msgspec.Raw(b"null")


def house_value(data: bytes, where: str) -> dict[str, Any] | None:
    """Parse the JSON of a house as far as it is read; the numbers of its meshes stay text.

    Args:
        data: JSON text of up to `MOST_BYTES`, most of which are vertices of walls.
        where: Name of the text in an error.

    Returns:
        The value; None if the text is no house.

    Raises:
        LayoutError: If a part of it exceeds the bounds of one scene.
    """
    # Counted in the text: to decode first would fill the memory.
    if data.count(b":") > MOST_VALUES or data.count(b"{") > _MOST_RECORDS:
        return None
    try:
        parts = msgspec.json.decode(data, type=dict[str, msgspec.Raw])
        if not parts.keys() >= {"furniture", "scene"} or "outdoor_scene" in parts:
            return None
        meshes = msgspec.json.decode(parts.get("mesh", b"[]"), type=list[_Mesh])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None  # the reader of the whole text reports the fault
    names = ("uid", "furniture", "scene")
    value = {name: parse_json(bytes(parts[name]), where) for name in names if name in parts}
    if "mesh" in parts:
        value["mesh"] = [
            {
                "uid": parse_json(bytes(mesh.uid), where),
                "type": parse_json(bytes(mesh.type), where),
                "xyz": mesh.xyz,
                "faces": mesh.faces,
            }
            for mesh in meshes
        ]
    return value


def front3d_layout(
    value: object, *, skip_invalid: bool = False, model_info: ModelInfo | None = None
) -> NeutralLayout:
    """Read the layout of a house from its JSON value.

    Args:
        value: Value of `house_value`.
        skip_invalid: Leave out objects that break a rule, instead of raising.
        model_info: See `read_model_info`.

    Raises:
        LayoutError: If the value breaks a rule; it names scene, object and field.
    """
    record = fields.mapping(value, "house")
    scene_id = str(record.get("uid") or "house")
    try:
        return _House(record, skip_invalid, model_info or {}).layout(scene_id)
    except LayoutError as error:
        raise error.within(f"scene {scene_id!r}") from None


class _House:
    """Parts of one file while it is read."""

    def __init__(self, record: Mapping[str, Any], skip_invalid: bool, info: ModelInfo) -> None:
        self._record = record
        self._skip_invalid = skip_invalid
        self._info = info
        self._invalid: list[str] = []
        self._n_ignored = 0
        self._n_triangles = 0

    def layout(self, scene_id: str) -> NeutralLayout:
        furniture = self._by_uid("furniture")
        meshes = self._by_uid("mesh") if "mesh" in self._record else {}
        scene = fields.mapping(fields.need(self._record, "scene"), "scene")
        objects: list[LayoutObject] = []
        rooms: list[LayoutRoom] = []
        for number, entry in enumerate(fields.items(fields.need(scene, "room"), "scene.room")):
            room = fields.mapping(entry, f"scene.room[{number}]")
            name = str(room.get("instanceid") or room.get("type") or f"room {number}")
            floors: list[np.ndarray] = []
            children = fields.items(room.get("children") or [], f"scene.room[{number}].children")
            for index, child in enumerate(children):
                where = f"object {name}/children[{index}]"
                self._read_child(child, where, furniture, meshes, objects, floors)
            outline = _outline(floors)
            if outline:
                rooms.append(LayoutRoom(name=name, polygon=outline))
        return self._centred(scene_id, objects, rooms)

    def _by_uid(self, key: str) -> dict[str, Mapping[str, Any]]:
        found: dict[str, Mapping[str, Any]] = {}
        for index, entry in enumerate(fields.items(fields.need(self._record, key), key)):
            where = f"{key}[{index}]"
            with _Skip(self, where):
                record = fields.mapping(entry, where)
                uid = fields.text(fields.need(record, "uid"), "uid")
                if uid in found:
                    raise LayoutError(f"uid {uid!r} is used twice; valid: a uid of its own")
                found[uid] = record
        return found

    def _read_child(
        self,
        child: object,
        where: str,
        furniture: Mapping[str, Mapping[str, Any]],
        meshes: Mapping[str, Mapping[str, Any]],
        objects: list[LayoutObject],
        floors: list[np.ndarray],
    ) -> None:
        with _Skip(self, where):
            record = fields.mapping(child, "the child")
            ref = fields.text(fields.need(record, "ref"), "ref")
            # Neither list needs the other: a child is a piece of furniture or a mesh.
            if ref in furniture and furniture[ref].get("valid", True):
                objects.append(self._piece(record, furniture[ref]))
            elif ref in meshes:
                if "floor" in str(meshes[ref].get("type", "")).lower():
                    floors.append(self._floor(record, meshes[ref]))
            else:
                self._n_ignored += 1

    def _floor(self, child: Mapping[str, Any], mesh: Mapping[str, Any]) -> np.ndarray:
        triangles = _triangles(child, mesh)
        self._n_triangles += len(triangles)
        if self._n_triangles > _MOST_TRIANGLES:
            raise LayoutError(f"floors have more than {_MOST_TRIANGLES} triangles; valid: fewer")
        return triangles

    def _piece(self, child: Mapping[str, Any], piece: Mapping[str, Any]) -> LayoutObject:
        info = self._info.get(str(piece.get("jid")), {})
        title = str(piece.get("title") or "")
        category = piece.get("category") or title or info.get("category")
        wider = info.get("super-category") or title.partition("/")[0].title()
        pos, quat, scale = _pose(child)
        model_size = fields.numbers(piece.get("size", piece.get("bbox")), 3, "size")
        # Mirrored models have negative scales.
        scaled = [abs(a * b) for a, b in zip(model_size, scale, strict=True)]
        x, y, z = fields.size(scaled, "size times scale")
        # The origin is the middle of the model's bottom, and our boxes have theirs in the middle.
        up = rotation_matrix(quat) @ (0.0, 0.0, y / 2)
        centre = (pos[0] + float(up[0]), pos[1] + float(up[1]), pos[2] + float(up[2]))
        return LayoutObject(
            category=str(category or wider or "unknown"),
            super_category=str(wider),
            p=centre,
            q=quat,
            # The model's y is up, ours is z.
            s=(x, z, y),
            name=str(piece.get("uid")),
        )

    def _centred(
        self, scene_id: str, objects: list[LayoutObject], rooms: list[LayoutRoom]
    ) -> NeutralLayout:
        """The layout, moved so that the origin is the middle of the floors."""
        points = [point for room in rooms for point in room.polygon]
        if not points:
            points = _corners_about(objects)
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        east, north = ((low + high) / 2).tolist()
        moved = tuple(
            LayoutRoom(
                name=room.name,
                polygon=tuple((round(x - east, 4), round(y - north, 4)) for x, y in room.polygon),
            )
            for room in rooms
        )
        half = (high - low) / 2
        floor = () if moved else _rectangle(float(half[0]), float(half[1]))
        return NeutralLayout(
            scene_id=scene_id,
            source="3D-FRONT",
            domain="indoor",
            floor=floor,
            objects=tuple(_moved(obj, east, north) for obj in objects),
            rooms=moved,
            front="y",
            attributes={"ignored_children": self._n_ignored},
            invalid=tuple(self._invalid),
        )


class _Skip:
    """Context that names its place in errors and, if asked for, notes them instead of raising."""

    def __init__(self, house: _House, where: str) -> None:
        self._house = house
        self._where = where

    def __enter__(self) -> None:
        return

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        if not isinstance(error, LayoutError):
            return False
        named = error.within(self._where)
        if not self._house._skip_invalid:
            raise named from None
        self._house._invalid.append(str(named))
        return True


def _pose(child: Mapping[str, Any]) -> tuple[Vector3, Quaternion, Sequence[float]]:
    """Position, attitude and scale of a child; the scale is not in our frame."""
    x, y, z = fields.position(fields.need(child, "pos"), "pos")
    qx, qy, qz, qw = fields.quaternion(fields.need(child, "rot"), "rot")
    scale = fields.numbers(child.get("scale", [1, 1, 1]), 3, "scale")
    # The axis (x, y, z) of the turn becomes (-x, z, y), like every vector.
    return (-x, z, y), (qw, -qx, qz, qy), scale


def _triangles(child: Mapping[str, Any], mesh: Mapping[str, Any]) -> np.ndarray:
    """Corners of a mesh's triangles seen from above, shape (n, 3, 2), m."""
    pos, quat, scale = _pose(child)
    try:
        vertices = _flat(mesh["xyz"], np.float64).reshape(-1, 3) * scale
        faces = _flat(mesh["faces"], np.int64).reshape(-1, 3)
        corners = vertices[faces]
    except (KeyError, ValueError, TypeError, IndexError, OverflowError):
        raise LayoutError(
            f"xyz and faces of mesh {mesh.get('uid')!r} are no triangles; valid: flat lists of "
            "numbers, three a vertex, and of vertex numbers, three a face"
        ) from None
    if not np.isfinite(corners).all() or np.abs(corners).max(initial=0) > fields.MAX_POSITION_M:
        raise fields.refuse("xyz", mesh.get("uid"), "finite numbers")
    # The frame as above: X = -x, Y = z, Z = y.
    ours = np.stack([-corners[..., 0], corners[..., 2], corners[..., 1]], axis=-1)
    return (ours @ rotation_matrix(quat).T + pos)[..., :2]


def _flat(values: object, kind: type[np.number]) -> np.ndarray:
    """Numbers of a list, which may still be text.

    Raises:
        ValueError: If it is no list of numbers, or has more than a floor can have.
    """
    if isinstance(values, msgspec.Raw):
        text = bytes(values)
        # Commas bound the numbers before they are decoded.
        if text.count(b",") > 3 * _MOST_TRIANGLES:
            raise ValueError("too many numbers")
        values = msgspec.json.decode(text, type=list[float])
    return np.asarray(values, dtype=kind)


def _outline(floors: list[np.ndarray]) -> tuple[Point2, ...]:
    """Outline of the largest part of a room's floor, without holes; empty if it has none."""
    if not floors:
        return ()
    import shapely

    triangles = [shapely.Polygon(corners) for corners in np.concatenate(floors)]
    # Grown and shrunk again: triangles of a floor leave gaps of a millimetre between them.
    whole = shapely.union_all([t.buffer(_CLOSE_M, join_style="mitre") for t in triangles if t.area])
    whole = whole.buffer(-_CLOSE_M, join_style="mitre")
    parts: list[shapely.Polygon] = [
        part for part in shapely.get_parts(whole) if part.area >= _LEAST_ROOM_M2
    ]
    if not parts:
        return ()
    largest = max(parts, key=lambda part: part.area)
    ring = shapely.simplify(shapely.Polygon(largest.exterior), _SIMPLIFY_M).exterior
    outline = [(round(x, 4), round(y, 4)) for x, y in shapely.get_coordinates(ring)[:-1].tolist()]
    return tuple(outline if signed_area(outline) > 0 else outline[::-1])


def _corners_about(objects: Sequence[LayoutObject]) -> list[Point2]:
    if not objects:
        raise LayoutError("scene.room has neither floors nor furniture; valid: one or the other")
    # Boxes may be turned, so that half of the longest side counts to all sides.
    reach = max(max(obj.s) for obj in objects) / 2 + _MARGIN_M
    return [(obj.p[0] + d, obj.p[1] + d) for obj in objects for d in (-reach, reach)]


def _rectangle(half_x: float, half_y: float) -> tuple[Point2, ...]:
    return ((-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y))


def _moved(obj: LayoutObject, east: float, north: float) -> LayoutObject:
    x, y, z = obj.p
    return replace(obj, p=(round(x - east, 4), round(y - north, 4), round(z, 4)))
