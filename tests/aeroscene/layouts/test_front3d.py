from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aeroscene.layouts import LayoutError, read_layout, read_layouts
from aeroscene.layouts.front3d import front3d_layout
from aeroscene.scene.box import box_corners
from tests.aeroscene.layouts.samples import front3d_house, write_json


def child(house, ref):
    return next(c for c in house["scene"]["room"][0]["children"] if c["ref"] == ref)


def corners_in_their_frame(size, pos, rot_xyzw, scale):
    """Corners of a model whose origin is the middle of its bottom, y up."""
    x, y, z = np.multiply(size, scale)
    signs = np.array([(a, b, c) for a in (-0.5, 0.5) for b in (0, 1) for c in (-0.5, 0.5)])
    return Rotation.from_quat(rot_xyzw).apply(signs * (x, y, z)) + pos


@given(
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.1),
    st.tuples(*[st.floats(-8, 8)] * 3),
    st.tuples(*[st.floats(0.2, 2)] * 3),
    st.tuples(*[st.floats(0.3, 3)] * 3),
)
def test_a_piece_fills_the_same_space_in_both_frames(q, pos, size, scale):
    rot = [v / math.hypot(*q) for v in q]
    house = front3d_house()
    house["furniture"][0]["size"] = list(size)
    child(house, "1/model").update(pos=list(pos), rot=rot, scale=list(scale))
    piece = front3d_layout(house).objects[0]
    theirs = corners_in_their_frame(size, pos, rot, scale)
    # X = -x, Y = z, Z = y about the middle of the floor, which is (2, 1.5) in x and z.
    expected = np.stack([2 - theirs[:, 0], theirs[:, 2] - 1.5, theirs[:, 1]], axis=1)
    gaps = np.linalg.norm(box_corners(piece.p, piece.q, piece.s)[:, None] - expected, axis=-1)
    assert gaps.min(axis=0).max() < 1e-3


def test_a_house_has_its_rooms_and_its_public_furniture():
    layout = front3d_layout(front3d_house())
    assert layout.scene_id == "made-up-house"
    (room,) = layout.rooms
    assert room.name == "Bedroom-1"
    assert sorted(room.polygon) == [(-2, -1.5), (-2, 1.5), (2, -1.5), (2, 1.5)]
    assert [obj.category for obj in layout.objects] == ["Single bed", "shelf/book shelf"]
    assert layout.objects[0].q == pytest.approx((1, 0, 0, 0))
    assert layout.objects[0].s == (1.6, 2.0, 1.0)
    assert layout.front == "y"
    assert layout.attributes["ignored_children"] == 2


def test_a_file_is_recognised_and_flyable(tmp_path):
    path = write_json(tmp_path / "house.json.gz", front3d_house())
    scene, report = read_layout(path)
    assert report.by_category == {"bed": 1, "shelf": 1}
    assert scene.landing_areas


def test_categories_come_from_model_info_where_the_house_has_none(tmp_path):
    house = front3d_house()
    del house["furniture"][0]["category"]
    info = [{"model_id": "j1", "category": None, "super-category": "Bed"}]
    write_json(tmp_path / "model_info.json", info)
    (tmp_path / "houses").mkdir()
    (layout,) = read_layouts(write_json(tmp_path / "houses" / "house.json", house))
    assert layout.objects[0].category == "Bed"


def test_older_files_call_the_size_bbox():
    house = front3d_house()
    house["furniture"][0]["bbox"] = house["furniture"][0].pop("size")
    assert front3d_layout(house) == front3d_layout(front3d_house())


def test_floors_of_one_room_are_one_outline():
    house = front3d_house()
    half = {"uid": "m3", "type": "Floor", "xyz": [4, 0, 0, 6, 0, 0, 6, 0, 2, 4, 0, 2]}
    house["mesh"].append(half | {"faces": [0, 1, 2, 0, 2, 3]})
    house["scene"]["room"][0]["children"].append(child(house, "m1") | {"ref": "m3"})
    (room,) = front3d_layout(house).rooms
    assert len(room.polygon) == 6


def test_a_house_without_floors_stands_on_a_rectangle_about_its_furniture():
    house = front3d_house() | {"mesh": []}
    layout = front3d_layout(house)
    assert layout.rooms == ()
    xs, ys = zip(*layout.floor, strict=True)
    for obj in layout.objects:
        assert min(xs) < obj.p[0] < max(xs)
        assert min(ys) < obj.p[1] < max(ys)


BAD = {
    "rot no unit": (("1/model", {"rot": [0, 0, 0.5, 1]}), "rot is [0, 0, 0.5, 1]"),
    "pos nan": (("1/model", {"pos": [math.nan, 0, 0]}), "pos is [nan, 0, 0]"),
    "scale zero": (("1/model", {"scale": [0, 1, 1]}), "size times scale is [0.0, 1.0, 2.0]"),
    "scale missing a number": (("1/model", {"scale": [1, 1]}), "scale is [1, 1]"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_child_is_named_or_skipped_and_counted(name):
    (ref, change), fault = BAD[name]
    house = front3d_house()
    child(house, ref).update(change)
    with pytest.raises(LayoutError) as caught:
        front3d_layout(house)
    place = "scene 'made-up-house': object Bedroom-1/children[2]: "
    assert str(caught.value).startswith(place + fault)
    layout = front3d_layout(house, skip_invalid=True)
    assert len(layout.objects) == 1
    assert len(layout.invalid) == 1


def test_bad_records_are_named():
    house = front3d_house()
    house["furniture"][1]["uid"] = "1/model"
    with pytest.raises(LayoutError, match=r"furniture\[1\]: uid '1/model' is used twice"):
        front3d_layout(house)
    house = front3d_house()
    del house["furniture"][0]["size"]
    with pytest.raises(LayoutError, match=r"children\[2\]: size is None; valid: 3 finite numbers"):
        front3d_layout(house)
    house = front3d_house()
    house["mesh"][0]["faces"] = [0, 1, 99]
    with pytest.raises(LayoutError, match=r"children\[0\]: xyz and faces of mesh 'm1'"):
        front3d_layout(house)
    with pytest.raises(LayoutError, match="room is missing"):
        front3d_layout(front3d_house() | {"scene": {}})


def test_a_house_cut_short_is_named_by_its_line(tmp_path):
    path = tmp_path / "house.json"
    path.write_text(json.dumps(front3d_house(), indent=1)[:-40])
    with pytest.raises(LayoutError, match=r"house.json' line \d+: JSON is cut short"):
        list(read_layouts(path))
