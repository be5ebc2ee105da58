"""`bench sim`: the whole stack in a scene, then its parts, in simulated seconds per CPU second.

The whole stack counts, because users run nothing less. Parts are measured after it, to show where
time goes. Real UDP clients listen in a process of their own, so MAVLink's cost is included and
theirs is not.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from aeroscene.scene import Scene
from aeroscene.solids.shapes import scene_primitives
from aeroscene.sources import load_scene
from flightsim.cameras import Cameras
from flightsim.mavlink.links import UdpLink
from flightsim.plant import Plant, PlantCfg, compile_kernels
from flightsim.simulator import TICK_US, Observer
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world
from scenarios.bench.client_cost import client_rows
from scenarios.bench.clients import Clients
from scenarios.bench.configs import BenchError, SimBenchCfg
from scenarios.bench.figure_eight import hold
from scenarios.bench.launch import cpu_seconds_to_first_heartbeat
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.bench.scene_size import scene_size_rows
from scenarios.bench.square_flight import fly_square, take_off

LEAST_SPEED = 30.0
"""Target in simulated seconds per CPU second for the whole stack without cameras."""
LONGEST_LAUNCH_S = 1.0
CAMERA_HZ = 10
_CAMERA_SHARE = 0.2
"""Share of the benchmark's duration for flights with cameras, which take long."""
_CLIMB_M = 10.0
_N_STEPS = 20_000
_SPEED_UNIT = "simulated s / CPU s"


@dataclass(frozen=True, slots=True)
class _Flight:
    """Durations and costs of one flight."""

    sim_s: float
    cpu_s: float
    wall_s: float
    shares_us: dict[str, float]
    """Wall time of each part in a tick, us."""
    n_messages: int
    free_share: float
    """Share of the physics steps that the kernel took itself, in free flight without MuJoCo."""


def rows(cfg: SimBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Run every part of the benchmark.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called before each part.

    Raises:
        SceneError: If there is no such scene.
        AirframeError: If there is no such vehicle.
        BenchError: If the vehicle does not fly.
        LaunchError: If a real launch brings no heartbeat.
    """
    scene, airframe = load_scene(cfg.scene), airframe_by_name(cfg.vehicle)
    # Otherwise the first flight would count the compiler.
    compile_kernels()
    on_progress("whole stack", 0.0)
    yield from _whole_stack(cfg, scene)
    on_progress("cost of a client", 0.2)
    yield from client_rows(scene, cfg.vehicle, cfg.seconds)
    on_progress("plant alone", 0.25)
    # The same world for the plant and for MuJoCo alone, so that their difference is the plant's.
    world = build_world(scene, airframe)
    yield _plant_alone(world, cfg.seconds)
    yield from scene_size_rows(scene, airframe, cfg.seconds)
    on_progress("physics alone", 0.35)
    yield _physics_alone(world)
    on_progress("recording", 0.4)
    yield _recorded(cfg, scene, camera_hz=0)
    on_progress("recording with cameras", 0.55)
    yield _recorded(cfg, scene, camera_hz=CAMERA_HZ)
    on_progress("launch", 0.9)
    launch_s = cpu_seconds_to_first_heartbeat(cfg.scene, cfg.vehicle)
    yield lower("launch to first heartbeat", launch_s, "CPU s", LONGEST_LAUNCH_S)
    on_progress("done", 1.0)


def _whole_stack(cfg: SimBenchCfg, scene: Scene) -> Iterator[Row]:
    flight = _fly(cfg, scene, cfg.seconds)
    sim_s = flight.sim_s
    yield higher("whole stack, two UDP clients", sim_s / flight.cpu_s, _SPEED_UNIT, LEAST_SPEED)
    yield higher("whole stack, by the wall clock", sim_s / flight.wall_s, "simulated s / wall s")
    for part, tick_us in flight.shares_us.items():
        yield lower(f"tick of 20 ms: {part}", tick_us, "us")
    rate = flight.n_messages / sim_s
    yield higher("MAVLink received by both clients", rate, "messages / simulated s")
    yield higher("physics steps in free flight", 100.0 * flight.free_share, "%")


def _fly(
    cfg: SimBenchCfg,
    scene: Scene,
    seconds: float,
    equip: Callable[[Testbench, ExitStack], Iterable[Observer]] | None = None,
) -> _Flight:
    """Take off and fly a square with two clients listening; only the flight is timed."""
    bench_cfg = TestbenchCfg(vehicle=cfg.vehicle, speed="max")
    with Clients(2) as clients, ExitStack() as stack:
        gcs_port, sdk_port = clients.ports
        gcs = UdpLink(local_port=0, remote_port=gcs_port, profile="normal")
        sdk = UdpLink(local_port=0, remote_port=sdk_port, profile="onboard")
        bench = Testbench(scene, bench_cfg, has_network=False, links=[(gcs, sdk)])
        stack.enter_context(bench)
        take_off(bench)
        if equip is not None:
            bench.observers += equip(bench, stack)
        # Counters are read before and after the square, so that the climb is not counted.
        before, start_us = bench.simulator.timing, bench.plant.time_us
        n_messages, n_free = clients.n_messages(), bench.plant.n_free_steps
        cpu_s, wall_s = time.process_time(), time.perf_counter()
        fly_square(bench, seconds)
        cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - wall_s
        n_messages = clients.n_messages() - n_messages
        after, sim_s = bench.simulator.timing, (bench.plant.time_us - start_us) * 1e-6
        n_ticks = after.n_steps - before.n_steps
        parts = {
            "plant": after.plant_s - before.plant_s,
            "autopilot": after.autopilot_s - before.autopilot_s,
            "MAVLink": after.mavlink_s - before.mavlink_s,
            "observers": after.observers_s - before.observers_s,
        }
        return _Flight(
            sim_s,
            cpu_s,
            wall_s,
            {part: 1e6 * part_s / n_ticks for part, part_s in parts.items()},
            n_messages,
            (bench.plant.n_free_steps - n_free) / (sim_s * bench.plant.cfg.physics_hz),
        )


def _plant_alone(world: World, seconds: float) -> Row:
    """Return the speed of physics, sensors, estimator and controller, hovering."""
    plant = Plant(world, PlantCfg(seed=0))
    east, north, up = plant.truth.position_enu_m
    for _ in range(100):
        plant.advance()
    plant.apply(hold((east, north, up + _CLIMB_M)))
    cpu_s = time.process_time()
    for _ in range(round(seconds * 1e6 / TICK_US)):
        plant.advance()
    cpu_s = time.process_time() - cpu_s
    # A vehicle on the ground would be measured with contacts.
    if plant.truth.position_enu_m[2] < up + 1.0:
        raise BenchError("the plant alone did not climb")
    return higher("plant alone", seconds / cpu_s, _SPEED_UNIT)


def _physics_alone(world: World) -> Row:
    """Return the time of MuJoCo's step with the vehicle in the air, carried by a force."""
    model, data = world.model, world.new_data()
    data.qpos[2] += _CLIMB_M
    weight_n = model.body_subtreemass[world.vehicle_body_id] * np.linalg.norm(model.opt.gravity)
    data.xfrc_applied[world.vehicle_body_id, 2] = weight_n
    mujoco.mj_step(model, data, nstep=100)
    cpu_s = time.process_time()
    mujoco.mj_step(model, data, nstep=_N_STEPS)
    step_us = 1e6 * (time.process_time() - cpu_s) / _N_STEPS
    return lower("mj_step alone, airborne", step_us, "us")


def _recorded(cfg: SimBenchCfg, scene: Scene, *, camera_hz: int) -> Row:
    """Return the speed of the whole stack with a recording, optionally with both cameras in it."""
    # Per simulated second the figures stay comparable, although this flight is shorter.
    seconds = cfg.seconds * (_CAMERA_SHARE if camera_hz else 1.0)
    flight = _fly(cfg, scene, seconds, lambda bench, stack: _equip(bench, stack, camera_hz))
    suffix = f" and both cameras at {camera_hz} Hz" if camera_hz else ""
    return higher(f"whole stack with recording{suffix}", flight.sim_s / flight.cpu_s, _SPEED_UNIT)


def _equip(bench: Testbench, stack: ExitStack, camera_hz: int) -> Iterator[Observer]:
    """Yield observers that record a run to a temporary file."""
    from scenarios.recording import Recorder, RunInfo
    from scenarios.run.observation import shutter

    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="aeroscene-")))
    cfg = bench.cfg
    recorder = stack.enter_context(
        Recorder(
            folder / "bench.rrd",
            scene=bench.scene,
            primitives=scene_primitives(bench.scene),
            airframe=bench.airframe,
            info=RunInfo(scene=bench.scene.scene_id, vehicle=cfg.vehicle, seed=cfg.seed),
        )
    )
    yield lambda: recorder.on_tick(bench.plant, bench.autopilot)
    if camera_hz == 0:
        return
    cameras = stack.enter_context(Cameras(bench.plant))
    cameras.listen(recorder.first.log_frame)
    yield shutter(bench.vehicles[0], cameras, camera_hz)
