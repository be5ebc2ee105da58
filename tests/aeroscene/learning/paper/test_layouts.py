"""Scenes as the paper's lists, on flat ground: their order, regions and symmetries."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.landform import level
from aeroscene.learning.paper.channels import frames_of, measure, measured_channels
from aeroscene.learning.paper.layouts import (
    IS_TWO_SIDED,
    NO_REGION,
    QUARTER_RAD,
    flat_layout,
    quarter_turns,
    random_symmetry,
    turned,
)
from aeroscene.learning.wishes import Wish
from aeroscene.scene import OrientedBox, Scene
from aeroscene.scene.catalogue import CATALOGUE


@pytest.fixture(name="scenes")
def flat_scenes(scenes: list[Scene]) -> list[Scene]:
    return [level(scene) for scene in scenes]


@pytest.fixture(name="scene_42")
def flat_scene(scene_42: Scene) -> Scene:
    return level(scene_42)


def by_number(name: str) -> int:
    return next(number for number, category in CATALOGUE.items() if category.name == name)


def test_a_list_has_every_box_coarse_ones_first(scenes: list[Scene]) -> None:
    for scene in scenes:
        layout = flat_layout(scene, Wish.from_scene(scene), has_regions=True)
        assert layout.is_coarse.sum() == layout.n_coarse == sum(o.is_coarse for o in scene.objects)
        places = turned(layout.center_enu_m, layout.site_yaw_rad)
        listed = np.column_stack([layout.category, layout.size_m, places])
        there = np.array([(o.category_id, *o.bbox.s, *o.bbox.p) for o in scene.objects])
        np.testing.assert_allclose(_in_order(listed), _in_order(there), atol=1e-6)


def test_regions_are_the_nearest_coarse_ancestors(scene_42: Scene) -> None:
    layout = flat_layout(scene_42, Wish.from_scene(scene_42), has_regions=True)
    by_id = {obj.id: obj for obj in scene_42.objects}
    places = turned(layout.center_enu_m, layout.site_yaw_rad)
    place_of = {tuple(np.round(p, 4)): row for row, p in enumerate(places)}
    for obj in scene_42.objects:
        if obj.is_coarse:
            continue
        above = by_id.get(obj.parent_id)
        while above is not None and not above.is_coarse:
            above = by_id.get(above.parent_id)
        row = place_of[tuple(np.round(obj.bbox.p, 4))]
        region = layout.region[row]
        if above is None:
            assert region == NO_REGION
        else:
            place = turned(layout.center_enu_m[[region]], layout.site_yaw_rad)[0]
            assert place == pytest.approx(above.bbox.p)


def test_lists_of_the_one_chain_know_no_regions(scene_42: Scene) -> None:
    layout = flat_layout(scene_42, Wish.from_scene(scene_42), has_regions=False)
    assert (layout.region == NO_REGION).all()
    fine = layout.category[layout.n_coarse :]
    assert (np.diff(fine) >= 0).all()


def test_symmetries_keep_distances_regions_and_the_order(scenes: list[Scene]) -> None:
    rng = np.random.default_rng(0)
    for scene in scenes:
        layout = flat_layout(scene, Wish.from_scene(scene), has_regions=True)
        region_m = _to_regions(layout)
        for _ in range(8):
            other = random_symmetry(layout, rng)
            assert (np.diff(other.category[: other.n_coarse]) >= 0).all()
            assert sorted(_to_regions(other)) == pytest.approx(sorted(region_m), abs=1e-9)
            assert sorted(other.half_m) == pytest.approx(sorted(layout.half_m))
            reach = np.abs(other.center_enu_m[:, :2]).max(axis=0)
            assert (reach <= other.half_m + 1e-9).all()


def test_alike_objects_stand_in_order_from_right_to_left(scenes: list[Scene]) -> None:
    rng = np.random.default_rng(0)
    for scene in scenes:
        layout = random_symmetry(flat_layout(scene, Wish.from_scene(scene), has_regions=True), rng)
        statistics = measure([layout], has_regions=True)
        frames = frames_of(layout, statistics)
        channels, turn = measured_channels(layout, frames)
        x_m, y_m = (channels[:, :2] * frames.half_m).T
        left_m = np.cos(turn * QUARTER_RAD) * y_m - np.sin(turn * QUARTER_RAD) * x_m
        groups = list(zip(layout.is_coarse, layout.region, layout.category, turn, strict=True))
        for i, (one, two) in enumerate(itertools.pairwise(groups)):
            if one == two:
                assert left_m[i] <= left_m[i + 1] + 0.02
        assert len(set(groups)) == 1 + sum(a != b for a, b in itertools.pairwise(groups))


def _in_order(rows: np.ndarray) -> np.ndarray:
    """Rows sorted by their first column that differs, to a millimetre."""
    return rows[np.lexsort(np.round(rows, 3).T[::-1] + 0.0)]


def _to_regions(layout) -> list[float]:
    inside = np.flatnonzero(layout.region != NO_REGION)
    apart = layout.center_enu_m[inside] - layout.center_enu_m[layout.region[inside]]
    return np.linalg.norm(apart, axis=1).tolist()


@given(st.floats(-20, 20), st.booleans())
def test_a_quarter_turn_and_its_rest_are_the_heading(yaw_rad: float, is_two_sided: bool) -> None:
    turn, rest_rad = quarter_turns(np.array([yaw_rad]), np.array([is_two_sided]))
    assert abs(rest_rad[0]) <= QUARTER_RAD / 2 + 1e-9
    assert 0 <= turn[0] < (2 if is_two_sided else 4)
    period = np.pi if is_two_sided else 2 * np.pi
    away = (turn[0] * QUARTER_RAD + rest_rad[0] - yaw_rad) / period
    assert away == pytest.approx(round(away), abs=1e-9)


def test_a_wall_is_two_sided_and_a_chair_is_not() -> None:
    assert IS_TWO_SIDED[by_number("wall")]
    assert not IS_TWO_SIDED[by_number("chair")]
    assert not IS_TWO_SIDED[0]


def test_a_turned_site_is_the_same_layout_but_for_its_yaw(scene_42: Scene) -> None:
    straight = flat_layout(scene_42, Wish.from_scene(scene_42), has_regions=True)
    for yaw_rad in (0.3, -0.7):
        objects = tuple(replace(o, bbox=_turned(o.bbox, yaw_rad)) for o in scene_42.objects)
        other = replace(scene_42, objects=objects, interaction_areas=())
        layout = flat_layout(other, Wish.from_scene(other), has_regions=True)
        away_rad = (layout.site_yaw_rad - straight.site_yaw_rad - yaw_rad) / QUARTER_RAD
        assert away_rad == pytest.approx(round(away_rad), abs=1e-6)
        quarters = round(away_rad) % 4
        expected = straight.center_enu_m
        for _ in range((4 - quarters) % 4):
            expected = turned(expected, QUARTER_RAD)
        found = sorted(map(tuple, np.round(layout.center_enu_m, 3) + 0.0))
        np.testing.assert_allclose(
            found, sorted(map(tuple, np.round(expected, 3) + 0.0)), atol=2e-3
        )
        back = turned(layout.center_enu_m, layout.site_yaw_rad)
        there = sorted(tuple(np.round(o.bbox.p, 3) + 0.0) for o in other.objects)
        np.testing.assert_allclose(sorted(map(tuple, np.round(back, 3) + 0.0)), there, atol=2e-3)


def _turned(box: OrientedBox, yaw_rad: float) -> OrientedBox:
    w, x, y, z = box.q
    cos, sin = np.cos(yaw_rad / 2), np.sin(yaw_rad / 2)
    place = turned(np.array([box.p]), yaw_rad)[0]
    q = (cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w)
    return replace(box, p=tuple(place.tolist()), q=tuple(float(v) for v in q))
