"""Traffic in real scenes: where it belongs, never through solids, never twice the same place."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from aeroscene.corpus.field import field_scene
from aeroscene.scene.catalogue import category_id
from aeroscene.solids.shapes import scene_primitives
from aeroscene.sources import load_scene
from flightsim.environment.floor import CELL_M, Columns
from flightsim.environment.motion import new_movers, place_mover
from flightsim.environment.traffic import TrafficCfg, TrafficError, plan_traffic
from flightsim.looks.geom_groups import GeomGroup
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import FIRST_MOVER_ID, build_world
from flightsim.world.geometry import SurfaceProbe
from tests.aeroscene.scene.test_outline import L_SHAPE, outlined

IRIS = AIRFRAMES["iris"]
CASES = {"42": "people=3,cars=2,drones=1", "500": "people=3,drones=2"}


@pytest.fixture(scope="module", params=list(CASES))
def world(request):
    cfg = TrafficCfg.parse(CASES[request.param], seed=3)
    return build_world(load_scene(request.param), IRIS, traffic=cfg)


def states(world, times_s):
    """Positions (t, n, 3) and yaws (t, n) of the movers."""
    movers, control = new_movers(world.obstacles)
    positions, yaws = [], []
    for t in times_s:
        for mover in movers:
            place_mover(mover, control, t, 1.0)
        positions.append(movers["position_enu_m"].copy())
        yaws.append(movers["yaw_rad"].copy())
    return np.array(positions), np.array(yaws)


def put(world, data, positions, yaws):
    data.mocap_pos[:] = positions
    data.mocap_quat[:] = np.column_stack([np.cos(yaws / 2), 0 * yaws, 0 * yaws, np.sin(yaws / 2)])
    mujoco.mj_kinematics(world.model, data)


def test_movers_never_touch_what_stands_there(world):
    model, data = world.model, world.new_data()
    is_solid = (model.geom_group == GeomGroup.SCENE) & (model.geom_contype > 0)
    solids = np.flatnonzero(is_solid & (model.geom_rbound > 0))
    movers = np.flatnonzero(model.geom_group == GeomGroup.MOVING)
    nearest = np.inf
    for positions, yaws in zip(*states(world, np.arange(0.0, 60.0, 1.7)), strict=True):
        put(world, data, positions, yaws)
        for mover in movers.tolist():
            away = np.linalg.norm(data.geom_xpos[solids] - data.geom_xpos[mover], axis=1)
            reach = model.geom_rbound[solids] + model.geom_rbound[mover]
            for solid in solids[away < reach].tolist():
                gap = mujoco.mj_geomDistance(model, data, mover, solid, 1.0, None)
                nearest = min(nearest, gap)
    assert 0.0 < nearest < 0.1


def test_movers_stand_on_what_is_below_them(world):
    model, data = world.model, world.new_data()
    groups = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8)
    hit = np.zeros(1, dtype=np.int32)
    for positions, _ in zip(*states(world, np.arange(0.0, 40.0, 2.3)), strict=True):
        for obstacle, position in zip(world.obstacles, positions, strict=True):
            if obstacle.kind == "drone":
                continue
            eye = position + (0.0, 0.0, 0.2)
            depth = mujoco.mj_ray(model, data, eye, (0.0, 0.0, -1.0), groups, 1, -1, hit)
            # A kerb under a wheel may lift it.
            assert 0.2 < depth < 0.5


def test_no_two_movers_ever_meet(world):
    everywhere = np.arange(0.0, 120.0, 0.3)
    positions, _ = states(world, everywhere)
    is_flying = np.array([obstacle.kind == "drone" for obstacle in world.obstacles])
    for i in range(len(world.obstacles)):
        for j in range(i):
            if is_flying[i] == is_flying[j]:
                # Wherever either is at whatever time.
                apart = positions[:, None, i, :2] - positions[None, :, j, :2]
                assert np.linalg.norm(apart, axis=2).min() > 0.7


def test_movers_keep_away_from_the_start(world):
    positions, _ = states(world, np.arange(0.0, 120.0, 0.3))
    start = np.array(world.scene.start_position_enu_m[:2])
    assert np.linalg.norm(positions[..., :2] - start, axis=2).min() > 3.0


def test_the_seed_settles_everything():
    scene = load_scene("500")
    solids = scene_primitives(scene)
    probe = SurfaceProbe(None, solids)

    def paths(seed):
        return plan_traffic(
            TrafficCfg(people=1, drones=1, seed=seed), scene, solids, probe.height_m
        )

    assert paths(3) == paths(3)
    assert paths(3) != paths(4)


def test_movers_begin_where_they_are_at_time_zero(world):
    positions, _ = states(world, [0.0])
    np.testing.assert_array_equal(world.new_data().mocap_pos, positions[0])


def test_every_mover_has_an_id_of_its_own(world):
    ids = world.geom_object_id[world.model.geom_group == GeomGroup.MOVING]
    assert ids.tolist() == [FIRST_MOVER_ID - i for i in range(len(world.obstacles))]


def test_a_car_in_a_flat_is_refused():
    with pytest.raises(TrafficError, match=r"\(indoor\) has no room for one more car"):
        build_world(load_scene("500"), IRIS, traffic=TrafficCfg(cars=1))


@pytest.mark.parametrize(
    "text", ["dogs=1", "people", "people=-1", "people=1,people=2", "people=1.5", ""]
)
def test_traffic_that_makes_no_sense_is_refused_with_what_is_valid(text):
    with pytest.raises(TrafficError, match="people=N,cars=N,drones=N"):
        TrafficCfg.parse(text, 0)


def test_too_much_traffic_is_refused():
    with pytest.raises(TrafficError, match="0 to 64 are valid"):
        TrafficCfg(people=65)
    with pytest.raises(TrafficError, match="64 in all"):
        TrafficCfg(people=40, drones=40)


def test_traffic_reads_what_it_is_told():
    assert TrafficCfg.parse("none", 1) == TrafficCfg(seed=1)
    assert TrafficCfg.parse("cars=2, people=3", 1) == TrafficCfg(people=3, cars=2, seed=1)


def test_roads_with_an_outline_cover_no_more_than_it():
    road = replace(outlined(L_SHAPE), scene_id="field", category_id=category_id("road"))
    scene = replace(field_scene(), objects=(road,), interaction_areas=())
    columns = Columns.from_scene(scene, scene_primitives(scene), 2.0)
    covered_m2 = columns.covered_by([road]).sum() * CELL_M**2
    assert covered_m2 == pytest.approx(60.0, rel=0.05)
