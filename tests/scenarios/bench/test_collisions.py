"""Random collisions between two vehicles."""

from itertools import islice

import numpy as np
import pytest

from aeroscene.sources import load_scene
from flightsim.vehicles import airframe_by_name
from flightsim.vehicles.contact_filter import VEHICLE_CONTACT_BIT
from flightsim.world import build_world
from scenarios.bench.collisions import Collider


def collisions(world, n):
    return list(islice(Collider(world, np.random.default_rng(7)).collide(), n))


@pytest.mark.parametrize("names", [("iris", "iris"), ("iris", "hummingbird")])
def test_no_vehicle_passes_through_another(names):
    world = build_world(load_scene("field"), *map(airframe_by_name, names))
    found = collisions(world, 25)
    assert len(found) == 25
    assert not any(each.passes_through for each in found)
    assert max(each.speed_mps for each in found) > 15.0


def test_vehicles_without_shapes_for_each_other_are_found_to_pass():
    world = build_world(load_scene("field"), *[airframe_by_name("iris")] * 2)
    model = world.model
    model.geom_contype[model.geom_contype == VEHICLE_CONTACT_BIT] = 0
    model.geom_conaffinity[model.geom_conaffinity == VEHICLE_CONTACT_BIT] = 0
    model.body_conaffinity[1:] = 0
    found = collisions(world, 5)
    assert all(each.passes_through for each in found)
