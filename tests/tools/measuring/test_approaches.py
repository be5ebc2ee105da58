"""Approaches to everything: free flight comes to its contacts when it should."""

import numpy as np
from measuring.approaches import fly_approaches

from aeroscene.sources import load_scene
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world


def test_no_contact_is_missed_in_flight_at_solids_and_at_another_vehicle():
    iris, rng = airframe_by_name("iris"), np.random.default_rng(7)
    at_solids = fly_approaches(build_world(load_scene("42"), iris), 128, rng)
    assert len(set(at_solids.kind.tolist())) == 5
    at_vehicles = fly_approaches(build_world(load_scene("field"), iris, iris), 64, rng)
    for flown in (at_solids, at_vehicles):
        assert flown.is_contact.sum() > 40
        assert not flown.is_missed.any()
        assert flown.apart.max() < 1e-9
        assert flown.free_share > 0.1
