"""Several vehicles in one world: one plant for each, and one physics for all.

Each vehicle has its record, its sensors with their noise, its history and its setpoints. They stand
in one state of the physics engine, so that they meet: they touch each other, and the rays of one
meet the others. What moves by itself is moved once, as the first vehicle's traffic says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flightsim.plant.cfg import NotAlignedError, PlantCfg, PlantError
from flightsim.plant.checks import check_together
from flightsim.plant.compiling import compile_kernels
from flightsim.plant.kernel import advance
from flightsim.plant.memory import PlantMemory, Surroundings
from flightsim.plant.plant import Plant
from flightsim.plant.record import PLANT_DTYPE
from flightsim.world import World


class VehicleGroup:
    """All vehicles of one world, which advance together.

    Deterministic like `Plant`: the first vehicle draws the noise that it would draw alone.

    Attributes:
        plants: Plant of each vehicle. Only the group advances them.
    """

    def __init__(self, worlds: Sequence[World], cfgs: Sequence[PlantCfg]) -> None:
        """Put the vehicles at rest at their starts.

        Args:
            worlds: The world as each of its vehicles has it, `World.views`.
            cfgs: A configuration for each; their rates are the same.

        Raises:
            PlantError: If these are not the vehicles of one world, or rates differ or do not fit.
        """
        _check(worlds, cfgs)
        compile_kernels()
        data = worlds[0].new_data()
        records = np.zeros(len(worlds), PLANT_DTYPE)
        around: dict[object, Surroundings] = {}
        lead: PlantMemory | None = None
        plants = []
        for i, (world, cfg) in enumerate(zip(worlds, cfgs, strict=True)):
            if cfg.effects not in around:
                around[cfg.effects] = Surroundings.of(world.scene, cfg.effects)
            memory = PlantMemory(
                world,
                cfg,
                data,
                plants=records[i : i + 1],
                surroundings=around[cfg.effects],
                lead=lead,
            )
            lead = lead or memory
            plants.append(Plant(world, cfg, memory=memory))
        self.plants = tuple(plants)
        self._records = records.reshape(1, -1)
        self._counter = np.zeros(1, np.int64)

    @property
    def time_us(self) -> int:
        """Simulated time of all."""
        return self.plants[0].time_us

    def advance(self) -> None:
        """Advance all vehicles by 20 ms, or what `PlantCfg.advance_hz` says.

        Raises:
            PhysicsDivergedError: If the physics engine had to give the state up.
        """
        for plant in self.plants:
            plant.begin_advance()
        self._counter[0] = 0
        advance(self._records, self._counter)
        for plant in self.plants:
            plant.end_advance()

    def align(self, timeout_s: float = 10.0) -> None:
        """Rest until the estimators of all are aligned, which takes about a second.

        Raises:
            NotAlignedError: If one is not within `timeout_s` of simulated time.
        """
        end_us = self.time_us + round(1e6 * timeout_s)
        while not all(plant.is_aligned for plant in self.plants):
            if self.time_us >= end_us:
                late = next(i for i, plant in enumerate(self.plants) if not plant.is_aligned)
                raise NotAlignedError(
                    f"vehicle {late + 1}: its estimator is not aligned after {timeout_s:g} s"
                )
            self.advance()


def _check(worlds: Sequence[World], cfgs: Sequence[PlantCfg]) -> None:
    if not worlds or len(worlds) != len(cfgs):
        raise PlantError(
            f"cfgs: {len(cfgs)} for {len(worlds)} vehicles: as many as vehicles are valid, at "
            "least one"
        )
    check_together(worlds)
    rates = {(cfg.physics_hz, cfg.control_hz, cfg.advance_hz) for cfg in cfgs}
    if len(rates) > 1:
        raise PlantError(f"cfgs: rates {sorted(rates)}: the same for all are valid")
    for world, cfg in zip(worlds, cfgs, strict=True):
        cfg.check(world.model.opt.timestep)
