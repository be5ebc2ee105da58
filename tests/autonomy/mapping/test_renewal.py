"""Distances that are renewed about changes equal those that are computed for the whole map."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.mapping.rays import FREE_AT, MOST_FREE, MOST_OCCUPIED, OCCUPIED_AT
from autonomy.mapping.seen_map import UNSEEN_LACK, SeenMap
from autonomy.mapping.seen_map_cfg import SeenMapCfg
from tests.autonomy.mapping.whole import distance_to_marked

seeds = st.integers(0, 2**32 - 1)


def walled(marked, cfg):
    """Distances where all outside the volume is marked, too."""
    padded = np.pad(marked, 1, constant_values=True)
    return distance_to_marked(padded, cfg.resolution_m, cfg.cap_m)[1:-1, 1:-1, 1:-1]


def whole_route(evidence, cfg, needed_m):
    free = walled(evidence > FREE_AT, cfg)
    route = walled(evidence >= OCCUPIED_AT, cfg)
    comfortable_m = cfg.cap_m - UNSEEN_LACK * (cfg.cap_m - needed_m)
    is_unseen = (free < needed_m) & (route >= needed_m)
    return np.where(is_unseen, np.minimum(route, comfortable_m), route)


def change(seen, rng):
    """Change the evidence of some block of cells, as images and the vehicle's place do."""
    shape = np.array(seen.evidence.shape)
    low = rng.integers(0, shape)
    high = np.minimum(low + rng.integers(1, 12, 3), shape)
    part = seen.evidence[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    is_changed = rng.random(part.shape) < rng.choice([0.02, 0.3, 1.0])
    value = rng.choice([MOST_FREE, FREE_AT, 0, OCCUPIED_AT, MOST_OCCUPIED])
    part[is_changed] = value
    seen._change(np.array([low, high]))


@given(seeds)
def test_the_whole_is_the_distance_to_the_nearest_marked_cell(seed):
    rng = np.random.default_rng(seed)
    marked = rng.random(rng.integers(1, 12, 3)) < rng.uniform(0, 0.1)
    found = distance_to_marked(marked, 0.5, 1.5)
    cells, centres = np.argwhere(marked), np.argwhere(np.ones_like(marked))
    nearest = np.full(len(centres), np.inf)
    for cell in cells:
        gap = np.maximum(np.abs(centres - cell) - 0.5, 0.0)
        away = np.where(np.all(centres == cell, axis=1), 0.0, np.linalg.norm(gap, axis=1))
        nearest = np.minimum(nearest, 0.5 * away)
    np.testing.assert_allclose(found.ravel(), np.minimum(nearest, 1.5), atol=1e-6)


@pytest.mark.parametrize("resolution_m", [0.25, 0.5])
@given(seed=seeds)
@settings(max_examples=25)
def test_distances_renewed_about_random_changes_are_those_of_the_whole_map(resolution_m, seed):
    rng = np.random.default_rng(seed)
    cfg = SeenMapCfg(resolution_m=resolution_m)
    seen = SeenMap((0.0, 0.0, 0.0), tuple(rng.uniform(0.5, 10.0, 3)), cfg)
    if rng.random() < 0.5:
        seen.evidence[:] = MOST_FREE
        seen._change(np.array([(0, 0, 0), seen.evidence.shape]))
    needed_m = 0.55
    for _ in range(6):
        for _ in range(rng.integers(1, 4)):
            change(seen, rng)
        if rng.random() < 0.2:
            needed_m = rng.uniform(0.3, 1.0)
        block = seen.search_block(np.zeros(3, dtype=np.int64))
        route_m = seen.route_in(block, needed_m).distance_m
        free_m = walled(seen.evidence > FREE_AT, cfg)
        np.testing.assert_allclose(seen.field.distance_m, free_m, atol=1e-6)
        np.testing.assert_allclose(route_m, whole_route(seen.evidence, cfg, needed_m), atol=1e-6)
        layers = np.flatnonzero((seen.field.distance_m >= np.float32(needed_m)).any(axis=(0, 1)))
        assert seen.seen_room(block, needed_m).top == (layers[-1] if len(layers) else -1)


def test_cells_that_no_image_showed_are_not_touched():
    seen = SeenMap((0.0, 0.0, 0.0), (40.0, 40.0, 10.0))
    seen.route_in(seen.search_block(np.zeros(3, dtype=np.int64)), 0.5)
    untouched = seen._distances.to_not_free
    untouched[60:] = np.nan
    seen.evidence[10:20, 10:20, 10:20] = MOST_FREE
    seen._change(np.array([(10, 10, 10), (20, 20, 20)]))
    assert np.all(np.isnan(seen.field.distance_m[60:]))
    assert np.max(seen.field.distance_m[:60]) > 0.5
