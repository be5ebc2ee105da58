from __future__ import annotations

import gzip
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.files.visible import is_visible
from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneError, SceneObject
from aeroscene.scene.box import box_corners
from aeroscene.scene.io import read_scene, scene_from_json, scene_to_json, write_scene

coordinates = st.floats(-400, 400)
extents = st.floats(0.01, 90)
angles = st.floats(-math.pi, math.pi)
names = st.text(min_size=1, max_size=8).filter(is_visible)
attribute_values = st.one_of(
    st.text(max_size=6), st.booleans(), st.integers(-9, 9), st.floats(-1e6, 1e6)
)


@st.composite
def boxes(draw) -> OrientedBox:
    axis = np.array([draw(coordinates), draw(coordinates), draw(coordinates) + 500.0])
    half = draw(angles) / 2
    x, y, z = (math.sin(half) * axis / np.linalg.norm(axis)).tolist()
    p = (draw(coordinates), draw(coordinates), draw(coordinates))
    return OrientedBox(p, (math.cos(half), x, y, z), (draw(extents), draw(extents), draw(extents)))


@st.composite
def scenes(draw) -> Scene:
    scene_id = draw(names)
    objects: list[SceneObject] = []
    for number in range(draw(st.integers(0, 5))):
        parent = draw(st.one_of(st.none(), st.integers(0, number - 1))) if number else None
        objects.append(
            SceneObject(
                id=number,
                scene_id=scene_id,
                parent_id=parent,
                category_id=draw(st.integers(1, 70)),
                bbox=draw(boxes()),
                domain=draw(st.sampled_from(["indoor", "outdoor"])),
                attributes=draw(st.dictionaries(names, attribute_values, max_size=3)),
            )
        )
    x, y, z, r = draw(coordinates), draw(coordinates), draw(coordinates), draw(extents)
    area = InteractionArea(
        id=3,
        kind=draw(st.sampled_from(["landing", "perching"])),
        object_id=draw(st.sampled_from([None, *range(len(objects))])),
        polygon=((x - r, y - r, z), (x + r, y - r, z), (x + r, y + r, z), (x - r, y + r, z)),
        centroid=(x, y, z),
        radius=r,
        drone_class=draw(st.sampled_from(["small", "medium", "large"])),
        slope_rad=draw(st.floats(0, 1.5)),
        clearance_m=draw(extents),
        surface="grass",
    )
    return Scene(
        scene_id=scene_id,
        domain=draw(st.sampled_from(["indoor", "outdoor", "mixed"])),
        seed=draw(st.integers(0, 2**40)),
        extent_min_enu_m=(-400.0, -400.0, -400.0),
        extent_max_enu_m=(400.0, 400.0, 400.0),
        start_position_enu_m=(draw(coordinates), draw(coordinates), draw(coordinates)),
        start_yaw_rad=draw(angles),
        latitude_deg=draw(st.floats(-90, 90)),
        longitude_deg=draw(st.floats(-180, 180)),
        altitude_m=draw(coordinates),
        objects=tuple(objects),
        interaction_areas=(area,),
    )


@settings(max_examples=60, deadline=None)
@given(scenes())
def test_what_is_written_reads_back_equal_and_writes_the_same_bytes(scene):
    data = scene_to_json(scene)
    again = scene_from_json(data)
    assert again == scene
    assert scene_to_json(again) == data


def test_corpus_scene_survives_a_file(scene_42, tmp_path):
    path = tmp_path / "scene.json"
    write_scene(scene_42, path)
    assert read_scene(path) == scene_42
    assert [entry.name for entry in tmp_path.iterdir()] == ["scene.json"]


def test_wishes_and_measures_are_in_the_document_only_where_there_are_any(scene_42):
    assert not {"wishes", "measured"} & set(json.loads(scene_to_json(scene_42)))
    wishes = {"difficulty": "hard", "density": 1.5, "objects": 80}
    measured = {"difficulty": "hard", "seconds": 12.5, "is_blocked": False}
    asked = replace(scene_42, wishes=wishes, measured=measured)
    document = json.loads(scene_to_json(asked))
    assert (document["wishes"], document["measured"]) == (wishes, measured)
    assert scene_from_json(scene_to_json(asked)) == asked
    assert scene_from_json(scene_to_json(asked)) != scene_42
    with pytest.raises(SceneError, match=r"wishes\.density"):
        replace(scene_42, wishes={"density": math.nan})
    broken = scene_to_json(asked).replace(b'"density":1.5', b'"density":[1.5]')
    with pytest.raises(SceneError, match="wishes"):
        scene_from_json(broken)


def test_file_follows_the_papers_schema(scene_42):
    document = json.loads(scene_to_json(scene_42))
    assert document["format"] == "aeroscene-scene"
    assert document["version"] == 1
    first = document["objects"][0]
    assert set(first) == {
        "id", "scene_id", "parent_id", "category_id", "bbox", "bbox_corners", "domain", "attributes"
    }  # fmt: skip
    assert set(first["bbox"]) == {"p", "q", "s"}
    assert np.shape(first["bbox_corners"]) == (8, 3)
    box = first["bbox"]
    assert np.allclose(first["bbox_corners"], box_corners(box["p"], box["q"], box["s"]), atol=1e-4)
    area = document["interaction_areas"][0]
    assert {"polygon", "centroid", "radius", "drone_class"} <= set(area)


def test_a_theme_is_kept_and_left_out_where_there_is_none(scene_42):
    named = replace(scene_42, theme="park")
    assert json.loads(scene_to_json(named))["theme"] == "park"
    assert scene_from_json(scene_to_json(named)).theme == "park"
    bare = replace(scene_42, theme="")
    assert "theme" not in json.loads(scene_to_json(bare))
    assert scene_from_json(scene_to_json(bare)) == bare
    assert scene_42.theme == "waterfront"


@settings(max_examples=80, deadline=None)
@given(data=st.data())
def test_text_cut_anywhere_is_refused_in_one_line(scene_42, data):
    text = scene_to_json(scene_42)
    cut = data.draw(st.integers(0, len(text) - 3))
    with pytest.raises(SceneError) as caught:
        scene_from_json(text[:cut], source="cut.json")
    assert str(caught.value).startswith("cut.json: not JSON or not all of it (")
    assert "\n" not in str(caught.value)


def _edited(scene: Scene, edit) -> bytes:
    document = json.loads(scene_to_json(scene))
    edit(document)
    return json.dumps(document).encode()


def _set(*path):
    *way, last, value = path

    def edit(document):
        for step in way:
            document = document[step]
        document[last] = value

    return edit


def _drop(*path):
    *way, last = path

    def edit(document):
        for step in way:
            document = document[step]
        del document[last]

    return edit


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            _set("version", 2),
            "format is 'aeroscene-scene' version 2; valid: 'aeroscene-scene' version 1",
        ),
        (
            _set("format", "glTF"),
            "format is 'glTF' version 1; valid: 'aeroscene-scene' version 1",
        ),
        (_drop("format"), "Object missing required field `format`"),
        (_drop("objects"), "Object missing required field `objects`"),
        (_set("colour", 1), "Object contains unknown field `colour`"),
        (_drop("objects", 5, "bbox"), "object 5: Object missing required field `bbox`"),
        (_set("objects", 5, "id", "x"), "object x: id: Expected `int`, got `str`"),
        (
            _set("objects", 5, "bbox", "p", [0, 0]),
            "object 5: bbox.p: Expected `array` of length 3",
        ),
        (
            _set("objects", 5, "bbox", "s", 1, None),
            "object 5: bbox.s[1]: Expected `float`, got `null`",
        ),
        (
            _set("objects", 5, "parent_id", 99999),
            (
                "scene 'corpus-0042': object 5: parent_id is 99999; valid: null or the id of an "
                "object that comes before it"
            ),
        ),
        (
            _set("objects", 5, "category_id", 0),
            "scene 'corpus-0042': object 5: category_id is 0; valid: 1 to 70",
        ),
        (
            _set("interaction_areas", 2, "radius", -1.0),
            "scene 'corpus-0042': interaction area 2: radius is -1.0; valid: above 0 m",
        ),
        (
            _set("interaction_areas", 2, "polygon", 7),
            "interaction area 2: polygon: Expected `array`, got `int`",
        ),
    ],
)
def test_broken_file_names_scene_object_and_field(scene_42, edit, message):
    with pytest.raises(SceneError) as caught:
        scene_from_json(_edited(scene_42, edit), source="s.json")
    assert str(caught.value) == f"s.json: {message}"


def test_corners_that_do_not_belong_to_the_box_are_computed_again_with_a_note(scene_42, caplog):
    document = json.loads(scene_to_json(scene_42))
    document["objects"][4]["bbox"]["p"][0] += 0.25
    moved = scene_from_json(json.dumps(document), "mine.json")
    (entry,) = caplog.records
    assert entry.getMessage() == (
        "mine.json: bbox_corners of object 4 lie up to 0.25 m away from the corners of bbox, which "
        "counts; they are computed again"
    )
    assert moved.objects[4].bbox.p == tuple(document["objects"][4]["bbox"]["p"])
    caplog.clear()
    assert scene_from_json(scene_to_json(moved)) == moved
    assert not caplog.records


def test_a_note_about_many_corners_stays_one_line(scene_42, caplog):
    def move_all(document):
        for record in document["objects"]:
            record["bbox_corners"][0][0] = 1e308

    scene_from_json(_edited(scene_42, move_all))
    (entry,) = caplog.records
    assert f"0, 1, 2, 3, 4 and {len(scene_42.objects) - 5} others" in entry.getMessage()


def test_what_follows_from_the_rest_may_be_left_out_by_people_who_may_comment(scene_42, caplog):
    def as_by_hand(document):
        document["comment"] = ["A scene by hand.", "It has two lines."]
        for record in document["objects"]:
            del record["bbox_corners"], record["scene_id"]
            record["comment"] = "an object"

    assert scene_from_json(_edited(scene_42, as_by_hand)) == scene_42
    assert not caplog.records


def test_areas_are_derived_only_where_the_file_lists_none_and_somebody_can(scene_42):
    without = _edited(scene_42, _drop("interaction_areas"))
    with pytest.raises(SceneError, match=r"^scene JSON: interaction_areas is missing; valid: "):
        scene_from_json(without)
    areas = scene_42.interaction_areas[:2]
    assert scene_from_json(without, derive=lambda _: areas).interaction_areas == areas
    none = _edited(scene_42, _set("interaction_areas", []))
    assert scene_from_json(none, derive=lambda _: areas).interaction_areas == ()


@pytest.mark.parametrize(
    "data",
    [b"", b"null", b"[]", b"\xff\xfe", b"NaN", b"[" * 200_000, b'{"format":' + b"[" * 200_000],
    ids=["empty", "null", "list", "binary", "nan", "deep", "deep-inside"],
)
def test_what_is_no_scene_at_all_is_refused_in_one_line(data):
    with pytest.raises(SceneError) as caught:
        scene_from_json(data)
    assert "\n" not in str(caught.value)


def test_missing_file_is_named(tmp_path):
    path = tmp_path / "none.json"
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert str(caught.value) == (
        f"scene file {str(path)!r} cannot be read (no such file or directory); "
        "valid: a scene in JSON"
    )


def test_failed_write_leaves_the_old_file_and_nothing_else(scene_42, tmp_path, monkeypatch):
    path = tmp_path / "scene.json"
    path.write_text("old")

    def refuse(self: Path, target: Path):
        raise OSError("disk full")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_scene(scene_42, path)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["scene.json"]


def test_a_compressed_file_holds_the_same_scene_in_the_same_bytes(scene_42, tmp_path):
    first, second = tmp_path / "a.json.gz", tmp_path / "b.json.gz"
    write_scene(scene_42, first)
    write_scene(scene_42, second)
    assert first.read_bytes() == second.read_bytes()
    assert gzip.decompress(first.read_bytes()) == scene_to_json(scene_42)
    assert read_scene(first) == scene_42
    assert first.stat().st_size < 0.3 * len(scene_to_json(scene_42))


def test_a_compressed_file_is_known_by_what_is_in_it(scene_42, tmp_path):
    path = tmp_path / "scene.json"
    path.write_bytes(gzip.compress(scene_to_json(scene_42)))
    assert read_scene(path) == scene_42


@pytest.mark.parametrize("cut", [5, 20, 400])
def test_a_compressed_file_cut_short_is_named(scene_42, tmp_path, cut):
    path = tmp_path / "scene.json.gz"
    write_scene(scene_42, path)
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(SceneError, match=r"scene\.json\.gz': gzip is damaged or cut short"):
        read_scene(path)
