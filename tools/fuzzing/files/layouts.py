"""Hostile layouts, in the forms of other projects, with values that no project would write."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
from typing import Any

from fuzzing.files.case import HERE, Case, changed, packed

_BOX = {"category": "Bed", "p": [0, 0, 0.4], "q": [1, 0, 0, 0], "s": [1.5, 2.0, 0.8]}
_ROOM: dict[str, Any] = {
    "scene_id": "a/room",
    "domain": "indoor",
    "floor": [[-5, -4], [5, -4], [5, 4], [-5, 4]],
    "objects": [_BOX],
    "attributes": {"rooms": [{"room_type": "Kitchen", "polygon": [[0, 0], [4, 0], [4, 3]]}]},
}
_POSE = {"rot": [0, 0, 0, 1], "scale": [1, 1, 1]}
_HOUSE: dict[str, Any] = {
    "uid": "house",
    "furniture": [{"uid": "1", "jid": "j", "size": [1, 1, 2], "category": "Bed", "valid": True}],
    "mesh": [
        {
            "uid": "m",
            "type": "Floor",
            "xyz": [0, 0, 0, 4, 0, 0, 4, 0, 3, 0, 0, 3],
            "faces": [0, 1, 2, 0, 2, 3],
        }
    ],
    "scene": {
        "room": [
            {
                "type": "Bedroom",
                "instanceid": "B-1",
                "children": [
                    {"ref": "m", "pos": [0, 0, 0], **_POSE},
                    {"ref": "1", "pos": [2, 0, 1], **_POSE},
                ],
            }
        ]
    },
}
_AUTHORS: dict[str, Any] = {
    "id": "sample",
    "mesh_floor": "m",
    "outdoor_scene": [
        {"name": "shed", "translation": [9, 5, 0], "rotation": [0, 0, 9], "scale": [1, 1, 1]},
        {"name": "hut", "translation": [-9, 0, 0], "rotation": [0, 0, 3], "indoor": []},
    ],
}
_ROOM_VALUES: tuple[tuple[str, str, Any], ...] = (
    ("id-parent-folder", "scene_id", "../../../x"),
    ("id-control", "scene_id", "\x1b[2J\x1b]0;x\x07"),
    ("category-control", "objects.0.category", "Bed\x1b[31m"),
    ("category-markup", "objects.0.category", "[/bold][red]Bed"),
    ("category-long", "objects.0.category", "Bed" * 500_000),
    ("p-huge", "objects.0.p", [1e300, 0, 0]),
    ("p-integer", "objects.0.p", [10**400, 0, 0]),
    ("q-zero", "objects.0.q", [0, 0, 0, 0]),
    ("s-zero", "objects.0.s", [0, 1, 1]),
    ("parent-forward", "objects.0.parent", 7),
    ("floor-one-point", "floor", [[0, 0]]),
    ("floor-crossing", "floor", [[0, 0], [4, 4], [4, 0], [0, 4]]),
    ("floor-50,000-points", "floor", [[i, (i * 7) % 11] for i in range(50_000)]),
    ("floor-of-10-km", "floor", [[-9e3, -9e3], [9e3, -9e3], [9e3, 9e3], [-9e3, 9e3]]),
    ("100,000-objects", "objects", [_BOX] * 100_000),
    ("5,001-objects", "objects", [_BOX] * 5_001),
    ("10,000-rooms", "attributes.rooms", _ROOM["attributes"]["rooms"] * 10_000),
    ("rooms-nested", "attributes.rooms", [[[[]]]]),
)
_HOUSE_VALUES: tuple[tuple[str, str, Any], ...] = (
    ("uid-control", "uid", "\x1b[2J/../x"),
    ("size-huge", "furniture.0.size", [1e300, 1, 1]),
    ("xyz-text", "mesh.0.xyz", "text"),
    ("xyz-huge", "mesh.0.xyz", [1e300] * 12),
    ("faces-beyond", "mesh.0.faces", [0, 1, 10**12]),
    ("faces-million", "mesh.0.faces", [0, 1, 2] * 700_000),
    ("mesh-of-nothing", "mesh", [None] * 900_000),
    (
        "children-of-the-floor",
        "scene.room.0.children",
        [_HOUSE["scene"]["room"][0]["children"][0]] * 60_000,
    ),
    ("room-is-text", "scene.room", "rooms"),
)
_AUTHORS_VALUES: tuple[tuple[str, str, Any], ...] = (
    ("name-control", "outdoor_scene.0.name", "shed\x1b[2J"),
    ("scale-zero", "outdoor_scene.0.scale", [0, 1, 1]),
    ("rotation-huge", "outdoor_scene.0.rotation", [1e300, 0, 0]),
    ("translation-huge", "outdoor_scene.0.translation", [1e300, 0, 0]),
    ("indoor-is-text", "outdoor_scene.0.indoor", "x"),
)


def layout_cases() -> Iterator[Case]:
    """Cases of layouts: each form with one hostile value, then files of lines."""
    for name, way, value in _ROOM_VALUES:
        yield _case(name, "l.jsonl", changed(_ROOM, way, value))
    for name, way, value in _HOUSE_VALUES:
        yield _case(f"house-{name}", "l.json", changed(_HOUSE, way, value))
    for name, way, value in _AUTHORS_VALUES:
        yield _case(f"authors-{name}", "l.json", changed(_AUTHORS, way, value))
    # Four hundred rooms within rooms, each of which a reader has to enter.
    indoor: list[Any] = []
    for _ in range(400):
        indoor = [{"name": "box", "translation": [0, 0, 0], "indoor": indoor}]
    yield _case(
        "authors-indoor-nested", "l.json", changed(_AUTHORS, "outdoor_scene.1.indoor", indoor)
    )
    for name, file, content in _lines():
        yield _case(name, file, content)
    yield Case(
        kind="layout",
        name="model-info-nested",
        files={"l.json": json.dumps(_HOUSE).encode(), "model_info.json": b"[" * 100_000},
        command=("layouts", f"{HERE}/l.json"),
    )


def _lines() -> Iterator[tuple[str, str, bytes]]:
    line = json.dumps(_ROOM).encode() + b"\n"
    small = b'{"scene_id":"%d","domain":"outdoor","floor":[[0,0],[1,0],[0,1]],"objects":[]}\n'
    # Blank lines are cheap to pack: 300 MiB of them make a small file.
    yield "lines-blank", "l.jsonl.gz", packed(b"\n", 300 << 20)
    yield "lines-blank-too-many", "l.jsonl.gz", packed(b"\n", 100 << 20)
    yield "lines-not-utf-8", "l.jsonl", b"\xff\xfe" + line
    yield "lines-nan", "l.jsonl", line.replace(b"0.4]", b"NaN]")
    yield "lines-cut-short", "l.jsonl", line[:90]
    yield "lines-the-same-id", "l.jsonl", line * 2
    yield "lines-of-nested-lists", "l.jsonl", (b"[" * 90_000 + b"\n") * 20
    yield "lines-of-values", "l.jsonl.gz", packed(b"[" + b"[]," * 900_000 + b"0]\n", 20)
    yield "line-of-60-MB", "l.jsonl.gz", packed(b"a" * (1 << 20), 60)
    # The fault stands at the end, where everything before it has been taken in.
    many = b"".join(small % i for i in range(20_000))
    yield "many-small-then-a-fault", "l.jsonl.gz", gzip.compress(many + b"{}\n", 1)
    yield "gzip-cut-short", "l.jsonl.gz", packed(line, 1)[:-9]


def _case(name: str, file: str, content: bytes) -> Case:
    return Case(
        kind="layout",
        name=name,
        files={file: content},
        command=("layouts", f"{HERE}/{file}", "--out", f"{HERE}/out"),
    )
