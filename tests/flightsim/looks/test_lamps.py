import numpy as np
import pytest

from flightsim.looks.lamps import Lamps

UP = np.array([0.0, 0.0, 1.0])


def street_lamps(*places):
    places = np.array(places, dtype=float).reshape(-1, 3)
    return Lamps(places, places[:, 2])


def test_light_falls_off_with_distance_and_ends():
    points = np.column_stack([np.linspace(0, 20, 41), np.zeros((41, 2))])
    light = street_lamps((0, 0, 5)).light_at(points, np.broadcast_to(UP, points.shape))
    assert 0.6 < light[0] < 1.3
    assert (np.diff(light[:29]) < 0).all()
    assert (light[np.linalg.norm(points - (0, 0, 5), axis=1) > 15.0] == 0).all()


def test_lamps_add_up_and_headlights_are_weaker():
    points = np.array([[0.0, 0.0, 0.0]])
    one, two = street_lamps((3, 0, 5)), street_lamps((3, 0, 5), (-3, 0, 5))
    assert two.light_at(points, UP[None]) == pytest.approx(2 * one.light_at(points, UP[None]))
    low = Lamps(np.array([[0.0, 0.0, 0.7]]), np.array([0.7]))
    high_up = Lamps(np.array([[0.0, 0.0, 0.7]]), np.array([5.0]))
    assert low.light_at(points, UP[None]) < 0.5 * high_up.light_at(points, UP[None])


def test_pools_cover_the_face_about_a_lamp_once():
    face = np.array([(-4, -4, 0), (6, -4, 0), (6, 5, 0), (-4, 5, 0)], dtype=float)
    lamps = street_lamps((0, 0, 5), (3, 0, 5))
    index, corners = lamps.pools([face])
    assert set(index) == {0}
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(u, v)
    assert (normals[:, 2] > 0).all()
    assert normals[:, 2].sum() / 2 == pytest.approx(90.0, rel=0.02)


def test_no_lamp_and_no_face_have_no_pools():
    face = np.array([(-4, -4, 0), (6, -4, 0), (6, 5, 0), (-4, 5, 0)], dtype=float)
    for lamps, faces in ((street_lamps(), [face]), (street_lamps((0, 0, 5)), [])):
        index, corners = lamps.pools(faces)
        assert len(index) == len(corners) == 0
    # A roof over the lamp gets none.
    index, _ = street_lamps((0, 0, 5)).pools([face + (0, 0, 6)])
    assert len(index) == 0
