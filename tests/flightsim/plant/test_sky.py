"""Satellites: as many as there are, hidden by what stands in the way, with the accuracy left."""

import math

import numpy as np
import pytest

from flightsim.environment.constellation import (
    BEIDOU,
    GALILEO,
    GPS,
    MASK_RAD,
    satellite_directions_enu,
)
from flightsim.environment.effects import Effects
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, solid

IRIS = AIRFRAMES["iris"]
TIMES_S = np.arange(0.0, 86_400.0, 600.0)
WALL = solid("box", (0.0, -3.5, 25.0), (80.0, 1.0, 50.0))
"""South of the start."""
CANYON = [solid("box", (0.0, y, 6.0), (120.0, 1.0, 12.0)) for y in (-8.5, 8.5)]
"""Walls of 12 m, 8 m to both sides of the start."""
LID = solid("box", (0.0, 0.0, 6.5), (40.0, 40.0, 1.0))


def plant_in(*solids, **cfg):
    return Plant(build_world(empty_scene(), IRIS, extra=solids), PlantCfg(**{"seed": 3} | cfg))


def fixes(plant, seconds=20.0):
    rows = []
    for _ in range(round(50 * seconds)):
        plant.advance()
        gnss = plant.sensors.gnss
        if gnss.fix_type > 1 and (not rows or gnss.time_us != rows[-1][0]):
            rows.append((gnss.time_us, *gnss.position_enu_m))
    return np.array(rows)


@pytest.mark.parametrize("system", [GPS, GALILEO, BEIDOU])
def test_a_receiver_sees_the_share_of_the_sky_above_its_mask(system):
    """Evenly spread over the sphere: (1 - cos psi) / 2 of all, psi the angle at the Earth's centre.

    Inclined orbits are denser in mid latitudes and leave the poles empty, about 10% either way.
    """
    seen = [len(satellite_directions_enu((system,), 47.4, t)) for t in TIMES_S]
    psi = math.pi / 2 - MASK_RAD - math.asin(6.371e6 / system.radius_m * math.cos(MASK_RAD))
    assert np.mean(seen) == pytest.approx(24 * 0.5 * (1.0 - math.cos(psi)), rel=0.15)
    assert min(seen) >= 4


def test_satellites_stand_above_the_mask_and_none_near_the_pole_of_the_sky():
    """At 47 degrees north the orbits, inclined by 55, leave a hole in the north."""
    directions = np.concatenate([satellite_directions_enu((GPS,), 47.4, t) for t in TIMES_S])
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    elevation, azimuth = np.arcsin(directions[:, 2]), np.arctan2(directions[:, 0], directions[:, 1])
    assert elevation.min() > MASK_RAD
    assert elevation.max() > math.radians(85.0)
    is_north = np.abs(azimuth) < math.radians(20.0)
    assert elevation[is_north].min() > math.radians(10.0)
    assert np.mean(is_north) < 0.5 * 40.0 / 360.0


def test_under_the_whole_sky_nothing_is_lost():
    plant = plant_in()
    fixes(plant, 1.0)
    sky = plant._record["sky"]
    assert plant.sensors.gnss.n_satellites == sky["n"] > 15
    assert sky["horizontal"] == sky["vertical"] == 1.0


def test_a_wall_hides_the_satellites_behind_it():
    plant = plant_in(WALL)
    fixes(plant, 2.0)
    sky = plant._record["sky"]
    directions = sky["direction_enu"][: sky["n"]]
    # The wall's face at 3 m, its top at 50 m and its ends at 40 m, seen from near the ground.
    south = -directions[:, 1]
    t = np.where(south > 1e-9, 3.0 / np.maximum(south, 1e-9), np.inf)
    with np.errstate(invalid="ignore"):
        is_hidden = (t * directions[:, 2] < 49.8) & (np.abs(t * directions[:, 0]) < 39.9)
    assert 3 <= is_hidden.sum() < sky["n"] - 3
    np.testing.assert_array_equal(sky["is_heard"][: sky["n"]], ~is_hidden)
    assert plant.sensors.gnss.n_satellites == (~is_hidden).sum()


def test_dilution_is_that_of_the_satellites_left():
    plant = plant_in(WALL)
    fixes(plant, 2.0)
    sky = plant._record["sky"]

    def dilution(directions):
        h = np.column_stack([directions, np.ones(len(directions))])
        q = np.diag(np.linalg.inv(h.T @ h))
        return math.sqrt(q[0] + q[1]), math.sqrt(q[2])

    everything = sky["direction_enu"][: sky["n"]]
    few = dilution(everything[sky["is_heard"][: sky["n"]] == 1])
    whole = dilution(everything)
    assert sky["horizontal"] == pytest.approx(max(1.0, few[0] / whole[0]))
    assert sky["vertical"] == pytest.approx(max(1.0, few[1] / whole[1]))
    assert sky["horizontal"] > 1.1


def test_a_canyon_makes_fixes_worse_and_the_receiver_says_so():
    open_sky, canyon = plant_in(gnss="standard"), plant_in(*CANYON, gnss="standard")
    spread = [np.diff(fixes(plant)[:, 1:], axis=0).std() for plant in (open_sky, canyon)]
    assert spread[1] > 2.0 * spread[0]
    assert canyon.sensors.gnss.eph_m > 1.5 * open_sky.sensors.gnss.eph_m


def test_multipath_comes_with_the_walls_and_can_be_left_out():
    with_it, without = (
        plant_in(WALL, gnss="standard", effects=Effects.without(names))
        for names in ("", "multipath")
    )
    fixes(with_it, 3.0)
    fixes(without, 3.0)
    assert with_it._record["gnss"]["multipath_now_sigma_m"][0] > 0.5
    assert without._record["gnss"]["multipath_now_sigma_m"][0] == 0.0


def test_below_a_roof_there_is_no_fix_and_without_the_effect_there_is():
    assert len(fixes(plant_in(LID), 3.0)) == 0
    assert len(fixes(plant_in(LID, effects=Effects.without("sky")), 3.0)) > 5
