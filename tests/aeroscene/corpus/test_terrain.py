from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Parcel
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.terrain import Slope, raise_terrace


def open_ground(rise: float, yaw: float = 0.4, width: float = 20.0, depth: float = 12.0) -> Ground:
    parcel = Parcel(Frame(3.0, -2.0, yaw), width, depth, level=0.5, rise=rise)
    return Ground(Builder("s"), Draw(np.random.default_rng(1)), parcel)


@settings(max_examples=40)
@given(st.floats(-6, 6), st.floats(3, 9), st.floats(-3.2, 3.2), st.floats(0.3, 2.0))
def test_what_stands_on_a_slope_stands_at_the_lowest_point_of_its_outline(u, v, turn, rise):
    ground = open_ground(rise)
    ground.cover("lawn")
    placed = ground.stand("crate", u, v, (1.2, 0.8, 1.0), turn=turn)
    assert placed
    box = ground.builder.objects[-1].bbox
    corners = [ground.parcel.frame.local(*corner[:2])[1] for corner in box.corners()]
    surface = ground.parcel.level + rise * min(corners) / ground.parcel.depth
    assert placed.base == pytest.approx(surface, abs=1e-4)
    assert ground.builder.objects[-1].parent_id == ground.builder.objects[0].id


def test_a_fence_climbs_a_slope_in_pieces_that_each_stand_on_it():
    ground = open_ground(1.5)
    ground.cover("lawn")
    ground.fence_line((-5.0, 1.0), (-5.0, 11.0), "boards", 1.2)
    feet = [o.bbox.p[2] - o.bbox.s[2] / 2 for o in ground.builder.objects if o.category == "fence"]
    assert len(feet) >= 3
    assert np.all(np.diff(feet) > 0.1)


def test_a_terrace_lifts_its_parcel_and_stairs_reach_it():
    for seed in range(8):
        builder = Builder("s")
        parcel = Parcel(Frame(0.0, 0.0, 0.7), 24.0, 24.0)
        lifted = raise_terrace(builder, Draw(np.random.default_rng(seed)), parcel)
        stairs = next(o for o in builder.objects if o.category == "stairs")
        assert lifted.level >= 0.5
        assert lifted.bearer
        assert lifted.bearer.top == pytest.approx(lifted.level)
        assert stairs.bbox.p[2] + stairs.bbox.s[2] / 2 == pytest.approx(lifted.level, abs=1e-3)
        back = parcel.frame.point(0, parcel.depth)
        assert lifted.frame.point(0, lifted.depth) == pytest.approx(back)


def test_a_shallow_parcel_stays_at_the_street():
    parcel = Parcel(Frame(0.0, 0.0, 0.0), 24.0, 15.0)
    builder = Builder("s")
    assert raise_terrace(builder, Draw(np.random.default_rng(0)), parcel) is parcel
    assert not builder.objects


def test_a_slope_grows_trees_that_belong_to_it():
    ground = open_ground(1.6)
    slope = Slope(ground)
    for growth in (slope.structures(), slope.details()):
        for _ in growth:
            pass
    trees = [o for o in ground.builder.objects if o.category == "tree"]
    assert trees
    assert {o.parent_id for o in trees} == {0}
