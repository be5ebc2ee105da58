"""Many plants at once, in worlds of their own or several to a world, advanced by one compiled call.

What a vehicle does depends on its own world, its configuration and the setpoints there only, bit
for bit: not on how many other worlds there are, nor on the number of threads.
"""

from __future__ import annotations

import copy
import ctypes
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Self

import mujoco
import numpy as np

from autonomy.control.record import setpoint_row
from autonomy.types import OFF, Quaternion, Vector3
from flightsim.environment.effects import Effects
from flightsim.plant.cfg import NotAlignedError, PhysicsDivergedError, PlantCfg, PlantError
from flightsim.plant.checks import check_fleet
from flightsim.plant.compiling import compile_kernels
from flightsim.plant.kernel import advance
from flightsim.plant.memory import PlantMemory, Surroundings, with_own_models
from flightsim.plant.record import HISTORY_DTYPE, PLANT_DTYPE, with_rotors
from flightsim.world import World

_LONGEST_ALIGNMENT_S = 10.0


class Fleet:
    """Vehicles, each alone in its own world or with its mates, that advance together.

    The battery of a fleet's vehicle is always full.

    Attributes:
        worlds: World of each vehicle; several may be the same.
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
            worlds: A world for each vehicle, with as many rotors each; vehicles that share one do
                not meet. Where several do, all `World.views`, one world after another,
                of as many vehicles each.
            cfgs: A configuration for each; their rates are the same.
            n_threads: Threads that advance them; None takes one for each core.

        Raises:
            PlantError: If there is no world, one has no vehicle, or rates or numbers of rotors
                differ or do not fit.
        """
        check_fleet(worlds, cfgs, n_threads)
        compile_kernels()
        # The kernel writes into the model what may touch a mover just now.
        self.worlds = with_own_models(worlds)
        n, rate = len(worlds), cfgs[0]
        self.records = np.zeros(n, PLANT_DTYPE)
        n_rotors = _n_rotors(self.worlds[0])
        self._log = np.zeros((n, rate.control_hz // rate.advance_hz), HISTORY_DTYPE)
        self.history = with_rotors(self._log, n_rotors)
        self.setpoints = self.records["setpoint"]
        self.motor_speeds_radps = self.records["controller"]["given_speed_radps"][:, :n_rotors]
        self._engine = self.records["engine"]
        self._ticks: np.ndarray = self._engine["tick"]
        self._tick_s, self._tick_hz = 1.0 / rate.control_hz, rate.control_hz
        self._counter = np.zeros(1, np.int64)
        self._surroundings: dict[tuple[int, Effects], Surroundings] = {}
        self._n_mates = self.worlds[0].n_vehicles
        self._by_world = self.records.reshape(-1, self._n_mates)
        datas = [world.new_data() for world in self.worlds[:: self._n_mates]]
        self._datas = [data for data in datas for _ in range(self._n_mates)]
        self._memories: dict[int, PlantMemory] = {}
        for i, cfg in enumerate(cfgs):
            self._begin(i, cfg)
        n_helpers = min(n_threads or os.cpu_count() or 1, len(datas)) - 1
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
        return self._datas[index]

    def advance(self) -> None:
        """Advance all vehicles by one call of `PlantCfg.advance_hz`; other threads may run.

        Raises:
            PhysicsDivergedError: If the physics engine had to give a state up.
        """
        if (due := np.flatnonzero(self._ticks % self._tick_hz == 0)).size:
            self._draw(due.tolist())
        self._engine["has_new_setpoint"] = 1
        self._counter[0] = 0
        # Nobody may restore MuJoCo's clock of stages while others still step.
        stage_clock, self._clock.value = self._clock.value, None
        try:
            self._share(lambda: advance(self._by_world, self._counter))
        finally:
            self._clock.value = stage_clock
        self._check_physics(range(len(self)))

    def advance_one(self, index: int) -> None:
        """Advance the world of one vehicle alone.

        Raises:
            PhysicsDivergedError: If the physics engine had to give its state up.
        """
        mates = self._mates(index)
        if self._ticks[index] % self._tick_hz == 0:
            self._draw(mates)
        self._engine["has_new_setpoint"][mates] = 1
        self._counter[0] = 0
        advance(self.records[mates.start : mates.stop].reshape(1, -1), self._counter)
        self._check_physics(mates)

    def restart(
        self,
        index: int,
        cfg: PlantCfg,
        *,
        held_at: tuple[Vector3, Quaternion] | None = None,
        mass_share: float = 1.0,
    ) -> None:
        """Begin anew with one vehicle, at rest and with its rotors off.

        Args:
            index: Number of the vehicle.
            cfg: Its new configuration, with the rates of the old one.
            held_at: Pose, ENU, body to world, where a hand holds it until `release`; None stands it
                at the start.
            mass_share: Its mass and inertia over those that its controller believes.
        """
        held = None if held_at is None else [held_at]
        self.restart_world(index, [cfg], held_at=held, mass_shares=[mass_share])

    def restart_world(
        self,
        index: int,
        cfgs: Sequence[PlantCfg],
        *,
        held_at: Sequence[tuple[Vector3, Quaternion]] | None = None,
        mass_shares: Sequence[float] | None = None,
    ) -> None:
        """Begin anew with all vehicles of the world of one; the arguments are those of `restart`.

        Raises:
            PlantError: If there are not as many configurations as vehicles in that world.
        """
        mates = self._mates(index)
        if len(cfgs) != len(mates):
            raise PlantError(f"cfgs: {len(cfgs)}; one for each of {len(mates)} vehicles is valid")
        for i, share in zip(mates, mass_shares or (), strict=False):
            self._load(i, share)
        world, data = self.worlds[index], self._datas[index]
        mujoco.mj_resetData(world.model, data)
        data.qpos[:] = world.rest_qpos
        for i, pose in zip(mates, held_at or (), strict=False):
            first = self.worlds[i].qpos_address
            data.qpos[first : first + 7] = [*pose[0], *pose[1]]
        mujoco.mj_forward(world.model, data)
        self.records[mates.start : mates.stop].view(np.uint8).fill(0)
        for i, cfg in zip(mates, cfgs, strict=True):
            self._begin(i, cfg)
            self._engine["is_held"][i] = held_at is not None

    def is_touching(self, index: int) -> bool:
        """Whether a vehicle that was just put somewhere touches or is inside something there."""
        return self._datas[index].ncon > 0

    def align(self, index: int) -> None:
        """Let one vehicle, and its mates, rest or be held until its estimator is aligned.

        Raises:
            NotAlignedError: If it is not within ten seconds.
        """
        if self._engine["knows_truth"][index] == 1:
            return
        for _ in range(round(_LONGEST_ALIGNMENT_S * self._tick_hz)):
            if self.records["filter"]["is_aligned"][index] == 1:
                return
            self.advance_one(index)
        raise NotAlignedError(f"vehicle {index}: its estimator is not aligned after ten seconds")

    def release(self, index: int) -> None:
        """Let go of one vehicle that is held, with its rotors at the speed of hover.

        Mates fall or fly only after each has been let go of.
        """
        speed_radps = self.worlds[index].airframe.quadrotor.hover_speed_radps
        n_rotors = _n_rotors(self.worlds[index])
        self.records["rotors"]["speed_radps"][index, :n_rotors] = speed_radps
        self.records["controller"]["rotor_model_radps"][index, :n_rotors] = speed_radps
        self.history["rotor_speed_radps"][index] = speed_radps
        self._datas[index].time = self._ticks[index] * self._tick_s
        self._engine["is_held"][index] = 0

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
        helpers = [pool.submit(work) for _ in range(n_helpers)] if pool else []
        work()
        for helper in helpers:
            helper.result()

    def _check_physics(self, indices: range) -> None:
        is_lost = self._engine["is_lost"][indices.start : indices.stop]
        if is_lost.any():
            raise PhysicsDivergedError(
                f"world {indices[int(is_lost.argmax())]}: the physics engine reset itself: the "
                "state had become infinite or not a number"
            )

    def _mates(self, index: int) -> range:
        """All vehicles in the world of one."""
        first = index - index % self._n_mates
        return range(first, first + self._n_mates)

    def _begin(self, index: int, cfg: PlantCfg) -> None:
        """Fill the record, set wind and setpoint, and write the start into the log."""
        world = self.worlds[index]
        key = id(world.scene), cfg.effects
        if key not in self._surroundings:
            self._surroundings[key] = Surroundings.of(world.scene, cfg.effects)
        first = index - index % self._n_mates
        memory = self._memories[index] = PlantMemory(
            world,
            cfg,
            self._datas[index],
            plants=self.records[index : index + 1],
            history=self._log[index],
            surroundings=self._surroundings[key],
            lead=None if index == first else self._memories[first],
        )
        memory.set_wind(cfg.wind)
        memory.setpoint_flat[:] = setpoint_row(OFF)
        self._log[index : index + 1].view(np.uint8).fill(0)
        row: np.void = self.history[index, -1]
        row["position_true_enu_m"], row["quat_true_wxyz"] = memory.qpos[:3], memory.qpos[3:]

    def _load(self, index: int, mass_share: float) -> None:
        """Give a vehicle a share of its mass, in a model of its world's own."""
        world = self.worlds[index]
        quadrotor, body = world.airframe.quadrotor, world.vehicle_body_id
        mass_kg = mass_share * quadrotor.mass_kg
        if world.model.body_mass[body] == mass_kg:
            return
        model = copy.copy(world.model)
        model.body_mass[body] = mass_kg
        model.body_inertia[body] = mass_share * np.array(quadrotor.inertia_flu_kgm2)
        mujoco.mj_setConst(model, self._datas[index])
        for i in self._mates(index):
            self.worlds[i] = replace(self.worlds[i], model=model)


def _n_rotors(world: World) -> int:
    return len(world.airframe.quadrotor.rotors)
