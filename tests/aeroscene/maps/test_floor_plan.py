from __future__ import annotations

import json
import math
import re

import pytest

from aeroscene.layouts import LayoutError
from aeroscene.maps import MapError
from aeroscene.maps.floor_plan import open_plan
from aeroscene.scene import SceneError
from aeroscene.validation import validate
from tests.aeroscene.maps.samples import degrees

TURN_RAD = 0.4
ROOMS = {
    "bedroom": (0, 0, 4, 4.5),
    "kitchen": (4.2, 0, 8, 4.5),
    "living": (0, 4.7, 8, 10),
    "office": (8.2, 0, 12, 10),
}
DOORS = ((2, 4.6), (6.5, 4.6), (8.1, 8), (4, 10))


def at(x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(TURN_RAD), math.sin(TURN_RAD)
    return degrees(c * x - s * y, s * x + c * y)


def entry(properties: dict, kind: str, coordinates: object) -> dict:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def room(use: str, x0: float, y0: float, x1: float, y1: float, level: str = "0") -> dict:
    ring = [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1), at(x0, y0)]
    return entry({"indoor": "room", "room": use, "level": level}, "Polygon", [ring])


def write(path, *features: dict):
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return str(path)


def flat(path, doors=DOORS) -> str:
    rooms = [room(use, *sides) for use, sides in ROOMS.items()]
    points = [entry({"door": "hinged", "level": "0"}, "Point", at(*door)) for door in doors]
    return write(path, *rooms, *points, room("bedroom", 0, 0, 4, 4.5, level="1"))


def test_rooms_of_the_ground_floor_have_their_sizes_and_uses(tmp_path):
    scene = open_plan(flat(tmp_path / "flat.geojson"))
    rooms = [obj for obj in scene.objects if obj.category == "room"]
    sizes = {obj.attributes["use"]: sorted(obj.bbox.s[:2]) for obj in rooms}
    assert sizes == {
        use: pytest.approx(sorted((x1 - x0, y1 - y0)), abs=0.02)
        for use, (x0, y0, x1, y1) in ROOMS.items()
    }
    assert len(rooms) == 4
    assert validate(scene) == ()


def test_openings_are_where_the_doors_are(tmp_path):
    scene = open_plan(flat(tmp_path / "flat.geojson"))
    walls = [obj for obj in scene.objects if obj.category == "wall"]
    opened = [obj for obj in walls if "door_m" in obj.attributes]
    assert len(opened) == len(DOORS)
    blind = open_plan(flat(tmp_path / "other.geojson", doors=()))
    n_chosen = sum("door_m" in obj.attributes for obj in blind.objects)
    assert n_chosen == 6  # Each of five pairs of neighbours, and one to the outside.


def test_rooms_without_a_door_are_joined_all_the_same(tmp_path):
    scene = open_plan(flat(tmp_path / "flat.geojson", doors=DOORS[:1]))
    inner = [o for o in scene.objects if o.category == "wall" and "door_m" in o.attributes]
    assert len(inner) == 4  # Three join four rooms, one leads out.


def test_the_place_of_a_plan_is_kept(tmp_path):
    scene = open_plan(flat(tmp_path / "flat.geojson"))
    assert (scene.longitude_deg, scene.latitude_deg) == pytest.approx(degrees(3, 7), abs=1e-4)


def test_a_layout_is_a_plan_without_its_furniture(tmp_path):
    path = tmp_path / "plan.json"
    square = [[0, 0], [5, 0], [5, 5], [0, 5]]
    bed = {"category": "Bed", "p": [2, 2, 0.3], "q": [1, 0, 0, 0], "s": [2, 1.6, 0.6]}
    layout = {
        "scene_id": "mine",
        "domain": "indoor",
        "floor": square,
        "objects": [bed],
        "attributes": {"rooms": [{"room_type": "MasterBedroom", "polygon": square}]},
    }
    path.write_text(json.dumps(layout))
    scene = open_plan(str(path))
    assert not [obj for obj in scene.objects if not obj.is_coarse]
    (room_,) = [obj for obj in scene.objects if obj.category == "room"]
    assert room_.attributes["use"] == "bedroom"
    path.write_text(json.dumps({**layout, "attributes": {}}))
    with pytest.raises(LayoutError, match="has no rooms; valid: areas with a use"):
        open_plan(str(path))


FAULTS = {
    "no rooms": ([entry({"building": "yes"}, "Point", at(0, 0))], "has no rooms; valid: polygons"),
    "too long": ([room("hall", 0, 0, 300, 20)], "m long; valid: at most 160 m"),
    "off the globe": ([entry({}, "Point", [500, 1])], "valid: longitude, latitude"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_no_plan_is_refused_in_one_line(tmp_path, name):
    features, fault = FAULTS[name]
    with pytest.raises(SceneError, match=re.escape(fault)) as caught:
        open_plan(write(tmp_path / "plan.geojson", *features))
    assert "\n" not in str(caught.value)


def test_a_missing_plan_says_so(tmp_path):
    with pytest.raises(MapError, match=r"plan '.*' cannot be read \(no such file"):
        open_plan(str(tmp_path / "plan.geojson"))
