"""Scenes as versioned JSON: the paper's schema, checked on reading, one object a line.

`bbox_corners` is written beside each box, so that a reader of the file needs no rotations, and
checked against the box when read. A file that breaks a rule gives one `SceneError` line. A name
that ends with `.gz` compresses the file, again to equal bytes for equal scenes.
"""

from __future__ import annotations

import gzip
import re
from pathlib import Path
from typing import NoReturn

import msgspec
import numpy as np
from msgspec.structs import asdict

from aeroscene.bounds import MOST_JSON_BYTES, excess
from aeroscene.files import UnpackError, read_bounded, replacing
from aeroscene.scene import (
    AttributeValue,
    InteractionArea,
    OrientedBox,
    Quaternion,
    Scene,
    SceneError,
    SceneObject,
    Vector3,
)
from aeroscene.scene.box import box_corners
from aeroscene.scene.errors import shown

FORMAT = "aeroscene-scene"
VERSION = 1
CORNER_TOLERANCE_M = 1e-3
"""Allowed distance between a written corner and the box's own; written with 4 decimals."""

Corners = tuple[Vector3, Vector3, Vector3, Vector3, Vector3, Vector3, Vector3, Vector3]


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


class _Object(_Record):
    id: int
    scene_id: str
    parent_id: int | None
    category_id: int
    bbox: _Box
    bbox_corners: Corners
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


class _Document(_Record):
    format: str
    version: int
    scene_id: str
    domain: str
    seed: int
    extent: _Extent
    start: _Start
    origin: _Origin
    objects: tuple[_Object, ...]
    interaction_areas: tuple[_Area, ...]
    theme: str = ""
    wishes: dict[str, AttributeValue] = {}
    measured: dict[str, AttributeValue] = {}


def scene_to_json(scene: Scene) -> bytes:
    """The scene as JSON text in UTF-8; equal scenes give equal bytes."""
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
    head |= {name: dict(note) for name in notes if (note := getattr(scene, name))}
    return b"".join(
        (
            msgspec.json.encode(head)[:-1],
            b',\n"objects":[',
            _lines([_object_record(obj) for obj in scene.objects]),
            b'],\n"interaction_areas":[',
            _lines([_area_record(area) for area in scene.interaction_areas]),
            b"]}\n",
        )
    )


def _lines(records: list[_Object] | list[_Area]) -> bytes:
    encoder = msgspec.json.Encoder()
    return b"\n" * bool(records) + b",\n".join(encoder.encode(record) for record in records)


def _object_record(obj: SceneObject) -> _Object:
    corners = np.round(obj.bbox.corners(), 4) + 0.0
    return _Object(
        id=obj.id,
        scene_id=obj.scene_id,
        parent_id=obj.parent_id,
        category_id=obj.category_id,
        bbox=_Box(obj.bbox.p, obj.bbox.q, obj.bbox.s),
        bbox_corners=tuple(map(tuple, corners.tolist())),  # pyright: ignore[reportArgumentType]
        domain=obj.domain,
        attributes=dict(obj.attributes),
    )


def _area_record(area: InteractionArea) -> _Area:
    return _Area(**{name: getattr(area, name) for name in _Area.__struct_fields__})


def scene_from_json(data: bytes | str, source: str = "scene JSON") -> Scene:
    """The scene in a JSON text.

    Args:
        data: Text as `scene_to_json` writes it.
        source: What to call the text in an error.

    Raises:
        SceneError: One line that names scene, object and field, and says what is valid.
    """
    try:
        data = data.encode() if isinstance(data, str) else data
        if (fault := excess(data)) is not None:
            raise SceneFileError(fault)
        return _build(_decode(data))
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
        _require_ours(msgspec.json.decode(data, type=_Head))
        raise
    _require_ours(document)
    return document


def _require_ours(head: _Head | _Document) -> None:
    if (head.format, head.version) != (FORMAT, VERSION):
        raise SceneFileError(
            f"format is {shown(head.format)} version {shown(head.version)}, "
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


def _build(document: _Document) -> Scene:
    scene_id = document.scene_id
    try:
        objects = tuple(_build_object(record) for record in document.objects)
        areas = tuple(InteractionArea(**asdict(record)) for record in document.interaction_areas)
        _check_corners(document.objects)
    except SceneError as error:
        raise error.within(f"scene {scene_id!r}") from None
    return Scene(
        scene_id=scene_id,
        domain=document.domain,  # pyright: ignore[reportArgumentType] - Scene validates it
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
    )


def _build_object(record: _Object) -> SceneObject:
    try:
        box = OrientedBox(record.bbox.p, record.bbox.q, record.bbox.s)
    except SceneError as error:
        raise error.within(f"object {record.id}") from None
    return SceneObject(
        id=record.id,
        scene_id=record.scene_id,
        parent_id=record.parent_id,
        category_id=record.category_id,
        bbox=box,
        domain=record.domain,  # pyright: ignore[reportArgumentType] - SceneObject validates it
        attributes=record.attributes,
    )


def _check_corners(records: tuple[_Object, ...]) -> None:
    if not records:
        return
    written = np.array([record.bbox_corners for record in records])
    p, q, s = (np.array([getattr(record.bbox, name) for record in records]) for name in "pqs")
    deviation_m = np.abs(written - box_corners(p, q, s)).max(axis=(1, 2))
    worst = int(np.argmax(~(deviation_m <= CORNER_TOLERANCE_M)))
    if not deviation_m[worst] <= CORNER_TOLERANCE_M:
        raise SceneError(
            f"object {records[worst].id}: bbox_corners lie {deviation_m[worst]:.4g} m away from "
            f"the corners of bbox, valid: at most {CORNER_TOLERANCE_M:g} m"
        )


def read_scene(path: str | Path) -> Scene:
    """Read and validate a scene file, compressed with gzip or not.

    Raises:
        SceneError: If the file is missing or breaks a rule; one line that says which.
    """
    path = Path(path)
    source = f"scene file {str(path)!r}"
    try:
        data = read_bounded(path, MOST_JSON_BYTES)
    except UnpackError as error:
        raise SceneFileError(f"{source}: {error}") from None
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
        message = f"{source} cannot be read ({reason}), valid: a scene in JSON"
        raise SceneFileError(message) from None
    return scene_from_json(data, source=source)


def write_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene whole or not at all to `FILE.json`, or compressed to `FILE.json.gz`."""
    path, data = Path(path), scene_to_json(scene)
    with replacing(path) as file:
        if path.suffix == ".gz":
            # Without a name and a time, so that equal scenes give equal files on every system.
            with gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=0) as packed:
                packed.write(data)
        else:
            file.write(data)
