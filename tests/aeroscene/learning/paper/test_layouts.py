"""Scenes as the paper's lists: their order, their regions, their symmetries."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.layouts import (
    IS_TWO_SIDED,
    NO_REGION,
    QUARTER_RAD,
    flat_layout,
    quarter_turns,
    random_symmetry,
)
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import CATALOGUE


def by_number(name: str) -> int:
    return next(number for number, category in CATALOGUE.items() if category.name == name)


def test_a_list_has_every_box_coarse_ones_first(scenes: list[Scene]) -> None:
    for scene in scenes:
        layout = flat_layout(scene, Wish.of(scene), has_regions=True)
        assert layout.is_coarse.sum() == layout.n_coarse == sum(o.is_coarse for o in scene.objects)
        listed = sorted(
            (int(c), *np.round(p, 4), *np.round(s, 4))
            for c, p, s in zip(layout.category, layout.center_enu_m, layout.size_m, strict=True)
        )
        there = sorted(
            (o.category_id, *np.round(o.bbox.p, 4), *np.round(o.bbox.s, 4)) for o in scene.objects
        )
        assert listed == there


def test_regions_are_the_nearest_coarse_ancestors(scene_42: Scene) -> None:
    layout = flat_layout(scene_42, Wish.of(scene_42), has_regions=True)
    by_id = {obj.id: obj for obj in scene_42.objects}
    place_of = {tuple(np.round(p, 4)): row for row, p in enumerate(layout.center_enu_m)}
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
            assert layout.center_enu_m[region] == pytest.approx(above.bbox.p)


def test_lists_of_the_one_chain_know_no_regions(scene_42: Scene) -> None:
    layout = flat_layout(scene_42, Wish.of(scene_42), has_regions=False)
    assert (layout.region == NO_REGION).all()
    fine = layout.category[layout.n_coarse :]
    assert (np.diff(fine) >= 0).all()


def test_symmetries_keep_distances_regions_and_the_order(scenes: list[Scene]) -> None:
    rng = np.random.default_rng(0)
    for scene in scenes:
        layout = flat_layout(scene, Wish.of(scene), has_regions=True)
        region_m = _to_regions(layout)
        for _ in range(8):
            other = random_symmetry(layout, rng)
            assert (np.diff(other.category[: other.n_coarse]) >= 0).all()
            assert sorted(_to_regions(other)) == pytest.approx(sorted(region_m), abs=1e-9)
            assert sorted(other.half_m) == pytest.approx(sorted(layout.half_m))
            reach = np.abs(other.center_enu_m[:, :2]).max(axis=0)
            assert (reach <= other.half_m + 1e-9).all()


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
