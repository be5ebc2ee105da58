"""Many plants at once, worlds by vehicles, advanced by one compiled call.

Learning and campaigns need thousands of vehicles. A loop of `Plant.advance` in Python would spend
most of its time outside of the kernel and use one core. Here all records lie in one array, and
several threads share its worlds inside one call that needs no lock of the interpreter.

A vehicle's motion depends only on its own world, its configuration and the setpoints there, bit for
bit. It does not depend on how many other worlds there are, nor on the number of threads.
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
from flightsim.plant.compilation import compile_kernels
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
            worlds: Worlds with equal numbers of vehicles and of rotors. A world that is named twice
                is flown twice, and the vehicles of both flights do not meet.
            cfgs: A configuration for the vehicles of each world; all have the same rates.
            n_threads: Number of threads that advance them; None takes one for each core.

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
        # The calling thread works too, hence one helper less; more than worlds would idle.
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
        """Return MuJoCo's present state of a vehicle's world; read it only.

        Args:
            index: Number of the vehicle, 0 to n - 1.
        """
        return self._datas[index // self.n_together]

    def advance(self) -> None:
        """Advance all vehicles by one call of `PlantCfg.advance_hz`; other threads may run.

        Raises:
            PhysicsDivergedError: If the physics engine had to give a state up.
        """
        # Noise is drawn for whole seconds; worlds may be at different times after `restart`.
        is_due = self._ticks % self._tick_hz == 0
        if is_due.any():
            self._draw(np.flatnonzero(is_due).tolist())
        self._engine["has_new_setpoint"] = 1
        self._counter[0] = 0
        self._share(lambda: advance(self._by_world, self._counter))
        self._check_physics(range(len(self)))

    def advance_one(self, world: int) -> None:
        """Advance one world alone, by its number; threads may do so at once with different worlds.

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
        """Call a function with each of some worlds, on all threads, and wait for the last one.

        Args:
            worlds: Numbers of the worlds; threads take the next one as they become free.
            work: Function of a world's number, such as `advance_one`.
        """
        # Threads take the next world from one iterator; the interpreter lock makes each step
        # atomic.
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
            seed: New seed of its vehicles, whose configuration otherwise stays.
            wind: New wind.
            held_at: Pose of each vehicle, position ENU and attitude body to world, in which it is
                held until `release`. By default vehicles stand at their starts.
            mass_shares: Mass and inertia of each vehicle over those that its controller believes.
                By default they stay as they are.
        """
        vehicles = self.vehicles_of(world)
        if mass_shares:
            self._load(world, mass_shares)
        model, data = self.worlds[vehicles.start].model, self._datas[world]
        mujoco.mj_setState(model, data, self._at_rest[world], _STATE)
        for i, pose in zip(vehicles, held_at, strict=False):
            self._memories[i].qpos[:] = [*pose[0], *pose[1]]
        # Readers need only the poses of geoms and lights before the next step; a full `mj_forward`
        # would also search for contacts.
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        for i in vehicles:
            self._memories[i].restart(seed)
        self._begin(world, wind)
        self._engine["is_held"][vehicles.start : vehicles.stop] = len(held_at) > 0

    def align(self, worlds: Sequence[int]) -> None:
        """Advance worlds, their vehicles at rest or held, until all their estimators are aligned.

        Raises:
            NotAlignedError: If one is not aligned within ten seconds.
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
        """Let go of the held vehicles of one world, with rotors at the speed of hover.

        Without that they would fall until the rotors have come up to speed.

        Args:
            world: Number of the world.
        """
        first = world * self.n_together
        vehicles = slice(first, first + self.n_together)
        for speeds_radps in self._rotors_at_hover:
            speeds_radps[vehicles] = self._hover_radps[vehicles]
        # The engine's clock stood still while the vehicles were held.
        self._datas[world].time = self._ticks[first] * self._tick_s
        self._engine["is_held"][vehicles] = 0

    def vehicles_of(self, world: int) -> range:
        """Return the numbers of the vehicles of a world."""
        return range(world * self.n_together, (world + 1) * self.n_together)

    def close(self) -> None:
        """End the threads; the fleet cannot advance afterwards."""
        if self._pool is not None:
            self._pool.shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _draw(self, indices: Iterable[int]) -> None:
        """Draw the noise of the next second of these vehicles.

        Each has a stream of its own, so it makes no difference which thread draws it.
        """
        waiting = iter(indices)

        def draw() -> None:
            for i in waiting:
                self._memories[i].draw_normals()

        self._share(draw)

    def _share(self, work: Callable[[], None]) -> None:
        """Let all threads run the same work, and wait for them.

        Args:
            work: Called once in each thread; the calls divide the work among themselves.
        """
        pool, n_helpers = self._pool, self._n_helpers
        if pool is None:
            work()
            return
        # `advance` clears MuJoCo's clock of stages and restores it at its end. With several threads
        # the first to end would restore it while others still step, so it is cleared here for all.
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
        """Return each world, as its first vehicle has it, with its state."""
        return zip(self.worlds[:: self.n_together], self._datas, strict=True)

    def _new_memories(self, cfgs: Sequence[PlantCfg]) -> list[PlantMemory]:
        surroundings: dict[tuple[int, Effects], Surroundings] = {}
        memories: list[PlantMemory] = []
        for i, (cfg, data) in enumerate(zip(cfgs, self._datas, strict=True)):
            vehicles = slice(i * self.n_together, (i + 1) * self.n_together)
            views, key = self.worlds[vehicles], (id(self.worlds[vehicles][0].scene), cfg.effects)
            if key not in surroundings:
                surroundings[key] = Surroundings.from_scene(views[0].scene, cfg.effects)
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
        """Set the wind and the setpoints, and write the starting poses into the log."""
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
        """Scale the masses of a world's vehicles, in a copy of the model that only it uses."""
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
        # Constants that MuJoCo derives from masses, such as inverse weights, must follow.
        mujoco.mj_setConst(model, self._datas[world])
        for i in vehicles:
            self.worlds[i] = replace(self.worlds[i], model=model)
            self._memories[i].load(self.worlds[i])


def _with_own_model(world: World) -> World:
    """Return the world, with a copy of its model if obstacles move in it.

    The kernel writes into the model which geoms may touch a mover at the moment, so worlds with
    movers cannot share a model.
    """
    return replace(world, model=copy.copy(world.model)) if world.obstacles else world


def _n_rotors(world: World) -> int:
    return len(world.airframe.quadrotor.rotors)


def _state_of(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Return the engine's complete state, from which its next steps follow."""
    state = np.empty(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, data, state, _STATE)
    return state
