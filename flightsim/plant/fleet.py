"""Many plants at once, worlds by vehicles, advanced by one compiled call.

What a vehicle does depends on its own world, its configuration and the setpoints there only, bit
for bit: not on how many other worlds there are, nor on the number of threads.
"""

from __future__ import annotations

import copy
import ctypes
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from typing import Self

import mujoco
import numpy as np

from autonomy.control.record import setpoint_row
from autonomy.types import OFF, Quaternion, Vector3
from flightsim.environment.effects import Effects
from flightsim.environment.wind import CALM, WindCfg
from flightsim.plant.cfg import NotAlignedError, PhysicsDivergedError, PlantCfg, PlantError
from flightsim.plant.checks import check_alike, check_worlds
from flightsim.plant.compiling import compile_kernels
from flightsim.plant.kernel import advance
from flightsim.plant.memory import PlantMemory, new_memories
from flightsim.plant.record import HISTORY_DTYPE, PLANT_DTYPE, with_rotors
from flightsim.plant.surroundings import Surroundings
from flightsim.world import World

_LONGEST_ALIGNMENT_S = 10.0
_OFF = setpoint_row(OFF)
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


class Fleet:
    """The vehicles of many worlds, as many in each, that advance together.

    Arrays have a row for each of n vehicles: those of the first world, then those of the second,
    and so on. The battery of a fleet's vehicle is always full.

    Attributes:
        n_together: Number of vehicles in each world.
        worlds: The world as each of the n vehicles has it; several may be the same.
        records: `PLANT_DTYPE` (n,), the state of all plants.
        history: `history_dtype` of r rotors (n, k), the last advance, a column for each of k
            control ticks.
        setpoints: `SETPOINT_DTYPE` (n,), to be written before `advance`.
        motor_speeds_radps: Speeds of the rotors (n, r) while the setpoint is `OFF`, to be written.
    """

    def __init__(
        self, worlds: Sequence[World], cfgs: Sequence[PlantCfg], *, n_threads: int | None = None
    ) -> None:
        """Put every vehicle at rest at its world's start.

        Args:
            worlds: Worlds with as many vehicles each, of as many rotors. One that is named twice is
                flown twice, and the vehicles of both flights do not meet.
            cfgs: A configuration for the vehicles of each world; their rates are the same.
            n_threads: Threads that advance them; None takes one for each core.

        Raises:
            PlantError: If there is no world, one has no vehicle, or rates or numbers of vehicles or
                rotors differ or do not fit.
        """
        check_worlds(worlds, cfgs)
        check_alike(worlds)
        if n_threads is not None and n_threads < 1:
            raise PlantError(f"n_threads = {n_threads}: 1 or more are valid")
        compile_kernels()
        self.worlds = [view for world in worlds for view in _with_own_model(world).views]
        self.n_together = worlds[0].n_vehicles
        n, rate = len(self.worlds), cfgs[0]
        self.records = np.zeros(n, PLANT_DTYPE)
        n_rotors = _n_rotors(self.worlds[0])
        self._log = np.zeros((n, rate.control_hz // rate.advance_hz), HISTORY_DTYPE)
        self.history = with_rotors(self._log, n_rotors)
        self._log_bytes = self._log.view(np.uint8).reshape(n, -1)
        self._first_position_enu_m = self.history["position_true_enu_m"][:, -1]
        self._first_quat_wxyz = self.history["quat_true_wxyz"][:, -1]
        self.setpoints = self.records["setpoint"]
        self.motor_speeds_radps = self.records["controller"]["given_speed_radps"][:, :n_rotors]
        self._rotors_at_hover = (
            self.records["rotors"]["speed_radps"][:, :n_rotors],
            self.records["controller"]["rotor_model_radps"][:, :n_rotors],
            self.history["rotor_speed_radps"][:, -1],
        )
        airframes = [world.airframe for world in self.worlds]
        self._hover_radps = np.array([[a.quadrotor.hover_speed_radps] for a in airframes])
        self._engine = self.records["engine"]
        self._ticks: np.ndarray = self._engine["tick"]
        self._tick_s, self._tick_hz = 1.0 / rate.control_hz, rate.control_hz
        self._counter = np.zeros(1, np.int64)
        self._by_world = self.records.reshape(-1, self.n_together)
        self._datas = [world.new_data() for world in self.worlds[:: self.n_together]]
        self._at_rest = [_state_of(world.model, data) for world, data in self._by_data()]
        self._has_own_model = [bool(world.obstacles) for world in worlds]
        self._memories = self._new_memories(cfgs)
        for i, cfg in enumerate(cfgs):
            self._begin(i, cfg.wind)
        n_helpers = min(n_threads or os.cpu_count() or 1, len(worlds)) - 1
        self._pool = ThreadPoolExecutor(n_helpers, "fleet") if n_helpers else None
        self._n_helpers = n_helpers
        self._clock = ctypes.c_void_p.from_address(int(self._engine["clock_address"][0]))

    def __len__(self) -> int:
        return len(self.worlds)

    @property
    def time_s(self) -> np.ndarray:
        """Simulated time of each vehicle (n,) since its own start."""
        return self._ticks * self._tick_s

    def data(self, index: int) -> mujoco.MjData:
        """MuJoCo's state of a vehicle's world now, for readers: not to be written to."""
        return self._datas[index // self.n_together]

    def advance(self) -> None:
        """Advance all vehicles by one call of `PlantCfg.advance_hz`; other threads may run.

        Raises:
            PhysicsDivergedError: If the physics engine had to give a state up.
        """
        is_due = self._ticks % self._tick_hz == 0
        if is_due.any():
            self._draw(np.flatnonzero(is_due).tolist())
        self._engine["has_new_setpoint"] = 1
        self._counter[0] = 0
        self._share(lambda: advance(self._by_world, self._counter))
        self._check_physics(range(len(self)))

    def advance_one(self, world: int) -> None:
        """Advance one world alone, by its number; several threads may do so with different ones.

        Raises:
            PhysicsDivergedError: If the physics engine had to give its state up.
        """
        vehicles = self.vehicles_of(world)
        if self._ticks[vehicles.start] % self._tick_hz == 0:
            for i in vehicles:
                self._memories[i].draw_normals()
        self._engine["has_new_setpoint"][vehicles.start : vehicles.stop] = 1
        advance(self._by_world[world : world + 1], np.zeros(1, np.int64))
        self._check_physics(vehicles)

    def share(self, worlds: Sequence[int], work: Callable[[int], None]) -> None:
        """Do the same work in several worlds, such as `advance_one`, on all threads."""
        waiting = iter(worlds)

        def take() -> None:
            for world in waiting:
                work(world)

        if len(worlds) > 1:
            self._share(take)
        else:
            take()

    def restart(
        self,
        world: int,
        seed: int,
        wind: WindCfg = CALM,
        *,
        held_at: Sequence[tuple[Vector3, Quaternion]] = (),
        mass_shares: Sequence[float] = (),
    ) -> None:
        """Begin anew in one world, its vehicles at rest and their rotors off.

        Args:
            world: Number of the world.
            seed: New seed of its vehicles, whose configuration is otherwise the old one.
            wind: New wind.
            held_at: Pose of each vehicle, ENU, body to world, where a hand holds it until
                `release`; by default they stand at their starts.
            mass_shares: Mass and inertia of each over those that its controller believes; by
                default they stay what they are.
        """
        vehicles = self.vehicles_of(world)
        if mass_shares:
            self._load(world, mass_shares)
        model, data = self.worlds[vehicles.start].model, self._datas[world]
        mujoco.mj_setState(model, data, self._at_rest[world], _STATE)
        for i, pose in zip(vehicles, held_at, strict=False):
            self._memories[i].qpos[:] = [*pose[0], *pose[1]]
        # All that anybody reads before the next step: where geoms and lights are.
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        for i in vehicles:
            self._memories[i].restart(seed)
        self._begin(world, wind)
        self._engine["is_held"][vehicles.start : vehicles.stop] = len(held_at) > 0

    def align(self, worlds: Sequence[int]) -> None:
        """Let the vehicles of worlds rest or be held until their estimators are aligned.

        Raises:
            NotAlignedError: If one is not within ten seconds.
        """
        if self._engine["knows_truth"][0] == 0:
            self.share(worlds, self._align)

    def _align(self, world: int) -> None:
        vehicles = self.vehicles_of(world)
        is_aligned = self.records["filter"]["is_aligned"][vehicles.start : vehicles.stop]
        for _ in range(round(_LONGEST_ALIGNMENT_S * self._tick_hz)):
            if is_aligned.all():
                return
            self.advance_one(world)
        raise NotAlignedError(f"world {world}: an estimator is not aligned after ten seconds")

    def release(self, world: int) -> None:
        """Let go of the vehicles of one world that are held, with rotors at the speed of hover."""
        first = world * self.n_together
        vehicles = slice(first, first + self.n_together)
        for speeds_radps in self._rotors_at_hover:
            speeds_radps[vehicles] = self._hover_radps[vehicles]
        self._datas[world].time = self._ticks[first] * self._tick_s
        self._engine["is_held"][vehicles] = 0

    def vehicles_of(self, world: int) -> range:
        """Numbers of the vehicles of a world."""
        return range(world * self.n_together, (world + 1) * self.n_together)

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _draw(self, indices: Iterable[int]) -> None:
        """Draw the noise of the next second of these vehicles; none cares which thread does."""
        waiting = iter(indices)

        def draw() -> None:
            for i in waiting:
                self._memories[i].draw_normals()

        self._share(draw)

    def _share(self, work: Callable[[], None]) -> None:
        """Let all threads do the same work, and wait for them."""
        pool, n_helpers = self._pool, self._n_helpers
        if pool is None:
            work()
            return
        # Nobody may restore MuJoCo's clock of stages while others still step.
        stage_clock, self._clock.value = self._clock.value, None
        try:
            helpers = [pool.submit(work) for _ in range(n_helpers)]
            try:
                work()
            finally:
                wait(helpers)
        finally:
            self._clock.value = stage_clock
        for helper in helpers:
            helper.result()

    def _check_physics(self, indices: range) -> None:
        is_lost = self._engine["is_lost"][indices.start : indices.stop]
        if is_lost.any():
            world = indices[int(is_lost.argmax())] // self.n_together
            raise PhysicsDivergedError(
                f"world {world}: the physics engine reset itself: the state had become infinite or "
                "not a number"
            )

    def _by_data(self) -> Iterator[tuple[World, mujoco.MjData]]:
        """Each world, as its first vehicle has it, and its state."""
        return zip(self.worlds[:: self.n_together], self._datas, strict=True)

    def _new_memories(self, cfgs: Sequence[PlantCfg]) -> list[PlantMemory]:
        surroundings: dict[tuple[int, Effects], Surroundings] = {}
        memories: list[PlantMemory] = []
        for i, (cfg, data) in enumerate(zip(cfgs, self._datas, strict=True)):
            vehicles = slice(i * self.n_together, (i + 1) * self.n_together)
            views, key = self.worlds[vehicles], (id(self.worlds[vehicles][0].scene), cfg.effects)
            if key not in surroundings:
                surroundings[key] = Surroundings.of(views[0].scene, cfg.effects)
            memories += new_memories(
                views,
                cfg,
                data,
                row=self._by_world[i],
                histories=self._log[vehicles],
                surroundings=surroundings[key],
            )
        return memories

    def _begin(self, world: int, wind: WindCfg) -> None:
        """Set the wind and the setpoints, and write the starts into the log."""
        vehicles = self.vehicles_of(world)
        self._log_bytes[vehicles.start : vehicles.stop] = 0
        for i in vehicles:
            memory = self._memories[i]
            if wind is not CALM:
                memory.set_wind(wind)
            memory.setpoint_flat[:] = _OFF
            self._first_position_enu_m[i] = memory.qpos[:3]
            self._first_quat_wxyz[i] = memory.qpos[3:]

    def _load(self, world: int, mass_shares: Sequence[float]) -> None:
        """Give vehicles a share of their masses, in a model of their world's own."""
        vehicles = self.vehicles_of(world)
        views = self.worlds[vehicles.start : vehicles.stop]
        masses_kg = [
            share * view.airframe.quadrotor.mass_kg
            for share, view in zip(mass_shares, views, strict=True)
        ]
        model = views[0].model
        bodies = [view.vehicle_body_id for view in views]
        if model.body_mass[bodies].tolist() == masses_kg:
            return
        if not self._has_own_model[world]:
            model, self._has_own_model[world] = copy.copy(model), True
        for body, mass_kg, share, view in zip(bodies, masses_kg, mass_shares, views, strict=True):
            model.body_mass[body] = mass_kg
            model.body_inertia[body] = share * np.array(view.airframe.quadrotor.inertia_flu_kgm2)
        mujoco.mj_setConst(model, self._datas[world])
        for i in vehicles:
            self.worlds[i] = replace(self.worlds[i], model=model)
            self._memories[i].load(self.worlds[i])


def _with_own_model(world: World) -> World:
    """The world, with a model of its own if something moves in it.

    The kernel writes into the model what may touch a mover just now.
    """
    return replace(world, model=copy.copy(world.model)) if world.obstacles else world


def _n_rotors(world: World) -> int:
    return len(world.airframe.quadrotor.rotors)


def _state_of(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """All that the engine's next steps follow from."""
    state = np.empty(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, data, state, _STATE)
    return state
