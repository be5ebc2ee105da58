"""Movers and wind in a recording, as they were in the flight."""

import numpy as np

from flightsim.environment.motion import new_movers, place_mover
from flightsim.environment.traffic import TrafficCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.recording import layout


def test_a_mover_is_recorded_where_it_was(flight, contents):
    entity = layout.mover("drone_0")
    times_us, translations = contents.column(entity, "Transform3D:translation")
    assert np.all(np.diff(times_us) == 20_000)
    assert times_us[-1] == flight.history["time_us"][-1]
    cfg = TrafficCfg(drones=1, seed=5)
    movers, points = new_movers(build_world(flight.scene, AIRFRAMES["iris"], traffic=cfg).obstacles)
    for time_us, translation in zip(times_us[::40], translations[::40], strict=True):
        place_mover(movers[0], points, time_us * 1e-6, 1.0)
        np.testing.assert_allclose(translation[0], movers["position_enu_m"][0], atol=1e-4)


def test_a_mover_has_a_shape_in_colour(contents):
    _, vertices = contents.column(layout.mover("drone_0"), "Mesh3D:vertex_positions")
    _, colours = contents.column(layout.mover("drone_0"), "Mesh3D:vertex_colors")
    assert len(vertices[0]) == len(colours[0]) > 100
    assert np.ptp(np.array(vertices[0])[:, 2]) < 0.25
    assert len(set(colours[0])) > 1


def test_the_air_is_recorded(contents):
    _, wind = contents.column(layout.WIND, "Scalars:scalars")
    np.testing.assert_allclose(wind[-1], (2.0, 0.0, 0.0), atol=1e-9)
