from __future__ import annotations

import gzip
import json
import re

import pytest

from aeroscene.maps import osm_data
from aeroscene.maps.document import MapError
from aeroscene.maps.reader import read_map
from aeroscene.scene import SceneError
from tests.aeroscene.maps.samples import OsmFile, bounds_text, degrees, town

NODE = '<node id="1" lat="55" lon="18"/>'
LAUGHS = '<!DOCTYPE osm [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;">]>'
BROKEN_XML = {
    "document type": (f"<?xml version='1.0'?>{LAUGHS}<osm>&c;</osm>", "it has a document type"),
    "external entity": ('<!DOCTYPE osm SYSTEM "file:///etc/passwd"><osm/>', "document type"),
    "undefined entity": ("<osm>&a;</osm>", "malformed or cut short"),
    "other root": ("<gpx></gpx>", "its root is 'gpx'; valid: 'osm'"),
    "cut short": (f"<osm>{NODE}<way", "malformed or cut short"),
    "empty": ("", "malformed or cut short"),
    "nested": ("<osm>" + "<a>" * 20 + "</a>" * 20 + "</osm>", "nested deeper than 8"),
    "not a number": ('<osm><node id="1" lat="nan" lon="18"/></osm>', "node 1: lat is nan"),
    "infinite": ('<osm><node id="1" lat="1" lon="inf"/></osm>', "node 1: lon is inf"),
    "no latitude": ('<osm><node id="1" lon="18"/></osm>', "node 1: lat is ''"),
    "off the globe": ('<osm><node id="1" lat="95" lon="18"/></osm>', "node 1: lat is 95.0"),
    "id": ('<osm><node id="x" lat="5" lon="18"/></osm>', "node: id is 'x'"),
    "id of two signs": ('<osm><node id="--5" lat="5" lon="18"/></osm>', "node: id is '--5'"),
    "id in another script": ('<osm><node id="٣" lat="5" lon="18"/></osm>', "node: id is '٣'"),
    "long id": (f'<osm><node id="{"9" * 5000}" lat="5" lon="18"/></osm>', "node: id is '999"),
    "reference": ('<osm><way id="2"><nd ref="one"/></way></osm>', "way 2: ref is 'one'"),
    "long tag": (f'<osm><way id="2"><tag k="{"k" * 2000}" v=""/></way></osm>', "way 2 has tag"),
    "bounds": ('<osm><bounds minlat="2" minlon="1" maxlat="1" maxlon="2"/></osm>', "bounds are"),
}


@pytest.mark.parametrize("name", BROKEN_XML)
def test_broken_xml_is_refused_in_one_line_with_its_place(tmp_path, name):
    text, fault = BROKEN_XML[name]
    path = tmp_path / "map.osm"
    path.write_text(text)
    with pytest.raises(MapError, match=re.escape(fault)) as caught:
        read_map(path, bounds_text())
    assert re.match(r"map file '.*map\.osm' line \d+: ", str(caught.value))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600


def test_more_nodes_and_references_than_the_bounds_are_refused(tmp_path, monkeypatch):
    path = town().write(tmp_path / "map.osm")
    monkeypatch.setattr(osm_data, "MOST_NODES", 20)
    with pytest.raises(MapError, match="more than 20 nodes"):
        read_map(path, bounds_text())
    monkeypatch.undo()
    monkeypatch.setattr(osm_data, "MOST_OF_ONE", 3)
    with pytest.raises(MapError, match=r"way \d+ has more than 3 references"):
        read_map(path, bounds_text())


def test_a_gzip_bomb_is_refused_at_its_bound(tmp_path, monkeypatch):
    path = tmp_path / "map.osm.gz"
    path.write_bytes(gzip.compress(b"<osm>" + b" " * (4 << 20) + b"</osm>"))
    monkeypatch.setattr("aeroscene.maps.reader.MOST_OSM_BYTES", 1 << 20)
    with pytest.raises(MapError, match="holds more than 1 MiB"):
        read_map(path, bounds_text())


def test_too_large_bounds_are_refused_before_the_file_is_opened(tmp_path):
    with pytest.raises(SceneError, match="bounds are 1000 x 100 m"):
        read_map(tmp_path / "not there.osm", bounds_text(500, 50))


def test_a_missing_file_says_so(tmp_path):
    with pytest.raises(MapError, match=r"not there\.osm' cannot be read \(no such file"):
        read_map(tmp_path / "not there.osm", bounds_text())


def test_plain_and_packed_xml_hold_the_same_features(tmp_path):
    path = town().write(tmp_path / "map.osm")
    packed = tmp_path / "map.osm.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert read_map(path, bounds_text()) == read_map(packed, bounds_text())


def test_pbf_holds_the_same_features_as_xml(tmp_path):
    osmium = pytest.importorskip("osmium")
    path = town().write(tmp_path / "map.osm")
    packed = tmp_path / "map.osm.pbf"
    writer = osmium.SimpleWriter(str(packed))
    for element in osmium.FileProcessor(str(path)):
        writer.add(element)
    writer.close()
    plain, _ = read_map(path, bounds_text())
    binary, _ = read_map(packed, bounds_text(80, 80))
    names = {feature.source_id for feature in binary.features}
    assert names == {feature.source_id for feature in plain.features}
    tags = {feature.source_id: feature.tags for feature in plain.features}
    assert all(tags[feature.source_id] == feature.tags for feature in binary.features)


def test_damaged_pbf_is_refused(tmp_path):
    pytest.importorskip("osmium")
    path = tmp_path / "map.osm.pbf"
    path.write_bytes(b"\0\0\0\x0f" + b"x" * 100)
    with pytest.raises(MapError, match=r"cannot be read .*; valid: a whole PBF file"):
        read_map(path, bounds_text())


def test_deleted_elements_are_left_out(tmp_path):
    path = tmp_path / "map.osm"
    path.write_text(
        '<osm><node id="1" lat="55" lon="18" visible="false"><tag k="natural" v="tree"/></node>'
        '<node id="2" lat="55" lon="18" action="delete"><tag k="natural" v="tree"/></node>'
        '<node id="3" lat="55" lon="18"><tag k="natural" v="tree"/></node></osm>'
    )
    raw, _ = read_map(path, bounds_text())
    assert [feature.source_id for feature in raw.features] == ["node/3"]


def test_relations_that_hold_each_other_or_nothing_end(tmp_path):
    file = OsmFile()
    tags = {"type": "multipolygon", "landuse": "grass"}
    file.relation([("relation", 2, "outer")], tags)
    file.relation([("relation", 1, "outer"), ("way", 99, "outer")], tags)
    raw, _ = read_map(file.write(tmp_path / "map.osm"), bounds_text())
    assert not raw.features
    assert sum(raw.dropped.values()) == 2


def test_rings_of_several_ways_are_joined_and_courts_cut_out(tmp_path):
    raw, _ = read_map(town().write(tmp_path / "map.osm"), bounds_text())
    (court,) = [f for f in raw.features if f.tags.get("building") == "apartments"]
    assert len(court.geometry.interiors) == 1


def geojson(*features: object) -> bytes:
    return json.dumps({"type": "FeatureCollection", "features": features}).encode()


def feature(geometry: object, **properties: object) -> dict:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def square(half_m: float = 5.0) -> dict:
    corners = [(-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)]
    ring = [degrees(*corner) for corner in (*corners, corners[0])]
    return {"type": "Polygon", "coordinates": [ring]}


def test_tags_stand_in_properties_or_in_tags(tmp_path):
    path = tmp_path / "map.geojson"
    path.write_bytes(
        geojson(
            feature(square(), **{"@id": "way/7", "building": "yes", "building:levels": 3}),
            feature(square(), tags={"landuse": "grass"}, id=5),
            feature(square(), HEIGHT=12.5, OBJECTID=3),
        )
    )
    raw, _ = read_map(path, bounds_text())
    assert [f.tags for f in raw.features] == [
        {"@id": "way/7", "building": "yes", "building:levels": "3"},
        {"landuse": "grass"},
        {"HEIGHT": "12.5", "OBJECTID": "3", "building": "yes", "height": "12.5"},
    ]
    assert raw.features[0].source_id == "way/7"


BROKEN_GEOJSON = {
    "cut short": (b'{"type": "FeatureCollection", "features": [', "not JSON or not all of it"),
    "a list": (b"[]", "type is None"),
    "topology": (b'{"type": "Topology"}', "type is 'Topology'; valid: 'FeatureCollection'"),
    "deep": (b"[" * 100_000, "not JSON or not all of it"),
    "number for a feature": (geojson(5), "features[0] is 5"),
    "metres": (
        geojson(feature({"type": "Point", "coordinates": [390_000, 5_800_000]})),
        "valid: longitude, latitude in degrees",
    ),
    "not a number": (
        b'{"type": "FeatureCollection", "features": [{"geometry": {"coordinates": [NaN, 1]}}]}',
        "not JSON or not all of it",
    ),
    "text": (geojson(feature({"type": "Point", "coordinates": ["18", "55"]})), "has the position"),
    "flat ring": (
        geojson(feature({"type": "Polygon", "coordinates": [[18, 55], [18, 55]]})),
        "has the position 18",
    ),
    "short ring": (
        geojson(feature({"type": "Polygon", "coordinates": [[[18, 55], [18, 55]]]})),
        "is no Polygon",
    ),
    "no ring": (geojson(feature({"type": "Polygon", "coordinates": []})), "is no Polygon"),
}


@pytest.mark.parametrize("name", BROKEN_GEOJSON)
def test_broken_geojson_is_refused_in_one_line(tmp_path, name):
    data, fault = BROKEN_GEOJSON[name]
    path = tmp_path / "map.geojson"
    path.write_bytes(data)
    with pytest.raises(MapError, match=re.escape(fault)) as caught:
        read_map(path, bounds_text())
    assert str(caught.value).startswith("map file ")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600


def test_features_without_geometry_are_counted(tmp_path):
    path = tmp_path / "map.geojson"
    path.write_bytes(geojson(feature(None), feature({"type": "Circle"}), feature(square())))
    raw, _ = read_map(path, bounds_text())
    assert len(raw.features) == 1
    assert sum(raw.dropped.values()) == 2
