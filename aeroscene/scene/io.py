"""Scenes as versioned JSON: the paper's schema, checked on reading, one object a line.

One object a line keeps files readable in an editor and in `git diff`, at the size of compact JSON.
`bbox_corners` is written beside each box, so that a reader of the file needs no rotations. Reading
uses the box alone: corners that are missing or disagree, as after an edit by hand, are computed
again.

A file that breaks a rule gives one `SceneError` line. A name that ends with `.gz` compresses the
file; equal scenes still give equal bytes.
"""

from __future__ import annotations

import gzip
import logging
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NoReturn

import msgspec
import numpy as np
from msgspec.structs import asdict

from aeroscene.files import UnpackError, read_bounded, replacing
from aeroscene.files.bounds import MOST_JSON_BYTES, excess
from aeroscene.files.visible import shown
from aeroscene.scene import (
    AttributeValue,
    InteractionArea,
    OrientedBox,
    Quaternion,
    Relief,
    Scene,
    SceneError,
    SceneObject,
    Vector3,
)
from aeroscene.scene.box import box_corners
from aeroscene.scene.relief import MOST_NODES

FORMAT = "aeroscene-scene"
VERSION = 1
CORNER_TOLERANCE_M = 1e-3
"""Distance up to which a written corner agrees with the box's own; files have 4 decimals."""
DeriveAreas = Callable[[Scene], tuple[InteractionArea, ...]]
"""Function that finds the areas of a scene by its geometry."""

_log = logging.getLogger(__name__)
_MOST_NAMED = 5
"""Objects that a note names one by one."""

Corners = tuple[Vector3, Vector3, Vector3, Vector3, Vector3, Vector3, Vector3, Vector3]
Comment = str | tuple[str, ...] | msgspec.UnsetType
"""A line or several for people who edit the file by hand; a `Scene` does not keep them."""


class SceneFileError(SceneError):
    """A scene file that cannot be read: missing, cut short, another format or version."""


class _Record(msgspec.Struct, forbid_unknown_fields=True): ...


class _Head(msgspec.Struct, frozen=True):
    format: str
    version: int


class _Box(_Record):
    p: Vector3
    q: Quaternion
    s: Vector3


class _Object(_Record, kw_only=True):
    id: int
    comment: Comment = msgspec.UNSET
    scene_id: str = ""  # empty: that of the document
    parent_id: int | None
    category_id: int
    bbox: _Box
    bbox_corners: Corners | msgspec.UnsetType = msgspec.UNSET
    domain: str
    attributes: dict[str, AttributeValue] = {}


class _Area(_Record):
    id: int
    kind: str
    object_id: int | None
    polygon: tuple[Vector3, ...]
    centroid: Vector3
    radius: float
    drone_class: str
    slope_rad: float
    clearance_m: float
    surface: str


class _Extent(_Record):
    min: Vector3
    max: Vector3


class _Start(_Record):
    position: Vector3
    yaw: float


class _Origin(_Record):
    latitude_deg: float
    longitude_deg: float
    altitude_m: float


_Row = Annotated[tuple[float, ...], msgspec.Meta(max_length=MOST_NODES)]


class _Relief(_Record):
    origin: tuple[float, float]
    spacing: float
    heights: Annotated[tuple[_Row, ...], msgspec.Meta(max_length=MOST_NODES)]


class _Document(_Record, kw_only=True):
    format: str
    version: int
    comment: Comment = msgspec.UNSET
    scene_id: str
    domain: str
    seed: int
    extent: _Extent
    start: _Start
    origin: _Origin
    objects: tuple[_Object, ...]
    interaction_areas: tuple[_Area, ...] | msgspec.UnsetType = msgspec.UNSET
    theme: str = ""
    wishes: dict[str, AttributeValue] = {}
    measured: dict[str, AttributeValue] = {}
    relief: _Relief | None = None


def scene_to_json(scene: Scene, *, with_corners: bool = True) -> bytes:
    """Write a scene as JSON text in UTF-8; equal scenes give equal bytes.

    Args:
        scene: The scene.
        with_corners: Write `bbox_corners`, which readers compute themselves if it is missing.
    """
    head = {
        "format": FORMAT,
        "version": VERSION,
        "scene_id": scene.scene_id,
        "domain": scene.domain,
        **({"theme": scene.theme} if scene.theme else {}),
        "seed": scene.seed,
        "extent": _Extent(scene.extent_min_enu_m, scene.extent_max_enu_m),
        "start": _Start(scene.start_position_enu_m, scene.start_yaw_rad),
        "origin": _Origin(scene.latitude_deg, scene.longitude_deg, scene.altitude_m),
    }
    notes = ("wishes", "measured")
    # Like an empty theme, empty notes are left out of the file.
    head |= {name: dict(note) for name in notes if (note := getattr(scene, name))}
    return b"".join(
        (
            msgspec.json.encode(head)[:-1],
            _relief_text(scene.relief),
            b',\n"objects":[',
            _lines([_object_record(obj, with_corners) for obj in scene.objects]),
            b'],\n"interaction_areas":[',
            _lines([_area_record(area) for area in scene.interaction_areas]),
            b"]}\n",
        )
    )


def _relief_text(relief: Relief | None) -> bytes:
    """The relief as a member of the document, a row of heights a line; nothing without one."""
    if relief is None:
        return b""
    head = {"origin": relief.origin_enu_m, "spacing": relief.spacing_m}
    rows = _lines(relief.heights_m.tolist())
    return b',\n"relief":' + msgspec.json.encode(head)[:-1] + b',"heights":[' + rows + b"]}"


def _lines(records: list[_Object] | list[_Area] | list[list[float]]) -> bytes:
    encoder = msgspec.json.Encoder()
    return b"\n" * bool(records) + b",\n".join(encoder.encode(record) for record in records)


def _object_record(obj: SceneObject, with_corners: bool) -> _Object:
    corners: Corners | msgspec.UnsetType = msgspec.UNSET
    if with_corners:
        # Adding 0.0 turns -0.0 into 0.0, which keeps the bytes equal on all systems.
        rounded = np.round(obj.bbox.corners(), 4) + 0.0
        corners = tuple(map(tuple, rounded.tolist()))  # pyrefly: ignore[bad-assignment]
    return _Object(
        id=obj.id,
        scene_id=obj.scene_id,
        parent_id=obj.parent_id,
        category_id=obj.category_id,
        bbox=_Box(obj.bbox.p, obj.bbox.q, obj.bbox.s),
        bbox_corners=corners,
        domain=obj.domain,
        attributes=dict(obj.attributes),
    )


def _area_record(area: InteractionArea) -> _Area:
    return _Area(**{name: getattr(area, name) for name in _Area.__struct_fields__})


def scene_from_json(
    data: bytes | str, source: str = "scene JSON", derive: DeriveAreas | None = None
) -> Scene:
    """Read the scene in a JSON text.

    Args:
        data: Text from `scene_to_json` or written by a person: it may contain comments, and may
            leave out whatever follows from the rest.
        source: Name of the text in an error.
        derive: Function that finds the areas if the text does not list any; without it a missing
            list is an error.

    Raises:
        SceneError: One line that names scene, object and field, and says what is valid.
    """
    try:
        data = data.encode() if isinstance(data, str) else data
        # Size and count of values are bounded first: a small packed file cannot fill the memory.
        if (fault := excess(data)) is not None:
            raise SceneFileError(fault)
        return _build(_decode(data), source, derive)
    except msgspec.ValidationError as error:
        assert isinstance(data, bytes)
        _raise_located(data, source, str(error))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        reason = str(error).removeprefix("JSON is malformed: ")
        raise SceneFileError(f"{source}: not JSON or not all of it ({reason})") from None
    except SceneError as error:
        raise error.within(source) from None


def _decode(data: bytes) -> _Document:
    """The document in one pass; another format or version says so before any field that differs."""
    try:
        document = msgspec.json.decode(data, type=_Document)
    except msgspec.ValidationError:
        # A file of another format has other fields too: naming the format helps its owner, naming a
        # field would not.
        _require_ours(msgspec.json.decode(data, type=_Head))
        raise
    _require_ours(document)
    return document


def _require_ours(head: _Head | _Document) -> None:
    if (head.format, head.version) != (FORMAT, VERSION):
        raise SceneFileError(
            f"format is {shown(head.format)} version {shown(head.version)}; "
            f"valid: {FORMAT!r} version {VERSION}"
        )


def _raise_located(data: bytes, source: str, text: str) -> NoReturn:
    """Turn msgspec's path into scene, object and field."""
    message, _, path = text.partition(" - at `")
    path = path.removesuffix("`").removeprefix("$").removeprefix(".")
    place = re.match(r"(objects|interaction_areas)\[(\d+)\]\.?(.*)", path)
    where = source
    if place:
        parts = msgspec.json.decode(data, type=dict[str, msgspec.Raw])
        # Only the record at fault is decoded again, for its id: people search a file for `"id":
        # 12`.
        record = msgspec.json.decode(
            msgspec.json.decode(parts[place[1]], type=list[msgspec.Raw])[int(place[2])]
        )
        noun = "object" if place[1] == "objects" else "interaction area"
        name = record.get("id") if isinstance(record, dict) else None
        where += f": {noun} {_bare(name)}" if name is not None else f": {place[1]}[{place[2]}]"
        path = place[3]
    raise SceneFileError(f"{where}: {path}: {message}" if path else f"{where}: {message}") from None


def _bare(name: object) -> str:
    return shown(name, 60).strip("'")


def _build(document: _Document, source: str, derive: DeriveAreas | None) -> Scene:
    scene_id, listed = document.scene_id, document.interaction_areas
    if listed is msgspec.UNSET and derive is None:
        raise SceneFileError(
            "interaction_areas is missing; valid: a list, also empty; load_scene() derives it"
        )
    records = () if listed is msgspec.UNSET else listed
    try:
        objects = tuple(_build_object(record, scene_id) for record in document.objects)
        areas = tuple(InteractionArea(**asdict(record)) for record in records)
    except SceneError as error:
        raise error.within(f"scene {scene_id!r}") from None
    _note_wrong_corners(document.objects, source)
    scene = Scene(
        scene_id=scene_id,
        domain=document.domain,  # pyrefly: ignore[bad-argument-type] - Scene validates it
        seed=document.seed,
        extent_min_enu_m=document.extent.min,
        extent_max_enu_m=document.extent.max,
        start_position_enu_m=document.start.position,
        start_yaw_rad=document.start.yaw,
        latitude_deg=document.origin.latitude_deg,
        longitude_deg=document.origin.longitude_deg,
        altitude_m=document.origin.altitude_m,
        objects=objects,
        interaction_areas=areas,
        theme=document.theme,
        wishes=document.wishes,
        measured=document.measured,
        relief=_build_relief(document.relief, scene_id),
    )
    if listed is not msgspec.UNSET or derive is None:
        return scene
    return replace(scene, interaction_areas=derive(scene))


def _build_relief(record: _Relief | None, scene_id: str) -> Relief | None:
    if record is None:
        return None
    try:
        return Relief.from_rows(record.origin, record.spacing, record.heights)
    except SceneError as error:
        raise error.within(f"scene {scene_id!r}: relief") from None


def _build_object(record: _Object, scene_id: str) -> SceneObject:
    try:
        box = OrientedBox(record.bbox.p, record.bbox.q, record.bbox.s)
    except SceneError as error:
        raise error.within(f"object {record.id}") from None
    return SceneObject(
        id=record.id,
        scene_id=record.scene_id or scene_id,
        parent_id=record.parent_id,
        category_id=record.category_id,
        bbox=box,
        domain=record.domain,  # pyrefly: ignore[bad-argument-type] - SceneObject validates it
        attributes=record.attributes,
    )


def _note_wrong_corners(records: tuple[_Object, ...], source: str) -> None:
    """Say which objects have corners that disagree with their boxes, as after an edit by hand."""
    written = [record for record in records if record.bbox_corners is not msgspec.UNSET]
    if not written:
        return
    corners = np.array([record.bbox_corners for record in written])
    p, q, s = (np.array([getattr(record.bbox, name) for record in written]) for name in "pqs")
    with np.errstate(over="ignore"):
        deviation_m = np.abs(corners - box_corners(p, q, s)).max(axis=(1, 2))
    # "Not within" also catches NaN, the difference of coordinates that overflowed.
    ids = [written[i].id for i in np.flatnonzero(~(deviation_m <= CORNER_TOLERANCE_M))]
    if ids:
        more = f" and {len(ids) - _MOST_NAMED} others" if len(ids) > _MOST_NAMED else ""
        _log.warning(
            "%s: bbox_corners of object %s%s lie up to %.4g m away from the corners of bbox, which "
            "counts; they are computed again",
            source,
            ", ".join(map(str, ids[:_MOST_NAMED])),
            more,
            deviation_m.max(),
        )


def read_scene(path: str | Path, derive: DeriveAreas | None = None) -> Scene:
    """Read and validate a scene file, compressed with gzip or not.

    Args:
        path: File; it is recognised as compressed by its content.
        derive: Function that finds the areas if the file does not list any; without it a missing
            list is an error.

    Raises:
        SceneError: If the file is missing or breaks a rule; one line says which.
    """
    path = Path(path)
    source = f"scene file {str(path)!r}"
    try:
        data = read_bounded(path, MOST_JSON_BYTES)
    except UnpackError as error:
        raise SceneFileError(f"{source}: {error}") from None
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
        message = f"{source} cannot be read ({reason}); valid: a scene in JSON"
        raise SceneFileError(message) from None
    return scene_from_json(data, source, derive)


def write_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene to `FILE.json`, or compressed to `FILE.json.gz`.

    The file is replaced whole or not at all, so an interrupted write never leaves half a scene.

    Raises:
        OSError: If the file cannot be written.
    """
    path, data = Path(path), scene_to_json(scene)
    with replacing(path) as file:
        if path.suffix == ".gz":
            # Without a name and a time, so that equal scenes give equal files on every system.
            with gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=0) as packed:
                packed.write(data)
        else:
            file.write(data)
