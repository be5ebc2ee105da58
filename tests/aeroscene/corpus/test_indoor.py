"""Floor plans, the buildings raised from them, and the indoor scenes that they become."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.indoor import compose_indoor, draw_plan
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.plans import START_M
from aeroscene.corpus.curation.indoor.themes import THEMES
from aeroscene.corpus.curation.indoor.walls import PARTITION_M, wall_spans
from aeroscene.corpus.curation.indoor.zones import (
    DOORS_M,
    PlanError,
    Zone,
    barrier,
    choose_doors,
    find_borders,
)
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.geometry import penetration_depth
from aeroscene.solids.freespace import build_distance_field, reachable
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.shapes.facade import WALL_M
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.sampling_solids import bounds

SAMPLE = (5, 11, 26, 44)
"""Indoor scenes: a hall, offices, a school of two storeys, apartments."""
FLIGHT_RADIUS_M = 0.45

plans = st.builds(
    lambda seed, theme: draw_plan(Draw(np.random.default_rng(seed)), theme),
    st.integers(0, 2**32 - 1),
    st.sampled_from(THEMES),
)


@pytest.fixture(params=SAMPLE, ids=lambda index: f"scene{index}")
def indoor(request: pytest.FixtureRequest) -> Scene:
    return cached_scene(request.param)


def _room(kind: str, x0: float, y0: float, x1: float, y1: float, role: str = "room") -> Zone:
    return Zone(
        kind=kind,
        role=role,
        x0=x0,
        y0=y0,
        x1=x1,
        y1=y1,
        level=0.15,
        clear=3.0,
    )


@given(plans)
@settings(max_examples=60, deadline=None)
def test_zones_of_a_storey_lie_side_by_side_inside_the_walls(plan):
    half_x, half_y = (length / 2 - WALL_M + 1e-9 for length in plan.size)
    for zone in plan.zones:
        assert -half_x <= zone.x0 < zone.x1 <= half_x
        assert -half_y <= zone.y0 < zone.y1 <= half_y
        assert zone.level + zone.clear <= plan.height + 1e-9
        assert zone.clear >= 3.3
    for a, b in itertools.combinations(plan.zones, 2):
        is_apart = (
            a.x1 <= b.x0 + 1e-9
            or b.x1 <= a.x0 + 1e-9
            or a.y1 <= b.y0 + 1e-9
            or b.y1 <= a.y0 + 1e-9
            or a.level >= b.level + b.clear
            or b.level >= a.level + a.clear
        )
        assert is_apart, (a, b)


@given(plans)
@settings(max_examples=60, deadline=None)
def test_every_room_has_exactly_one_door_towards_the_start(plan):
    zones = plan.zones
    borders = find_borders(zones)
    doors = choose_doors(zones, borders)
    assert set(doors.values()) <= set(DOORS_M)
    reached, is_growing = {0}, True
    while is_growing:
        before = len(reached)
        for index, border in enumerate(borders):
            is_passage = index in doors or barrier(zones, border) != "wall"
            if is_passage and reached & set(border.zones):
                reached |= set(border.zones)
        is_growing = len(reached) > before
    assert reached == set(range(len(zones)))
    assert len(doors) == sum(zone.role == "room" for zone in zones)
    for index, width in doors.items():
        assert borders[index].length >= width + 1.0


@given(plans)
@settings(max_examples=60, deadline=None)
def test_walls_meet_without_overlap_and_leave_no_gap(plan):
    borders = find_borders(plan.zones)
    spans = wall_spans(plan.zones, borders)
    half = PARTITION_M / 2
    rectangles = []
    for index, (low, high) in spans.items():
        border = borders[index]
        assert max(abs(low - border.low), abs(high - border.high)) <= half + 1e-9
        across, along = (border.at - half, border.at + half), (low, high)
        x, y = (across, along) if border.along == "y" else (along, across)
        rectangles.append((x, y, (border.base, border.top)))
    for a, b in itertools.combinations(rectangles, 2):
        shared = [min(p[1], q[1]) - max(p[0], q[0]) for p, q in zip(a, b, strict=True)]
        assert min(shared) < 1e-6, (a, b)


def test_a_plan_with_a_room_behind_no_door_is_refused():
    hall = _room("lobby", 0, 0, 10, 10, "hall")
    far = _room("office", 20, 0, 25, 5)
    borders = find_borders((hall, far))
    with pytest.raises(PlanError, match=r"zones \[1\] have no door"):
        choose_doors((hall, far), borders)


def test_wide_rooms_get_wide_doors():
    hall = _room("lobby", 0, 0, 10, 30, "hall")
    zones = (
        hall,
        _room("gym", 10, 0, 18, 9),
        _room("office", 10, 9, 15, 13),
        _room("store", 10, 13, 13, 16.5),
    )
    doors = choose_doors(zones, find_borders(zones))
    assert list(doors.values()) == [2.75, 2.25, 1.75]


def test_the_same_stream_gives_the_same_building():
    def objects() -> list[SceneObject]:
        builder = Builder("s")
        composition = compose_indoor(builder, np.random.default_rng(5))
        for growth in (composition.places[0].structures(), composition.places[0].details()):
            for _ in itertools.islice(growth, 40):
                pass
        return builder.objects

    assert objects() == objects()


@pytest.mark.parametrize("theme", THEMES, ids=lambda theme: theme.name)
def test_a_building_has_more_to_offer_than_any_scene_takes(theme, monkeypatch):
    monkeypatch.setattr("aeroscene.corpus.curation.composers.indoor.THEMES", (theme,))
    builder = Builder("s")
    composition = compose_indoor(builder, np.random.default_rng(11))
    (place,) = composition.places
    base = builder.n_coarse
    for _ in place.structures():
        pass
    assert base <= 50
    assert builder.n_coarse >= max(18, base)
    composition.place_start()
    counts = [builder.n_fine for _ in place.details()]
    assert counts[-1] >= 115
    steps = np.diff(counts)
    assert steps.max() <= 9
    assert np.mean(steps) <= 4


def test_the_walls_and_the_roof_bound_the_volume(indoor):
    shell = indoor.objects[0]
    assert shell.category in {"building", "warehouse"}
    low, high = np.array(indoor.extent_min_enu_m), np.array(indoor.extent_max_enu_m)
    corners = np.vstack([obj.bbox.corners() for obj in indoor.objects])
    assert np.all(corners >= low - 1e-3)
    assert np.all(corners <= high + 1e-3)
    roof = next(obj for obj in indoor.objects if obj.category == "roof")
    assert roof.bbox.p[2] + roof.bbox.s[2] / 2 == pytest.approx(high[2])
    assert min(high[:2] - low[:2]) >= 12
    assert max(high[:2] - low[:2]) <= 32


def test_the_flood_stays_inside_and_reaches_every_room(indoor):
    field = build_distance_field(indoor)
    flood = reachable(field, indoor.start_position_enu_m, FLIGHT_RADIUS_M)
    assert not flood[0].any()
    assert not flood[-1].any()
    assert not flood[:, 0].any()
    assert not flood[:, -1].any()
    assert not flood[:, :, -1].any()
    for room in (obj for obj in indoor.objects if obj.category == "room"):
        corners = room.bbox.corners()
        low, high = field.cell(tuple(corners.min(0) + 0.2)), field.cell(tuple(corners.max(0) - 0.3))
        assert low
        assert high
        inside = flood[low[0] : high[0] + 1, low[1] : high[1] + 1, low[2] : high[2] + 1]
        assert inside.mean() > 0.02, room


def test_the_start_hall_is_high_and_free(indoor):
    x, y, z = indoor.start_position_enu_m
    pad = next(obj for obj in indoor.objects if obj.attributes.get("is_start"))
    hall = indoor.object_by_id[pad.parent_id]
    assert hall.category == "room"
    assert hall.bbox.s[2] >= 4.5
    for primitive in scene_primitives(indoor):
        if not primitive.collides or primitive.object_id == pad.id:
            continue
        low, high = bounds(primitive)
        gap = np.maximum(np.maximum(low[:2] - (x, y), (x, y) - high[:2]), 0)
        is_above = high[2] > z + 0.01 and low[2] < z + 4.0
        assert not is_above or np.hypot(*gap) >= 3.0, primitive


def test_doors_are_as_wide_as_they_claim(indoor):
    solids = [p for p in scene_primitives(indoor) if p.collides]
    boxes = [bounds(p) for p in solids]
    walls = [obj for obj in indoor.objects if obj.attributes.get("door_m")]
    assert walls
    for wall in walls:
        width, head = wall.attributes["door_m"], wall.attributes["door_height_m"]
        assert width >= 1.6
        assert head >= 2.2
        yaw, (x, y, z) = wall.bbox.yaw_rad, wall.bbox.p
        offset = wall.attributes["door_offset_m"]
        middle = np.array([x - np.sin(yaw) * offset, y + np.cos(yaw) * offset])
        reach_u, reach_v = 0.5, width / 2 - 0.01
        c, s = abs(np.cos(yaw)), abs(np.sin(yaw))
        reach = np.array([c * reach_u + s * reach_v, s * reach_u + c * reach_v])
        foot = z - wall.bbox.s[2] / 2
        low = np.array([*(middle - reach), foot + 0.12])
        high = np.array([*(middle + reach), foot + min(head, 2.2) - 0.01])
        for solid, (a, b) in zip(solids, boxes, strict=True):
            assert np.any(a >= high) or np.any(b <= low), (wall, solid)


def test_nothing_overlaps_but_what_it_lies_in(indoor):
    objects = [obj for obj in indoor.objects if obj.is_coarse]
    p, q, s = (np.array([getattr(o.bbox, name) for o in objects]) for name in "pqs")
    first, second = np.triu_indices(len(objects), 1)
    depth = penetration_depth(p[first], q[first], s[first], p[second], q[second], s[second])
    for index in np.flatnonzero(depth > 0.02):
        a, b = objects[first[index]], objects[second[index]]
        assert a.id in indoor.ancestors(b.id) or b.id in indoor.ancestors(a.id), (a, b)


def test_areas_of_all_classes_are_found(indoor):
    classes = dict.fromkeys(("small", "medium", "large"), 0)
    for area in indoor.landing_areas:
        classes[area.drone_class] += 1
    assert classes["small"] >= 8
    assert classes["medium"] >= 4


def test_a_hall_keeps_open_floor_for_a_large_drone():
    halls = [theme for theme in THEMES if theme.programme.n_open]
    assert len(halls) >= 4
    for theme in halls:
        for seed in range(6):
            plan = draw_plan(Draw(np.random.default_rng(seed)), theme)
            assert any(zone.open_m >= 5.5 for zone in plan.zones), (theme.name, seed)


def test_the_start_hall_has_space_for_its_free_square():
    for theme in THEMES:
        for seed in range(20):
            plan = draw_plan(Draw(np.random.default_rng(seed)), theme)
            assert min(plan.zones[0].size) >= START_M + 0.3, (theme.name, seed)
            assert min(min(zone.size) for zone in plan.zones) >= 2.6
