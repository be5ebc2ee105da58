"""Wind among buildings: mass-consistent, potential where it should be, less in the lee."""

import math
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.field import field_scene
from flightsim.environment.shelter import Grid, cached_shelter, flow_at
from flightsim.environment.shelter.mass_consistent import mass_consistent
from flightsim.environment.shelter.shelter import blocks_of, solve_shelter
from tests.aeroscene.scene.test_outline import L_SHAPE, outlined

EAST = (1.0, 0.0)
BLOCK = np.array([[0.0, 0.0, 1.0, 0.0, 10.0, 10.0, 12.0, 0.0]])
GRID = Grid((-41.0, -41.0, 0.0), (41, 41, 14))
LEVEL = np.zeros((41, 41))


@pytest.fixture(scope="module")
def field():
    return solve_shelter(GRID, BLOCK, LEVEL, EAST)


def at(field, *position, grid=GRID):
    out = np.zeros(3)
    origin = np.array(grid.origin_enu_m)
    assert flow_at(field, origin, grid.cell_m, np.array(position, dtype=float), out)
    return out


def test_flow_about_a_hemisphere_is_potential_flow():
    """Half a ball of radius a on the ground: 1 + a^3 / 2r^3 beside it, 1 - a^3 / r^3 before it."""
    n, a = 57, 9.0
    x, z = np.arange(n) - n // 2, np.arange(n // 2) + 0.5
    r = np.sqrt(x[:, None, None] ** 2 + x[None, :, None] ** 2 + z[None, None, :] ** 2)
    guess = np.zeros((*r.shape, 3))
    guess[..., 0] = r >= a
    flow = mass_consistent(guess, r < a)
    c = n // 2
    for away in (12, 14, 18):
        r = math.hypot(away, 0.5)
        assert flow[c, c + away, 0, 0] == pytest.approx(1.0 + 0.5 * (a / r) ** 3, abs=0.05)
        assert flow[c + away, c, 0, 0] == pytest.approx(1.0 - (a / r) ** 3, abs=0.05)


def test_nothing_piles_up_and_nothing_enters_a_wall():
    rng = np.random.default_rng(0)
    is_solid = np.zeros((12, 10, 8), dtype=bool)
    is_solid[4:7, 3:6, :5] = True
    guess = rng.normal(size=(12, 10, 8, 3))
    flow = mass_consistent(guess, is_solid)
    np.testing.assert_allclose(flow[5, 4, 2], 0.0)
    # What flows across a closed wall of cells about the block is nothing in sum.
    again = mass_consistent(flow, is_solid)
    assert np.abs(again - flow).max() < 0.6 * np.abs(guess).max()


def test_it_is_calm_behind_a_building_and_windy_at_its_corners(field):
    """A cube in an open wind: return flow in the cavity, 1.1 to 1.4 beside and above it."""
    behind, beside, above = (
        at(field, 9.0, 0.0, 3.0),
        at(field, 0.0, 8.0, 6.0),
        at(field, 0.0, 0.0, 15.0),
    )
    assert behind[0] < 0.2
    assert 1.1 < beside[0] < 1.5
    assert 1.05 < above[0] < 1.5
    front = at(field, -7.0, 0.0, 4.0)
    assert front[0] < 0.7


def test_the_wake_recovers_downwind(field):
    speeds = [at(field, x, 0.0, 4.0)[0] for x in (8.0, 14.0, 22.0, 34.0)]
    assert np.all(np.diff(speeds) > 0.0)
    assert speeds[-1] > 0.5
    far = at(field, -34.0, 30.0, 20.0)
    np.testing.assert_allclose(far, (1.0, 0.0, 0.0), atol=0.06)


def test_the_field_turns_with_the_wind():
    north = solve_shelter(GRID, BLOCK, LEVEL, (0.0, 1.0))
    east = solve_shelter(GRID, BLOCK, LEVEL, EAST)
    np.testing.assert_allclose(at(north, 3.0, 9.0, 3.0)[1], at(east, 9.0, 3.0, 3.0)[0], atol=1e-3)


def test_wind_is_stronger_over_a_crest_and_blows_along_its_slopes():
    east = GRID.centres_m[0][..., 0]
    ridge = np.broadcast_to(np.clip(10.0 - 0.5 * np.abs(east), 0.0, None), (41, 41))
    flow = solve_shelter(GRID, np.zeros((0, 8)), ridge, EAST)
    assert at(flow, 0.0, 0.0, 13.0)[0] > 1.1
    assert at(flow, -10.0, 0.0, 8.0)[2] > 0.1 > -0.1 > at(flow, 10.0, 0.0, 8.0)[2]
    np.testing.assert_array_equal(at(flow, 0.0, 0.0, 5.0), 0.0)


def test_a_block_on_a_hill_shelters_as_one_in_the_plain(field):
    raised = GRID.origin_enu_m[:2]
    grid = Grid((*raised, 30.0), GRID.shape)
    block = BLOCK + (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 30.0, 30.0)
    flow = solve_shelter(grid, block, LEVEL + 30.0, EAST)
    np.testing.assert_allclose(flow, field, atol=1e-9)


def test_interpolation_is_exact_for_linear_fields_and_ends_with_the_grid():
    grid = Grid((-4.0, -2.0, 0.0), (6, 5, 4))
    x, y, z = np.broadcast_arrays(*grid.centres_m)
    field = np.stack([1.0 + 0.1 * x, 0.2 * y - z, 0.05 * z], axis=-1)
    np.testing.assert_allclose(at(field, 1.3, 2.2, 3.1, grid=grid), (1.13, 0.44 - 3.1, 0.155))
    out, origin = np.zeros(3), np.array(grid.origin_enu_m)
    assert not flow_at(field, origin, grid.cell_m, np.array((-9.0, 0.0, 2.0)), out)
    assert not flow_at(field, origin, grid.cell_m, np.array((0.0, 0.0, 9.0)), out)


def test_a_solved_field_is_kept_and_a_damaged_one_replaced(tmp_path, monkeypatch):
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    monkeypatch.delenv("AEROSCENE_CACHE", raising=False)
    grid = Grid((-20.0, -20.0, 0.0), (20, 20, 10))
    once = cached_shelter(grid, BLOCK, np.zeros((20, 20)), EAST)
    (path,) = (tmp_path / "winds").iterdir()
    path.write_bytes(path.read_bytes()[:100])
    again = cached_shelter(grid, BLOCK, np.zeros((20, 20)), EAST)
    np.testing.assert_array_equal(once, again)
    cached_shelter(grid, BLOCK, np.zeros((20, 20)), (math.cos(0.3), math.sin(0.3)))
    assert len(list((tmp_path / "winds").iterdir())) == 2


def test_a_field_has_the_same_bits_however_many_threads_blas_has():
    code = (
        "import hashlib, numpy as np; from flightsim.environment.shelter import Grid;"
        "from flightsim.environment.shelter.shelter import solve_shelter;"
        "block = np.array([[0.0, 0.0, 1.0, 0.0, 10.0, 10.0, 12.0, 0.0]]);"
        "grid = Grid((-41.0, -41.0, 0.0), (41, 41, 14));"
        "flow = solve_shelter(grid, block, np.zeros((41, 41)), (0.6, 0.8));"
        "print(hashlib.md5(flow.tobytes()).hexdigest())"
    )
    bits = {
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"OPENBLAS_NUM_THREADS": n_threads, "OMP_NUM_THREADS": n_threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for n_threads in ("1", "2")
    }
    assert len(bits) == 1


def test_a_building_with_an_outline_shelters_from_its_walls_not_from_its_box():
    obj = replace(outlined(L_SHAPE), scene_id="field")
    scene = replace(field_scene(), objects=(obj,), interaction_areas=())
    blocks = blocks_of(scene)
    assert len(blocks) == 2
    assert (blocks[:, 4] * blocks[:, 5]).sum() == pytest.approx(60.0)
    assert blocks[:, 6] == pytest.approx([6.0, 6.0])
