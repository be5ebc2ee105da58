"""Small layouts of our own making, in the forms of other people."""

from __future__ import annotations

import gzip
import json
import math
from pathlib import Path
from typing import Any


def box(
    category: str,
    p: tuple[float, float, float],
    s: tuple[float, float, float],
    yaw_deg: float = 0.0,
    parent: int | None = None,
) -> dict[str, Any]:
    """An object of a neutral layout that stands upright."""
    half = math.radians(yaw_deg) / 2
    q = [math.cos(half), 0.0, 0.0, math.sin(half)]
    return {"category": category, "p": list(p), "q": q, "s": list(s), "parent": parent}


def house() -> dict[str, Any]:
    """Two rooms of 5 m by 6 m and a little furniture."""
    return {
        "scene_id": "made-up/house-1",
        "source": "made up for tests",
        "domain": "indoor",
        "floor": [[-5, -3], [5, -3], [5, 3], [-5, 3]],
        "objects": [
            box("DiningTable", (-3.5, 2.0, 0.375), (1.6, 0.9, 0.75)),
            box("Mug", (-3.5, 2.0, 0.8), (0.12, 0.1, 0.1), parent=0),
            box("Bed", (4.0, 1.8, 0.4), (1.5, 2.1, 0.8), 180),
            box("Painting", (-2.0, -2.98, 1.6), (0.8, 0.03, 0.6)),
            box("FloorLamp", (-4.6, -2.6, 0.9), (0.4, 0.4, 1.8)),
        ],
        "attributes": {
            "rooms": [
                {"room_type": "Kitchen", "polygon": [[-5, -3], [0, -3], [0, 3], [-5, 3]]},
                {"room_type": "Bedroom", "polygon": [[0, -3], [5, -3], [5, 3], [0, 3]]},
            ]
        },
    }


def block() -> dict[str, Any]:
    """Four buildings on a field of 60 m."""
    return {
        "scene_id": "made-up/block-1",
        "source": "made up for tests",
        "domain": "outdoor",
        "floor": [[-30, -30], [30, -30], [30, 30], [-30, 30]],
        "objects": [
            box("building", (-18, 15, 2.5), (12, 10, 5), 20),
            box("building", (18, 16, 6), (20, 12, 12)),
            box("building", (-18, -14, 1.4), (5, 4, 2.8), -35),
            box("building", (16, -16, 3), (14, 9, 6), 70),
        ],
    }


def front3d_house() -> dict[str, Any]:
    """A house of one room of 4 m by 3 m in 3D-FRONT's form: y up."""
    floor = [0, 0, 0, 4, 0, 0, 4, 0, 3, 0, 0, 3]
    bed = {"uid": "1/model", "jid": "j1", "size": [1.6, 1.0, 2.0], "category": "Single bed"}
    shelf = {"uid": "2/model", "jid": "j2", "size": [0.8, 1.9, 0.3], "title": "shelf/book shelf"}
    gone = {"uid": "3/model", "jid": "j3", "size": [1, 1, 1], "category": "Desk", "valid": False}
    pose = {"rot": [0, 0, 0, 1], "scale": [1, 1, 1]}
    return {
        "uid": "made-up-house",
        "furniture": [bed | {"valid": True}, shelf | {"valid": True}, gone],
        "mesh": [
            {"uid": "m1", "type": "Floor", "xyz": floor, "faces": [0, 1, 2, 0, 2, 3]},
            {
                "uid": "m2",
                "type": "WallInner",
                "xyz": [0, 0, 0, 4, 0, 0, 4, 3, 0],
                "faces": [0, 1, 2],
            },
        ],
        "scene": {
            "ref": "made-up-house",
            "room": [
                {
                    "type": "Bedroom",
                    "instanceid": "Bedroom-1",
                    "children": [
                        {"ref": "m1", "pos": [0, 0, 0], **pose},
                        {"ref": "m2", "pos": [0, 0, 0], **pose},
                        {"ref": "1/model", "pos": [1, 0, 1.2], **pose},
                        {"ref": "2/model", "pos": [3.5, 0, 2.8], **pose},
                        {"ref": "3/model", "pos": [2, 0, 2], **pose},
                        {"ref": "light-7", "pos": [2, 2.5, 2], **pose},
                    ],
                }
            ],
        },
    }


def _xyz(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


def _thor_room(room_id: str, kind: str, x0: float, x1: float) -> dict[str, Any]:
    corners = [(x0, 0.0), (x0, 5.0), (x1, 5.0), (x1, 0.0)]
    return {"id": room_id, "roomType": kind, "floorPolygon": [_xyz(x, 0, z) for x, z in corners]}


def procthor_house() -> dict[str, Any]:
    """Two rooms of 5 m by 5 m in ProcTHOR's form: y up, Unity's left-handed frame."""
    desk = {
        "id": "2|0",
        "assetId": "Desk_307_1_1",
        "position": _xyz(1.0, 0.4, 2.5),
        "rotation": _xyz(0, 90, 0),
        "children": [
            {
                "id": "small|2|7",
                "assetId": "RoboTHOR_laptop_alienware_v",
                "position": _xyz(1.0, 0.9, 2.5),
                "rotation": _xyz(0, 90, 0),
            }
        ],
    }
    painting = {
        "id": "window|2|3",
        "assetId": "Wall_Decor_Painting_4",
        "position": _xyz(8.0, 1.6, 4.98),
        "rotation": _xyz(0, 180, 0),
    }
    sofa = {
        "id": "3|0",
        "assetId": "Sofa_203_2",
        "position": _xyz(7.5, 0.45, 4.0),
        "rotation": _xyz(0, 180, 0),
    }
    return {
        "metadata": {"schema": "1.0.0"},
        "rooms": [
            _thor_room("room|2", "Bedroom", 0.0, 5.0),
            _thor_room("room|3", "LivingRoom", 5.0, 10.0),
        ],
        "walls": [],
        "doors": [],
        "windows": [],
        "proceduralParameters": {},
        "objects": [desk, sofa, painting],
    }


def holodeck_house() -> dict[str, Any]:
    """A room of 6 m by 5 m in Holodeck's form: outlines in cm, children by their ids."""
    outline = [(95, 170), (95, 330), (205, 330), (205, 170)]
    return {
        "rooms": [_thor_room("office", "office", 0.0, 6.0)],
        "walls": [],
        "objects": [
            {
                "id": "standing_desk-0 (office)",
                "object_name": "standing_desk-0",
                "assetId": "0a1b2c3d4e5f",
                "position": _xyz(1.5, 0.375, 2.5),
                "rotation": _xyz(0, 90, 0),
                "vertices": [list(corner) for corner in outline],
            },
            {
                "id": "coffee_mug-0|standing_desk-0 (office)",
                "assetId": "5f4e3d2c1b0a",
                "position": _xyz(1.5, 0.8, 2.5),
                "rotation": _xyz(0, 0, 0),
                "roomId": "office",
            },
        ],
    }


def authors_scene() -> dict[str, Any]:
    """Two buildings, one of them furnished, in the form of the AeroScene authors."""
    return {
        "id": "gen_sample_0",
        "mesh_floor": "island_2",
        "outdoor_scene": [
            {
                "name": "warehouse_02",
                "translation": [20, 5, 0],
                "rotation": [0, 0, 90],
                "scale": [1, 1, 1],
                "indoor": None,
            },
            {
                "name": "Weefit",
                "translation": [-15, 0, 0],
                "rotation": [0, 0, 30],
                "scale": [1, 1, 0.8],
                "indoor": [
                    {
                        "name": "table_3",
                        "translation": [2, 1, 0.3],
                        "rotation": [0, 0, 0],
                        "scale": [1, 1, 1],
                    },
                    {"translation": [-2, 1, 0.3], "rotation": [0, 0, 0], "scale": [1, 1, 1]},
                ],
            },
        ],
    }


def write_lines(path: Path, *records: Any) -> Path:
    """JSON lines, gzip where the name says so."""
    text = "".join(json.dumps(record) + "\n" for record in records).encode()
    path.write_bytes(gzip.compress(text) if path.suffix == ".gz" else text)
    return path


def write_json(path: Path, record: Any) -> Path:
    """One JSON value, gzip where the name says so."""
    text = json.dumps(record).encode()
    path.write_bytes(gzip.compress(text) if path.suffix == ".gz" else text)
    return path
