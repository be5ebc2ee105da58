"""Towns of the corpus: rows without gaps, ground that is built up, streets that wind."""

import math
from itertools import pairwise

import numpy as np
import pytest

from aeroscene.corpus.curation import curate_layout
from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Parcel
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.rows import Fronts, cut_fronts, raise_row
from aeroscene.corpus.curation.sites import Scale, lay_out_site
from aeroscene.metrics.places.fulness import built_shares
from aeroscene.metrics.places.top_view import TopView

FRONTS = Fronts(width_m=9.0, least_m=6.2, storeys=(2, 4))


def parcel(seed, width_m=37.37):
    """A parcel whose borders lie on no whole centimetres, turned off the axes."""
    frame = Frame(1.23456, -7.65432, 0.4321)
    ground = Ground(
        Builder("town"), Draw(np.random.default_rng(seed)), Parcel(frame, width_m, 20.0)
    )
    ground.cover("lawn")
    return ground


@pytest.mark.parametrize("is_even", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_a_row_stands_wall_to_wall_and_none_is_left_out(seed, is_even):
    ground = parcel(seed)
    low, high = -ground.parcel.width / 2 + 0.6, ground.parcel.width / 2 - 0.6
    row = raise_row(ground, (low, high), 2.5, 9.0, FRONTS, is_even=is_even)
    spans = sorted(
        (at - house.size[1] / 2, at + house.size[1] / 2)
        for house in row
        for at, _ in [ground.parcel.frame.local(house.frame.x, house.frame.y)]
    )
    assert len(row) > 2
    assert spans[0][0] == pytest.approx(low, abs=0.01)
    assert spans[-1][1] == pytest.approx(high, abs=0.08)
    for (_, end), (begin, _) in pairwise(spans):
        assert begin == pytest.approx(end, abs=2e-3)


@pytest.mark.parametrize("length_m", [6.2, 11.0, 25.37, 60.0])
def test_fronts_fill_a_length_in_whole_centimetres(length_m):
    widths = cut_fronts(parcel(0), length_m, FRONTS, is_even=False)
    assert sum(widths) == pytest.approx(length_m)
    assert min(widths) >= FRONTS.least_m - 1e-9
    assert all(abs(100 * width - round(100 * width)) < 1e-6 for width in widths)


def test_a_length_below_the_narrowest_front_has_none():
    assert cut_fronts(parcel(0), 6.0, FRONTS, is_even=False) == []


def test_towns_are_built_up():
    layouts = [curate_layout(number) for number in range(1, 120, 3)]
    shares = np.concatenate([built_shares(TopView(layout)) for layout in layouts])
    assert len(shares) >= 10
    # 34% in these. Shallow rows of 7 m bring 30%, sites of 70 m and more 31%.
    assert 0.325 < np.mean(shares) < 0.5


def test_some_streets_bend_one_way_and_then_the_other():
    turns = []
    for seed in range(20):
        site = lay_out_site(Builder("s"), np.random.default_rng(seed), "curve", Scale())
        headings = [road.placed.frame.yaw for road in site.roads]
        turns.append(np.sign(np.round(np.diff(np.unwrap(headings)), 6)))
    assert all(np.all(each != 0) for each in turns)
    n_double = sum(len(set(each.tolist())) == 2 for each in turns)
    assert 3 <= n_double <= 17


def test_the_pieces_of_a_winding_street_meet():
    for seed in range(8):
        site = lay_out_site(Builder("s"), np.random.default_rng(seed), "curve", Scale())
        for first, second in pairwise(site.roads):
            end = first.placed.frame.point(first.placed.size[0] / 2, 0.0)
            begin = second.placed.frame.point(-second.placed.size[0] / 2, 0.0)
            # Each reaches over the bend, so that both ends lie beside the corner.
            assert math.dist(end, begin) < site.road_m
