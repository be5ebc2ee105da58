from dataclasses import replace

from aeroscene.solids.shapes import scene_primitives
from flightsim.looks.cutting import cut_at
from tests.aeroscene.conftest import cached_scene

CUT_M = 2.6


def test_the_floors_of_rooms_stay_and_their_lights_go():
    scene = cached_scene(311)
    rooms = {obj.id for obj in scene.objects if obj.category == "room"}
    solids = [solid for solid in scene_primitives(scene) if solid.object_id in rooms]
    kept = cut_at(solids, CUT_M)
    assert kept
    assert {solid.material for solid in kept} < {solid.material for solid in solids}
    assert max(solid.position_enu_m[2] for solid in kept) < CUT_M


def test_an_upright_box_is_cut_and_its_foot_stays():
    wall = next(
        solid
        for solid in scene_primitives(cached_scene(311))
        if solid.kind == "box" and solid.size_m[2] > CUT_M
    )
    wall = replace(wall, position_enu_m=(0.0, 0.0, wall.size_m[2] / 2))
    (cut,) = cut_at([wall], CUT_M)
    assert cut.size_m[2] == CUT_M
    assert cut.position_enu_m[2] == CUT_M / 2
    assert cut_at([wall], CUT_M, least_m=5.0) == ()
