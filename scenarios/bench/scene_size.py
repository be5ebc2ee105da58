"""Growth of the plant's tick with the scene: a hover with few and with many solids around it.

The cost of a tick should not depend on objects that are far away. Copies of the scene are therefore
placed around it, and both worlds are stepped in turn.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive, scene_primitives
from flightsim.plant import Plant, PlantCfg
from flightsim.simulator import TICK_US
from flightsim.vehicles.airframe import Airframe
from flightsim.world import World, build_world
from scenarios.bench.configs import BenchError
from scenarios.bench.figure_eight import hold
from scenarios.bench.row import Row, lower

FEW_GEOMS, MANY_GEOMS = 700, 2_500
MOST_GROWTH = 1.4
"""Greatest ratio of a tick with many geoms to one with few."""
_CLIMB_M = 10.0
_ROUNDS = 10
"""Turns of both worlds, so that a slow moment of the machine meets both alike."""


def scene_size_rows(scene: Scene, airframe: Airframe, seconds: float) -> Iterator[Row]:
    """Measure a tick of 20 ms in a scene, with parts of copies of it around to fill it up.

    Args:
        scene: Scene to hover in; one with more geoms than few stays as it is.
        airframe: Vehicle.
        seconds: Simulated seconds in each.

    Raises:
        BenchError: If the vehicle does not climb.
    """
    n_alone = build_world(scene, airframe).model.ngeom
    worlds = [
        build_world(scene, airframe, extra=_around(scene, max(0, n - n_alone)))
        for n in (FEW_GEOMS, MANY_GEOMS)
    ]
    plants = [_hovering(world) for world in worlds]
    n_ticks = round(seconds * 1e6 / TICK_US / _ROUNDS)
    spent_s = [0.0, 0.0]
    for _ in range(_ROUNDS):
        for i, plant in enumerate(plants):
            begun_s = time.thread_time()
            for _ in range(n_ticks):
                plant.advance()
            spent_s[i] += time.thread_time() - begun_s
    for world, tick_s in zip(worlds, spent_s, strict=True):
        tick_us = 1e6 * tick_s / (_ROUNDS * n_ticks)
        yield lower(f"tick of 20 ms of the plant, {world.model.ngeom} geoms", tick_us, "us")
    yield lower("the same, many geoms over few", spent_s[1] / spent_s[0], "", MOST_GROWTH)


def _around(scene: Scene, n: int) -> list[Primitive]:
    """Return the first n solids of copies of a scene that stand around it."""
    east_m, north_m, _ = np.subtract(scene.extent_max_enu_m, scene.extent_min_enu_m).tolist()
    solids = scene_primitives(scene)
    copies = []
    # The eight neighbours of the scene itself, each shifted by its extent.
    for east, north in itertools.product((1, -1, 0), repeat=2):
        for solid in solids if (east, north) != (0, 0) else ():
            x, y, z = solid.position_enu_m
            place = (x + east * east_m, y + north * north_m, z)
            copies.append(replace(solid, position_enu_m=place))
    return copies[:n]


def _hovering(world: World) -> Plant:
    """Return a plant whose vehicle hovers above the scene's start."""
    plant = Plant(world, PlantCfg(seed=0, aiding="auto"))
    plant.align()
    east, north, up = plant.estimate.position_enu_m
    plant.apply(hold((east, north, up + _CLIMB_M)))
    for _ in range(200):
        plant.advance()
    if plant.truth.position_enu_m[2] < up + 0.5 * _CLIMB_M:
        raise BenchError("the vehicle did not climb")
    return plant
