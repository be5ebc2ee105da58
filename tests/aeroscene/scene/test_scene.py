from __future__ import annotations

import math
from dataclasses import replace

import pytest

from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneError, SceneObject
from aeroscene.scene.catalogue import CATALOGUE

SQUARE = ((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0))


def make_box(**changes):
    values = {"p": (0.0, 0.0, 0.5), "q": (1.0, 0.0, 0.0, 0.0), "s": (2.0, 2.0, 1.0)}
    return OrientedBox(**(values | changes))


def make_object(**changes):
    values = {
        "id": 0,
        "scene_id": "here",
        "parent_id": None,
        "category_id": 50,
        "bbox": make_box(),
        "domain": "outdoor",
    }
    return SceneObject(**(values | changes))


def make_area(**changes):
    values = {
        "id": 0,
        "object_id": 0,
        "polygon": SQUARE,
        "centroid": (0.5, 0.5, 1.0),
        "radius": 0.5,
        "drone_class": "small",
        "slope_rad": 0.0,
        "clearance_m": 5.0,
        "surface": "wood",
    }
    return InteractionArea(**(values | changes))


def make_scene(**changes):
    values = {
        "scene_id": "here",
        "domain": "mixed",
        "seed": 1,
        "extent_min_enu_m": (-9.0, -9.0, 0.0),
        "extent_max_enu_m": (9.0, 9.0, 9.0),
        "start_position_enu_m": (5.0, 5.0, 0.0),
        "start_yaw_rad": 0.0,
        "latitude_deg": 47.0,
        "longitude_deg": 8.0,
        "altitude_m": 400.0,
        "objects": (make_object(), make_object(id=1, parent_id=0)),
        "interaction_areas": (make_area(),),
    }
    return Scene(**(values | changes))


_SEEDS = f"valid: an integer from 0 to {2**63 - 1}"


@pytest.mark.parametrize(
    ("make", "changes", "message"),
    [
        (
            make_box,
            {"q": (2.0, 0.0, 0.0, 0.0)},
            "bbox.q is (2.0, 0.0, 0.0, 0.0); valid: a quaternion wxyz of norm 1 (this one has 2)",
        ),
        (
            make_box,
            {"s": (1.0, 0.0, 1.0)},
            "bbox.s is (1.0, 0.0, 1.0); valid: three extents from 0.001 to 1000 m",
        ),
        (
            make_box,
            {"p": (math.nan, 0.0, 0.0)},
            "bbox.p is (nan, 0.0, 0.0); valid: 3 finite numbers",
        ),
        (make_object, {"category_id": 71}, "object 0: category_id is 71; valid: 1 to 70"),
        (make_object, {"domain": "space"}, "object 0: domain is 'space'; valid: indoor, outdoor"),
        (
            make_object,
            {"attributes": {"storeys": math.inf}},
            "object 0: attributes.storeys is inf; valid: a number from -1e+09 to 1e+09",
        ),
        (
            make_area,
            {"polygon": SQUARE[::-1]},
            (
                f"interaction area 0: polygon is {SQUARE[::-1]}; valid: a simple polygon, "
                "counter-clockwise seen from above"
            ),
        ),
        (
            make_area,
            {"radius": 0.6},
            (
                "interaction area 0: radius is 0.6; valid: at most 0.500 m, the distance from the "
                "centroid to the border"
            ),
        ),
        (
            make_area,
            {"centroid": (3.0, 0.5, 1.0)},
            "interaction area 0: centroid is (3.0, 0.5, 1.0); valid: a point inside the polygon",
        ),
        (
            make_area,
            {"drone_class": "huge"},
            "interaction area 0: drone_class is 'huge'; valid: small, medium, large",
        ),
        (
            make_scene,
            {"objects": (make_object(), make_object())},
            "scene 'here': object 0: id is used twice; valid: an id of its own",
        ),
        (
            make_scene,
            {"objects": (make_object(parent_id=1), make_object(id=1))},
            (
                "scene 'here': object 0: parent_id is 1; valid: null or the id of an object that "
                "comes before it"
            ),
        ),
        (
            make_scene,
            {"objects": (make_object(scene_id="there"),)},
            "scene 'here': object 0: scene_id is 'there'; valid: 'here'",
        ),
        (
            make_scene,
            {"objects": (make_object(bbox=make_box(p=(5000.0, 0.0, 0.0))),)},
            (
                "scene 'here': object 0: bbox.p is (5000.0, 0.0, 0.0); valid: at most 1000 m "
                "outside the extent"
            ),
        ),
        (
            make_scene,
            {"start_position_enu_m": (10.0, 0.0, 0.0)},
            (
                "scene 'here': start.position is (10.0, 0.0, 0.0); valid: a point inside the "
                "extent, (-9.0, -9.0, 0.0) to (9.0, 9.0, 9.0)"
            ),
        ),
        (
            make_scene,
            {"interaction_areas": (make_area(object_id=7),)},
            "scene 'here': interaction area 0: object_id is 7; valid: null or the id of an object",
        ),
        (
            make_scene,
            {"latitude_deg": 91.0},
            "scene 'here': latitude_deg is 91.0; valid: -90 to 90",
        ),
        (make_scene, {"seed": -1}, f"scene 'here': seed is -1; {_SEEDS}"),
        (make_scene, {"seed": 10**30}, f"scene 'here': seed is {10**30}; {_SEEDS}"),
        (
            make_scene,
            {"altitude_m": 1e300},
            "scene 'here': altitude_m is 1e+300; valid: -1000 to 10000 m",
        ),
        (
            make_scene,
            {"start_yaw_rad": 1e300},
            "scene 'here': start.yaw is 1e+300; valid: a number from -6.28319 to 6.28319",
        ),
        (
            make_scene,
            {"theme": "\u202epark\x1b[2J"},
            (
                "scene 'here': theme is '\\u202epark\\x1b[2J'; valid: 0 to 200 characters, no "
                "control characters"
            ),
        ),
    ],
)
def test_broken_document_gives_one_line_with_place_value_and_what_is_valid(make, changes, message):
    with pytest.raises(SceneError) as caught:
        make(**changes)
    assert str(caught.value) == message


def test_figure_of_eight_is_no_polygon():
    bow = ((0.0, 0.0, 0.0), (2.0, 2.0, 0.0), (2.0, 0.0, 0.0), (0.0, 3.0, 0.0))
    for outline in (bow, bow[::-1]):
        with pytest.raises(SceneError, match="simple polygon"):
            make_area(polygon=outline, centroid=(0.2, 1.0, 0.0), radius=0.1)


def test_concave_polygon_is_accepted_where_the_circle_fits():
    ell = ((0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0))
    area = make_area(
        polygon=tuple((x, y, 1.0) for x, y in ell), centroid=(1.0, 1.0, 1.0), radius=1.0
    )
    assert area.radius == 1.0
    with pytest.raises(SceneError, match="a point inside"):
        replace(area, centroid=(3.0, 3.0, 1.0))


def test_hierarchy_is_readable_in_both_directions():
    scene = make_scene(objects=(*make_scene().objects, make_object(id=5, parent_id=1)))
    assert scene.ancestors(5) == (1, 0)
    assert [obj.id for obj in scene.children_by_id[0]] == [1]
    assert [obj.id for obj in scene.children_by_id[None]] == [0]
    assert scene.object_by_id[5].category == CATALOGUE[50].name


def test_scene_without_objects_is_valid():
    assert make_scene(objects=(), interaction_areas=()).objects == ()


def test_areas_to_land_and_to_perch_on_are_told_apart():
    areas = (make_area(), make_area(id=1, kind="perching"))
    scene = make_scene(interaction_areas=areas)
    assert scene.landing_areas == areas[:1]
    assert scene.perching_areas == areas[1:]


def test_another_kind_of_area_is_refused():
    with pytest.raises(SceneError, match="kind is 'hovering'; valid: landing, perching"):
        make_area(kind="hovering")
