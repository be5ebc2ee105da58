"""Relief: one surface, the same after a round trip, and bad grids refused in one line."""

import json
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.field import field_scene
from aeroscene.scene import Relief, SceneError
from aeroscene.scene.io import scene_from_json, scene_to_json
from aeroscene.scene.relief import ground_m
from tests.flightsim.handmade import hills, relief_scene

CELL = Relief.from_rows((2.0, -3.0), 2.0, [[0.0, 1.0], [0.5, 3.0]])


def test_heights_at_nodes_on_edges_and_in_both_triangles_of_a_cell():
    places = {
        (2.0, -3.0): 0.0,
        (4.0, -3.0): 1.0,
        (2.0, -1.0): 0.5,
        (4.0, -1.0): 3.0,
        (3.0, -2.0): 1.5,  # the common edge runs from south-west to north-east
        (3.0, -3.0): 0.5,
        (3.5, -2.5): 0.75 + 0.25 * 2.0,
        (2.5, -1.5): 0.75 * 0.5 + 0.25 * 2.5,
    }
    for (x, y), height_m in places.items():
        assert CELL.height_m(x, y) == pytest.approx(height_m)


def test_beyond_the_grid_the_height_is_that_of_the_nearest_point_of_the_border():
    assert CELL.height_m(-100.0, -2.0) == pytest.approx(CELL.height_m(2.0, -2.0))
    assert CELL.height_m(3.0, 50.0) == pytest.approx(CELL.height_m(3.0, -1.0))
    assert CELL.height_m(99.0, 99.0) == 3.0


def test_many_places_at_once_are_as_one_by_one():
    relief, rng = hills(), np.random.default_rng(2)
    x, y = rng.uniform(-60.0, 60.0, (2, 5, 7))
    each = [
        [float(relief.height_m(a, b)) for a, b in zip(*row, strict=True)]
        for row in zip(x, y, strict=True)
    ]
    np.testing.assert_array_equal(relief.height_m(x, y), each)


def test_normals_are_those_of_the_surface():
    relief, rng = hills(), np.random.default_rng(3)
    x, y = rng.uniform(-39.0, 39.0, (2, 500))
    step_m = 1e-6
    east = (relief.height_m(x + step_m, y) - relief.height_m(x - step_m, y)) / (2 * step_m)
    north = (relief.height_m(x, y + step_m) - relief.height_m(x, y - step_m)) / (2 * step_m)
    normal = relief.normal_enu(x, y)
    np.testing.assert_allclose(-normal[:, 0] / normal[:, 2], east, atol=1e-6)
    np.testing.assert_allclose(-normal[:, 1] / normal[:, 2], north, atol=1e-6)
    assert relief.steepest >= np.hypot(east, north).max() - 1e-6


def test_without_a_relief_the_ground_is_at_zero():
    assert ground_m(None, 3.0, 4.0) == 0.0
    np.testing.assert_array_equal(ground_m(None, np.zeros((2, 1)), np.zeros(3)), np.zeros((2, 3)))


def test_a_scene_with_a_relief_survives_the_round_trip_and_equals_itself():
    scene = relief_scene(hills())
    again = scene_from_json(scene_to_json(scene))
    assert again == scene
    assert hash(again.relief) == hash(scene.relief)
    lower = Relief((-40.0, -40.0), 1.0, scene.relief.heights_m - 0.5)
    assert replace(scene, relief=lower) != scene
    assert b'"relief":' not in scene_to_json(replace(scene, relief=None))


def test_heights_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        CELL.heights_m[0, 0] = 1.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"heights": [[0, 1], [0]]}, "heights have rows of 1 to 2 numbers; valid: rows of equal"),
        ({"heights": [[0, 1]]}, "heights have 1 rows; valid: 2 to 512"),
        ({"heights": [[0], [1]]}, "heights have 1 columns; valid: 2 to 512"),
        ({"heights": []}, "heights have 0 rows; valid: 2 to 512"),
        ({"heights": [[0] * 513] * 2}, "relief.heights[0]: Expected `array` of length <= 512"),
        ({"heights": [[0, 0]] * 513}, "relief.heights: Expected `array` of length <= 512"),
        ({"heights": [[0, 201], [0, 0]]}, "heights[0][1] is 201.0; valid: a number from -200"),
        ({"heights": [[0, 1e300], [0, 0]]}, "heights[0][1] is 1e+300"),
        ({"heights": [[0, 0], [0, 900]], "spacing": 99}, "heights[1][1] is 900.0"),
        (
            {"heights": [[0, 0], [0, 60]], "spacing": 10},
            "heights rise by 80.5 degrees at heights[0",
        ),
        ({"spacing": 0}, "spacing is 0.0; valid: 0.1 to 100 m"),
        ({"origin": [0, 1e9]}, "origin is (0.0, 1000000000.0); valid: 2 numbers from -10000"),
        ({"origin": [-90, -200]}, "extent.x is (-100.0, 100.0); valid: within -90 to 310"),
        ({"heights": [[0] * 5] * 3}, "extent.y is (-100.0, 100.0); valid: within -200 to 0"),
        ({"heights": [[0] * 5] * 4 + [[-2] * 5]}, "extent.z is (0.0, 60.0); valid: min at most -2"),
        ({"heights": [[0] * 5] * 4 + [[99] * 5]}, "valid: min at most 0 and max above 99"),
        ({"heights": "high"}, "relief.heights: Expected `array`, got `str`"),
        ({"depth": 3}, "relief: Object contains unknown field `depth`"),
    ],
)
def test_a_bad_relief_is_refused_in_one_line(wrong, message):
    document = json.loads(scene_to_json(field_scene()))
    relief = {"origin": [-200, -200], "spacing": 100, "heights": [[0] * 5] * 5}
    assert scene_from_json(json.dumps(document | {"relief": relief})).relief is not None
    with pytest.raises(SceneError) as error:
        scene_from_json(json.dumps(document | {"relief": relief | wrong}))
    assert message in str(error.value)
    assert "\n" not in str(error.value)
