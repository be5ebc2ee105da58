"""Hostile scenes in our own format: wrong, enormous or malicious."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from aeroscene.corpus.field import field_scene
from aeroscene.scene.io import scene_to_json
from fuzzing.files.case import HERE, Case, changed, packed


def _relief(heights: Any, spacing: Any = 200.0, origin: Any = (-100.0, -100.0)) -> dict[str, Any]:
    """A relief; by its defaults its grid of two nodes by two is one cell that covers the scene."""
    return {"origin": origin, "spacing": spacing, "heights": heights}


# Beyond 64 bits; Python reads it, and arrays cannot hold it.
_HUGE = 10**30
_IDS: tuple[tuple[str, str], ...] = (
    ("id-parent-folder", "../../x"),
    ("id-absolute", "/aeroscene-hostile-x"),
    ("id-option", "--help"),
    ("id-hidden", ".bashrc"),
    # Terminals obey these: the first sets the window's title, the second clears the screen.
    ("id-control", "\x1b]0;title\x07\x1b[2J"),
    # Right-to-left override: a file shows as if it ended otherwise.
    ("id-reversed", "gpj.\u202escene"),
    ("id-markup", "[/bold][red]x"),
    ("id-long", "x" * 200),
    ("id-endless", "x" * 1_000_000),
    ("id-empty", ""),
)
_VALUES: tuple[tuple[str, str, Any], ...] = (
    ("id-number", "scene_id", 7),
    # CSI as one character, without the escape that filters look for.
    ("theme-control", "theme", "\x9b31m"),
    ("domain-unknown", "domain", "\x1b[31msea"),
    ("seed-30-digits", "seed", _HUGE),
    ("seed-negative", "seed", -1),
    ("seed-text", "seed", "1"),
    ("version-huge", "version", _HUGE),
    ("format-other", "format", "x" * 100_000),
    ("altitude-1e300", "origin.altitude_m", 1e300),
    ("latitude-91", "origin.latitude_deg", 91),
    ("longitude-1e300", "origin.longitude_deg", -1e300),
    ("yaw-1e300", "start.yaw", 1e300),
    ("start-outside", "start.position", [1e6, 0, 0]),
    ("start-in-the-ground", "start.position", [10, 10, 0]),
    ("extent-inverted", "extent.min", [200, 0, 0]),
    ("extent-1e300", "extent.max", [1e300, 1e300, 1e300]),
    ("extent-far", "extent.min", [1e15, 1e15, 1e15]),
    ("object-id-huge", "objects.1.id", _HUGE),
    ("object-id-beyond-32-bits", "objects.1.id", 2**40),
    ("object-id-negative", "objects.1.id", -5),
    ("object-parent-self", "objects.1.parent_id", 1),
    ("object-parent-huge", "objects.1.parent_id", _HUGE),
    ("object-category-0", "objects.1.category_id", 0),
    ("object-scene-other", "objects.1.scene_id", "\x1bother"),
    ("box-p-huge", "objects.1.bbox.p", [1e300, 0, 0]),
    ("box-s-zero", "objects.1.bbox.s", [0, 1, 1]),
    ("box-s-huge", "objects.1.bbox.s", [1e300, 1, 1]),
    ("box-q-zero", "objects.1.bbox.q", [0, 0, 0, 0]),
    ("box-q-huge", "objects.1.bbox.q", [1e300, 0, 0, 0]),
    ("box-is-list", "objects.1.bbox", [[[[]]]]),
    ("attributes-nested", "objects.1.attributes", {"a": {"b": []}}),
    ("attributes-huge-integer", "objects.1.attributes", {"storeys": 10**400}),
    ("attributes-storeys", "objects.1.attributes", {"storeys": 10**9}),
    ("attributes-control", "objects.1.attributes", {"colour\x1b[2J": "\x1b[31m"}),
    ("attributes-many", "objects.1.attributes", {f"a{i}": i for i in range(200_000)}),
    ("area-polygon-empty", "interaction_areas.0.polygon", []),
    ("area-polygon-huge", "interaction_areas.0.polygon", [[1e300, 0, 0], [0, 1, 0], [0, 0, 0]]),
    ("area-polygon-many", "interaction_areas.0.polygon", [[i, i * i, 0] for i in range(50_000)]),
    ("area-polygon-crossing", "interaction_areas.0.polygon", [[0, 0, 0], [1, 1, 0], [1, 0, 0]]),
    ("area-id-negative", "interaction_areas.0.id", -1),
    ("area-object-missing", "interaction_areas.0.object_id", 99),
    ("area-radius-nan", "interaction_areas.0.radius", float("nan")),
    ("area-clearance-1e300", "interaction_areas.0.clearance_m", 1e300),
    ("area-slope-steep", "interaction_areas.0.slope_rad", 2),
    ("area-surface-control", "interaction_areas.0.surface", "\x1b[2J"),
    ("area-class-unknown", "interaction_areas.0.drone_class", "\x1bhuge"),
    ("wishes-nested", "wishes", {"a": [[]]}),
    ("wishes-huge", "wishes", {"objects": 1e308}),
    ("relief-empty", "relief", _relief([])),
    ("relief-of-one-node", "relief", _relief([[0.0]])),
    ("relief-of-many-rows", "relief", _relief([[0.0, 0.0]] * 100_000)),
    ("relief-of-a-long-row", "relief", _relief([[0.0] * 300_000] * 2)),
    ("relief-ragged", "relief", _relief([[0.0] * 3, [0.0] * 2])),
    ("relief-steep", "relief", _relief([[0.0, 150.0], [0.0, 0.0]], spacing=1.0)),
    ("relief-nan", "relief", _relief([[float("nan"), 0.0], [0.0, 0.0]])),
    ("relief-1e300", "relief", _relief([[1e300, 0.0], [0.0, 0.0]])),
    ("relief-spacing-0", "relief", _relief([[0.0, 0.0], [0.0, 0.0]], spacing=0.0)),
    ("relief-spacing-text", "relief", _relief([[0.0, 0.0], [0.0, 0.0]], spacing="\x1b[2J")),
    ("relief-elsewhere", "relief", _relief([[0.0, 0.0], [0.0, 0.0]], origin=(9e3, 9e3))),
    ("relief-beyond-the-volume", "relief", _relief([[0.0, 90.0], [0.0, 0.0]])),
    ("objects-null", "objects", None),
    ("objects-of-nothing", "objects", [None] * 500_000),
)


def scene_cases() -> Iterator[Case]:
    """Cases of scenes: one hostile value each, then files that are no document or far too large."""
    document = json.loads(scene_to_json(field_scene()))
    for name, scene_id in _IDS:
        yield _case(name, _renamed(document, scene_id))
    for name, way, value in _VALUES:
        yield _case(name, changed(document, way, value))
    for name, content in _raw(document):
        yield _case(name, content)
    large = _many_objects(document, 100_000)
    yield _case("100,000-objects", large)
    yield _case("100,000-objects-packed", packed(large, 1), "s.json.gz")
    yield _case("many-boxes-of-shelves", _shelves(document, 4_000))
    yield Case(
        kind="scene",
        name="sitl-of-a-bomb",
        files={"s.json": packed(b'{"a":[],' + b'"b":[]},' * 1000, 8_000)},
        command=("sitl", f"{HERE}/s.json", "--headless-seconds", "0.1"),
    )


def _case(name: str, content: bytes, file: str = "s.json") -> Case:
    return Case(
        kind="scene",
        name=name,
        files={file: content},
        command=("export", "--scene", f"{HERE}/{file}", "--to", "mjcf", "--out", f"{HERE}/out"),
    )


def _raw(document: Any) -> Iterator[tuple[str, bytes]]:
    text = json.dumps(document).encode()
    yield "empty", b""
    yield "cut-short", text[:700]
    yield "not-utf-8", text.replace(b'"field"', b'"fi\xff\xfeld"')
    yield "binary", bytes(range(256)) * 4_000
    yield "null", b"null"
    yield "nested-lists", b"[" * 1_000_000
    yield (
        "nested-in-an-attribute",
        text.replace(b'"attributes": {}', b'"attributes":' + b"[" * 99_999),
    )
    yield "integer-of-a-million-digits", text.replace(b'"seed": 0', b'"seed": ' + b"9" * 1_000_000)
    yield "float-of-a-million-digits", text.replace(b'"yaw": 0.0', b'"yaw": 0.' + b"1" * 1_000_000)
    yield "bomb-of-zeros", packed(bytes(1 << 20), 600)
    # 60 MiB of open brackets, past any parser that recurses.
    yield "bomb-of-brackets", packed(b"[" * (1 << 20), 60)
    yield "bomb-of-objects", packed(b'{"format":"aeroscene-scene"},' * 1000, 3_000)
    yield "bomb-of-text", b'{"format":"' + b"\xf0\x9f\x98\x80" * 7_000_000 + b'"}'
    yield "gzip-cut-short", packed(text, 1)[:-200]
    yield "gzip-in-gzip", packed(packed(text, 1), 1)


def _renamed(document: Any, scene_id: str) -> bytes:
    # Objects name their scene, and a scene with another name would be refused for that alone.
    objects = [{**each, "scene_id": scene_id} for each in document["objects"]]
    return json.dumps(document | {"scene_id": scene_id, "objects": objects}).encode()


def _many_objects(document: Any, count: int) -> bytes:
    first = document["objects"][0]
    objects = [{**first, "id": i, "parent_id": None} for i in range(count)]
    return json.dumps(document | {"objects": objects}).encode()


def _shelves(document: Any, count: int) -> bytes:
    """A scene of boxes, each of which our shapes fill with a thousand boards."""
    s = (900.0, 900.0, 900.0)
    # One bit of the index for each axis.
    corners = [[(i >> k & 1) * 900.0 - 450.0 for k in range(3)] for i in range(8)]
    shelf = {
        "scene_id": "field",
        "parent_id": None,
        "category_id": 54,
        "bbox": {"p": (0.0, 0.0, 0.0), "q": (1.0, 0.0, 0.0, 0.0), "s": s},
        "bbox_corners": corners,
        "domain": "outdoor",
        "attributes": {},
    }
    objects = [{"id": i, **shelf} for i in range(count)]
    areas: list[Any] = []
    return json.dumps(document | {"objects": objects, "interaction_areas": areas}).encode()
