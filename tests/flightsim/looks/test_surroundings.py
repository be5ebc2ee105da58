import numpy as np
import pytest

from flightsim.looks.mesh import MeshBuilder
from flightsim.looks.surfaces import FAST, FINE
from flightsim.looks.surroundings import add_surroundings
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, hills, relief_scene


def ground(reach_m=500.0):
    builder = MeshBuilder()
    add_surroundings(builder, empty_scene(), reach_m)
    return builder.mesh()


def test_ground_is_flat_and_has_no_gap_and_no_fold():
    mesh = ground()
    assert (mesh.vertices_enu_m[:, 2] == 0).all()
    corners = mesh.corners_enu_m()
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (across[:, 2] > 0).all()
    # Each border of two triangles is there once in each direction, but for the outer rim.
    at = {tuple(p): k for k, p in enumerate(np.unique(mesh.vertices_enu_m, axis=0).tolist())}
    number = np.array([at[tuple(p)] for p in mesh.vertices_enu_m.tolist()])[mesh.triangles]
    edges = [(int(t[k]), int(t[(k + 1) % 3])) for t in number for k in range(3)]
    assert len(set(edges)) == len(edges)
    rim = [e for e in edges if e[::-1] not in set(edges)]
    points = np.unique(mesh.vertices_enu_m, axis=0)
    assert all(np.abs(points[list(e)]).max() > 500.0 for e in rim)
    assert across[:, 2].sum() / 2 > (2 * 500.0) ** 2


def test_fields_have_several_crops_and_the_yard_is_grass():
    mesh = ground()
    textures = {paint.texture for paint in mesh.paints}
    assert {"grass", "meadow", "crops", "soil", "leaves"} <= textures
    first = mesh.face_first[[mesh.paints[p].texture == "grass" for p in mesh.face_paint]]
    yard = mesh.vertices_enu_m[first[0] : first[0] + 4]
    assert np.abs(yard[:, :2]).min() == pytest.approx(40.0 + 26.0)


@pytest.mark.parametrize("detail", [FAST, FINE], ids=["fast", "fine"])
def test_a_relief_without_anything_on_it_can_be_drawn(detail):
    model = build_world(relief_scene(hills())).new_looks(detail)
    assert model.ngeom > 10


def test_the_ground_of_a_relief_is_drawn_where_the_physics_has_it():
    scene = relief_scene(hills())
    builder = MeshBuilder(scene.relief)
    add_surroundings(builder, scene, 300.0)
    mesh = builder.mesh()
    middles = mesh.corners_enu_m().mean(axis=1)
    expected_m = scene.relief.height_m(middles[:, 0], middles[:, 1])
    np.testing.assert_allclose(middles[:, 2], expected_m, atol=1e-9)
    assert np.abs(middles[:, :2]).max() > 300.0
    assert (mesh.normals_enu[:, 2] > 0.4).all()
    a, b, c = np.moveaxis(mesh.corners_enu_m(), 1, 0)
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
