"""`bench vehicles`: several vehicles in one world, in simulated seconds per CPU second."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import islice

import numpy as np

from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from flightsim.mavlink.links import UdpLink
from flightsim.plant import Plant, PlantCfg, compile_kernels
from flightsim.plant.cfg import ADVANCE_HZ
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import WorldError, build_world
from scenarios.bench.clients import Clients
from scenarios.bench.collisions import Collider, Collision
from scenarios.bench.configs import BenchError, VehiclesBenchCfg
from scenarios.bench.figure_eight import hold
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.bench.square_flight import fly_square, take_off

LEAST_SPEED = 12.0
"""Target in simulated seconds per CPU second of four vehicles with their stacks."""
_CLIMB_M = 10.0
_SPEED_UNIT = "simulated s / CPU s"
_OTHER = {"iris": "hummingbird"}
"""Second airframe of the collisions, by the configured one; it is an Iris for any other."""
_SEED = 0


def rows(cfg: VehiclesBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Run every part of the benchmark.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called before each part.

    Raises:
        SceneError: If there is no such scene.
        AirframeError: If there is no such vehicle.
        BenchError: If the start has no room, or a vehicle does not fly.
    """
    scene, airframe = load_scene(cfg.scene), airframe_by_name(cfg.vehicle)
    compile_kernels()
    on_progress("whole stack", 0.0)
    try:
        yield from _whole_stack(cfg, scene, airframe)
    except WorldError as error:
        raise BenchError(str(error)) from error
    on_progress("plants alone", 0.3)
    yield from _plants_alone(cfg, scene, airframe)
    on_progress("collisions", 0.4)
    yield from _collisions(cfg, on_progress)
    on_progress("done", 1.0)


def _whole_stack(cfg: VehiclesBenchCfg, scene: Scene, airframe: Airframe) -> Iterator[Row]:
    """Take off and fly squares with two clients for each vehicle; only the squares are timed."""
    n = cfg.vehicles
    with Clients(2 * n) as clients, ExitStack() as stack:
        ports = iter(clients.ports)
        links = [
            [
                UdpLink(local_port=0, remote_port=next(ports), profile=profile)
                for profile in ("normal", "onboard")
            ]
            for _ in range(n)
        ]
        bench = stack.enter_context(
            Testbench(
                scene,
                TestbenchCfg(speed="max"),
                airframes=[airframe] * n,
                has_network=False,
                links=links,
            )
        )
        take_off(bench)
        cpu_s, wall_s = time.process_time(), time.perf_counter()
        fly_square(bench, cfg.seconds)
        cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - wall_s
    what = f"{n} vehicles, whole stack, two UDP clients each"
    yield higher(what, cfg.seconds / cpu_s, _SPEED_UNIT, LEAST_SPEED)
    yield higher(f"{what}, by the wall clock", cfg.seconds / wall_s, "simulated s / wall s")


def _plants_alone(cfg: VehiclesBenchCfg, scene: Scene, airframe: Airframe) -> Iterator[Row]:
    """Yield the speed of all plants together, and the cost of one of them over one alone."""
    plant_cfg = PlantCfg(seed=0, aiding="auto")
    spent_s = []
    for n in (1, cfg.vehicles):
        first = Plant(build_world(scene, *[airframe] * n), plant_cfg)
        plants = (first, *first.other_plants)
        # One call aligns and advances all: the first plant stands for the world.
        first.align()
        for plant in plants:
            # Each climbs above its own start, so that none gets near another.
            east, north, up = plant.truth.position_enu_m
            plant.apply(hold((east, north, up + _CLIMB_M)))
        cpu_s = time.process_time()
        for _ in range(round(cfg.seconds * ADVANCE_HZ)):
            first.advance()
        spent_s.append(time.process_time() - cpu_s)
        if any(plant.truth.position_enu_m[2] < 0.5 * _CLIMB_M for plant in plants):
            raise BenchError("the plants alone did not climb")
    yield higher("plants of all alone", cfg.seconds / spent_s[1], _SPEED_UNIT)
    yield lower("CPU time of a vehicle among them over one alone", _ratio(spent_s, cfg), "")


def _ratio(spent_s: list[float], cfg: VehiclesBenchCfg) -> float:
    return spent_s[1] / spent_s[0] / cfg.vehicles


def _collisions(cfg: VehiclesBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Let pairs of one airframe and of two collide."""
    field, own = load_scene("field"), airframe_by_name(cfg.vehicle)
    other = airframe_by_name(_OTHER.get(cfg.vehicle, "iris"))
    found: list[Collision] = []
    n_done, pairs = 0, ((own, own), (own, other), (other, other))
    for k, pair in enumerate(pairs):
        collider = Collider(build_world(field, *pair), np.random.default_rng([_SEED, k]))
        # Thirds by rounding the sums, so that they add up to the whole number.
        n = cfg.collisions * (k + 1) // len(pairs) - n_done
        for collision in islice(collider.collide(), n):
            found.append(collision)
            if len(found) % 100 == 0:
                on_progress("collisions", 0.4 + 0.6 * len(found) / cfg.collisions)
        n_done += n
    yield higher("collisions between two vehicles", len(found), "")
    n_through = sum(each.passes_through for each in found)
    yield lower("of these, passed through", n_through, "", 0)
    depth_m = max(each.depth_m for each in found)
    yield lower("greatest depth of anything in a fuselage", depth_m, "m")
    yield higher("least change of the relative velocity", min(each.change for each in found), "")
