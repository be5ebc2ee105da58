"""A large scene's field has the same distances as a whole one, where it was asked for."""

import numpy as np
import pytest

from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.wide_field import WideField, is_wide
from aeroscene.sources import load_scene


@pytest.mark.parametrize("name", ["42", "hills"])
def test_tiles_have_the_distances_of_the_whole_field(name):
    scene = load_scene(name)
    primitives = scene_primitives(scene)
    wide = WideField(scene, 0.5, primitives)
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    wide.build_about(np.linspace(low, (low + high) / 2, 20), 1.0)
    assert 0.0 < wide.is_built.mean() < 0.6
    whole = build_distance_field(scene, 0.5, primitives).distance_m
    is_built = np.repeat(np.repeat(wide.is_built, 32, axis=0), 32, axis=1)
    is_built = is_built[: whole.shape[0], : whole.shape[1]]
    assert np.array_equal(wide.field.distance_m[is_built], whole[is_built])
    assert not wide.field.distance_m[~is_built].any()


def test_every_tile_within_reach_of_a_point_is_computed(scene_42):
    wide = WideField(scene_42, 0.5, scene_primitives(scene_42))
    low, high = np.array(scene_42.extent_min_enu_m), np.array(scene_42.extent_max_enu_m)
    point, reach_m = (low + high) / 2, 9.0
    wide.build_about(point[None], reach_m)
    cells = np.argwhere(np.ones(wide.field.distance_m.shape[:2]))
    away_m = np.hypot(*(cells * 0.5 + wide.field.origin_enu_m[:2] - point[:2]).T)
    assert wide.is_built[tuple(cells[away_m <= reach_m].T // 32)].all()


def test_a_second_request_adds_to_the_first(scene_42):
    wide = WideField(scene_42, 0.5, scene_primitives(scene_42))
    low = np.array(scene_42.extent_min_enu_m)
    wide.build_about(low[None], 0.0)
    first = wide.field.distance_m.copy()
    wide.build_about(np.array([scene_42.extent_max_enu_m]) - 0.1, 0.0)
    assert wide.is_built[0, 0]
    assert wide.is_built[-1, -1]
    assert wide.is_built.mean() < 0.3
    assert np.array_equal(wide.field.distance_m[:32, :32], first[:32, :32])


def test_scenes_that_ship_are_not_wide(scene_42):
    assert not is_wide(scene_42, 0.25)
