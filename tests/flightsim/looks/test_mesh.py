import numpy as np
import pytest

from flightsim.looks.bake import lit
from flightsim.looks.dressing import dress
from flightsim.looks.light import AFTERNOON
from flightsim.looks.mesh import MeshBuilder, add_solids
from flightsim.looks.skins import skins
from flightsim.looks.surfaces import FAST, surface_enu
from tests.flightsim.handmade import solid

UPRIGHT = (0.5, 0.5, 0.5, 0.5)
PANEL = solid(
    "box", (3.0, 0.0, 9.0), (12.0, 16.0, 0.02), material="facade_sand", quat=UPRIGHT, object_id=4
)
SOLIDS = {
    "crate": solid("box", (0, 0, 2), (1, 2, 3), material="wood"),
    "facade": PANEL,
    "slab": solid("box", (0, 0, 4), (6, 8, 0.3)),
    "wall": solid("box", (0, 0, 2), (0.2, 5, 2.6), material="plaster_white"),
    "crown": solid("ellipsoid", (0, 0, 5), (3, 3, 4), material="leaves"),
    "post": solid("cylinder", (0, 0, 2), (0.3, 0.3, 3), material="metal"),
}
CATEGORIES = {"facade": "building", "slab": "floor", "wall": "wall", "crown": "tree"}


def mesh_of(*solids, category=None):
    builder = MeshBuilder()
    categories = {} if category is None else {s.object_id: category for s in solids}
    add_solids(builder, solids, categories, FAST)
    return builder.mesh()


def area_m2(corners):
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(across, axis=1).sum() / 2


@pytest.mark.parametrize("name", sorted(SOLIDS))
def test_dressing_covers_a_solid_and_moves_nothing(name):
    mesh = mesh_of(SOLIDS[name], category=CATEGORIES.get(name))
    surface = surface_enu(SOLIDS[name], FAST)
    for k in range(3):
        dressed, bare = mesh.vertices_enu_m[:, k], surface.vertices_m[:, k]
        assert (dressed.min(), dressed.max()) == pytest.approx((bare.min(), bare.max()))
    # A facade in two parts has two more edges, each as thick as the panel.
    seam_m2 = 2 * 12.0 * 0.02 if name == "facade" else 0.0
    expected_m2 = area_m2(surface.corners_m()) + seam_m2
    assert area_m2(mesh.corners_enu_m()) == pytest.approx(expected_m2, rel=1e-9)


def test_what_lies_on_the_ground_has_no_underside():
    lying = mesh_of(solid("box", (0, 0, 0.1), (4, 4, 0.2)))
    assert len(lying.face_first) == 5
    assert (lying.normals_enu[:, 2] > -0.5).all()


def test_tall_facade_has_shops_or_doors_below_and_windows_above():
    pieces = list(dress(PANEL, "building"))
    low, high = sorted(pieces, key=lambda piece: piece.primitive.position_enu_m[2])
    assert low.paint.texture in ("shop_front", "entrance")
    assert high.paint.texture not in ("shop_front", "entrance")
    assert low.primitive.position_enu_m[2] == pytest.approx(1.0 + 1.6)


def test_trees_differ_in_tint_and_keep_theirs():
    crowns = [
        solid("ellipsoid", (0, 0, 5), (3, 3, 4), material="leaves", object_id=k) for k in range(4)
    ]
    tints = [next(dress(crown, "tree")).paint.rgb for crown in crowns]
    assert len(set(tints)) == 4
    assert tints == [next(dress(crown, "tree")).paint.rgb for crown in crowns]


def test_a_tile_lasts_a_tile_on_every_wall():
    mesh = mesh_of(solid("box", (0, 0, 3), (4, 6, 6), material="brick"))
    size_m = np.array(mesh.paints[0].size_m)
    for first in mesh.face_first:
        corners = mesh.vertices_enu_m[first : first + 3]
        tiles = mesh.texture_tiles[first : first + 3] * size_m
        for a, b in ((0, 1), (1, 2)):
            np.testing.assert_allclose(
                np.linalg.norm(tiles[b] - tiles[a]), np.linalg.norm(corners[b] - corners[a])
            )


def light_at(mesh, mask):
    return mesh.normals_enu[mask] @ AFTERNOON.to_sun


def hut(roof_m=3.0):
    walls = [
        solid("box", (x, y, roof_m / 2), size, material="brick")
        for x, y, size in (
            (-4, 0, (0.2, 8, roof_m)),
            (4, 0, (0.2, 8, roof_m)),
            (0, -4, (8, 0.2, roof_m)),
            (0, 4, (8, 0.2, roof_m)),
        )
    ]
    roof = solid("box", (0, 0, roof_m + 0.1), (8.2, 8.2, 0.2))
    floor = solid("box", (0, 0, 0.05), (7.8, 7.8, 0.1), material="parquet")
    return [*walls, roof, floor]


def test_closed_room_is_lit_by_lamps_and_not_by_the_sun():
    solids = hut()
    plain = mesh_of(*solids)
    mesh = lit(plain, solids).surfaces
    z, up = plain.vertices_enu_m[:, 2], plain.normals_enu[:, 2] > 0.9
    floor = light_at(mesh, np.flatnonzero(up & (np.abs(z - 0.1) < 0.01)))
    assert 0.4 < floor.min() <= floor.max() < 0.75
    assert light_at(mesh, np.flatnonzero(up & (z > 3.15))).min() > 0.85


def test_light_moves_no_vertex_and_adds_shadows_only_within_millimetres():
    solids = [
        solid("box", (0, 0, 0.05), (30, 30, 0.1), material="asphalt"),
        solid("box", (0, 0, 2.1), (2, 2, 4.0), material="brick"),
    ]
    plain = mesh_of(*solids)
    mesh = lit(plain, solids)
    np.testing.assert_array_equal(mesh.surfaces.vertices_enu_m, plain.vertices_enu_m)
    np.testing.assert_array_equal(mesh.surfaces.triangles, plain.triangles)
    added = mesh.layers.vertices_enu_m
    assert len(added) > 3
    np.testing.assert_allclose(added[:, 2], 0.104, atol=1e-6)
    assert light_at(mesh.layers, np.arange(len(added))).max() < 0.5
    # The texture goes on under the shadow.
    size_m = np.array(plain.paints[0].size_m)
    np.testing.assert_allclose(mesh.layers.texture_tiles * size_m, added[:, :2] + 15.0, atol=1e-6)


def test_skins_hold_every_triangle_once():
    solids = hut()
    mesh = lit(mesh_of(*solids), solids).surfaces
    parts = list(skins(mesh))
    assert sum(len(part.triangles) for part in parts) == len(mesh.triangles)
    total = sum(area_m2(part.vertices_enu_m[part.triangles]) for part in parts)
    assert total == pytest.approx(area_m2(mesh.corners_enu_m()))
    assert all(len(part.vertices_enu_m) >= 4 for part in parts)


def test_light_is_the_same_each_time():
    solids = hut()
    meshes = [lit(mesh_of(*solids), solids) for _ in range(2)]
    for first, second in zip(*((mesh.surfaces, mesh.layers) for mesh in meshes), strict=True):
        assert first.normals_enu.tobytes() == second.normals_enu.tobytes()
        assert first.vertices_enu_m.tobytes() == second.vertices_enu_m.tobytes()
