from __future__ import annotations

import pytest

from aeroscene.maps import open_map
from aeroscene.maps.bounds import parse_bounds
from aeroscene.maps.place import locate
from aeroscene.maps.reader import read_map
from aeroscene.scene.footprint import footprint
from flightsim.frames import Geodetic, LocalFrame
from tests.aeroscene.maps.samples import OsmFile, bounds_text, degrees, town


def test_metres_of_a_map_are_those_of_a_flight_to_a_centimetre_at_500_m(tmp_path):
    file = OsmFile()
    points = [(150.0, 100.0), (-190.0, 190.0), (-120.5, -77.25)]
    for point in points:
        file.node(point, natural="tree")
    file.area([(-5, -5), (5, -5), (5, 5), (-5, 5)], {"building": "yes"})
    path = file.write(tmp_path / "map.osm")
    raw, bounds = read_map(path, bounds_text(195, 195))
    place = locate(raw, bounds)
    scene, _ = open_map(path, bounds_text(195, 195))
    frame = LocalFrame(Geodetic(scene.latitude_deg, scene.longitude_deg, scene.altitude_m))
    for point, feature in zip(points, place.features, strict=False):
        lon, lat = degrees(*point)
        x, y, _ = frame.enu_from_geodetic(Geodetic(lat, lon, 0.0))
        assert (feature.geometry.x, feature.geometry.y) == pytest.approx((x, y), abs=1e-3)
    far = frame.geodetic_from_enu((350.0, 357.0, 0.0))
    assert (far.longitude_deg, far.latitude_deg) == pytest.approx(degrees(350, 357), abs=1e-7)


def test_what_reaches_over_the_bounds_is_cut_there(tmp_path):
    scene, _ = open_map(town().write(tmp_path / "map.osm"), bounds_text(35, 30))
    for obj in scene.objects:
        x0, y0, x1, y1 = footprint(obj).bounds
        assert -35.02 <= x0 <= x1 <= 35.02, obj
        assert -30.02 <= y0 <= y1 <= 30.02, obj


def test_the_origin_is_in_the_middle_of_the_bounds(tmp_path):
    text = bounds_text(50, 40)
    scene, _ = open_map(town().write(tmp_path / "map.osm"), text)
    bounds = parse_bounds(text)
    assert (scene.latitude_deg, scene.longitude_deg) == (bounds.latitude_deg, bounds.longitude_deg)
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    assert (low[0], low[1]) == pytest.approx((-50, -40), abs=0.02)
    assert (high[0], high[1]) == pytest.approx((50, 40), abs=0.02)
