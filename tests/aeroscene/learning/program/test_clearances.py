"""Units keep from their own what training keeps, as far as there is room."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.curation import curate_scene
from aeroscene.learning.program import decode, encode
from aeroscene.learning.program.clearances import Clearances, gaps_between, measure_clearances
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw


def box(x_m, y_m, yaw_rad=0.0, z_m=0.5):
    return OrientedBox((x_m, y_m, z_m), quat_from_yaw(yaw_rad), (2.0, 1.0, 1.0))


@pytest.mark.parametrize("turn_rad", [0.0, 0.7, math.pi / 2])
def test_gaps_are_seen_from_each_box(turn_rad):
    def seen(x_m, y_m, yaw_rad=0.0, z_m=0.5):
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        return box(c * x_m - s * y_m, s * x_m + c * y_m, turn_rad + yaw_rad, z_m)

    units = [[seen(0, 0)], [seen(5, 0.2)], [seen(0.5, 3)], [seen(0, -1.5, z_m=4)]]
    gaps = gaps_between(units)
    np.testing.assert_allclose(gaps[0], [3.0, 2.0], atol=1e-9)
    np.testing.assert_allclose(gaps[1], [3.0, np.nan], atol=1e-9)
    assert np.isnan(gaps[3]).all()
    lengthwise = gaps_between([[seen(0, 0)], [seen(0, 4, math.pi / 2)]])
    np.testing.assert_allclose(lengthwise, [[np.nan, 2.5], [2.5, np.nan]], atol=1e-9)


def test_members_of_a_unit_are_no_gap():
    assert np.isnan(gaps_between([[box(0, 0), box(3, 0)], [box(40, 40)]])).all()


def test_what_is_kept_is_what_all_but_a_twentieth_keep():
    gaps = np.column_stack([np.linspace(0.0, 10.0, 101), np.full(101, np.nan)])
    known = measure_clearances([{"bench": gaps[:50]}, {"bench": gaps[50:], "bin": gaps[:19]}])
    assert known.of("bench") == (pytest.approx(0.5), 0.0)
    assert known.of("bin") == known.of("car") == (0.0, 0.0)
    assert measure_clearances([{"bench": gaps + 20}]).of("bench") == (3.0, 0.0)


@pytest.mark.parametrize("seed", [4, 10])
def test_units_go_apart_where_there_is_room_and_nothing_else_moves(seed):
    program = encode(curate_scene(seed)).program
    plain = decode(program).scene
    apart = decode(replace(program, clearances=Clearances({"bush": (1.5, 1.5)}))).scene

    def n_near(found):
        return int((encode(found).gaps["bush"] < 1.4).any(axis=1).sum())

    assert n_near(apart) < n_near(plain)
    pairs = list(zip(plain.objects, apart.objects, strict=True))
    assert {own.category for own, other in pairs if own != other} == {"bush"}
