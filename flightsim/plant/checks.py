"""What a plant refuses: worlds of other vehicles than its own, setpoints that are not finite."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from autonomy.types import Setpoint
from flightsim.plant.cfg import NotAlignedError, PlantCfg, PlantError
from flightsim.world import World


def unaligned(setpoint: Setpoint, time_us: int) -> NotAlignedError:
    """The refusal of a setpoint that comes before the estimator is aligned."""
    return NotAlignedError(
        f"setpoint at level {setpoint.level.name} after {1e-6 * time_us:.2f} s: the "
        "estimator is not aligned yet; valid: OFF and IDLE, or call align() before"
    )


def check_alone(world: World) -> None:
    """Refuse a world without a vehicle, and one whose vehicles advance together.

    Raises:
        PlantError: Naming what would be valid.
    """
    if world.vehicle_body_id < 0:
        raise PlantError("world: it has no vehicle, build it with an airframe")
    if world.n_vehicles > 1:
        raise PlantError(f"world: it has {world.n_vehicles} vehicles; a VehicleGroup is valid")


def check_together(worlds: Sequence[World]) -> None:
    """Refuse worlds that are not one world as each of its vehicles has it, in their order.

    Raises:
        PlantError: Naming how many of which vehicles there are, and what would be valid.
    """
    numbers, n = [world.number for world in worlds], worlds[0].n_vehicles
    is_one = all(world.model is worlds[0].model for world in worlds)
    if not is_one or numbers != list(range(n)):
        raise PlantError(f"worlds: vehicles {numbers} of a world of {n}: all World.views are valid")


def check_fleet(worlds: Sequence[World], cfgs: Sequence[PlantCfg], n_threads: int | None) -> None:
    """Refuse worlds and configurations that no fleet can be made of; see `Fleet`.

    Raises:
        PlantError: Naming what would be valid.
    """
    if not worlds or len(worlds) != len(cfgs):
        raise PlantError(
            f"cfgs: {len(cfgs)} for {len(worlds)} worlds: as many as worlds are valid, at least one"
        )
    if n_threads is not None and n_threads < 1:
        raise PlantError(f"n_threads = {n_threads}: 1 or more are valid")
    rates = {(cfg.physics_hz, cfg.control_hz, cfg.advance_hz) for cfg in cfgs}
    if len(rates) > 1:
        raise PlantError(f"cfgs: rates {sorted(rates)}: the same for all are valid")
    numbers = sorted({len(world.airframe.quadrotor.rotors) for world in worlds})
    if len(numbers) > 1:
        raise PlantError(f"worlds: vehicles with {numbers} rotors: the same number is valid")
    for i, (world, cfg) in enumerate(zip(worlds, cfgs, strict=True)):
        if world.vehicle_body_id < 0:
            raise PlantError(f"world {i}: it has no vehicle, build it with an airframe")
        cfg.check(world.model.opt.timestep)
    n_mates = max(1, worlds[0].n_vehicles)
    for first in range(0, len(worlds), n_mates):
        check_together(worlds[first : first + n_mates])


def normalised(setpoint: Setpoint) -> Setpoint | None:
    """The same attitude or rate setpoint with a unit quaternion, None if it is not finite."""
    w, x, y, z = setpoint.quat_wxyz
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    total = setpoint.thrust + norm + sum(setpoint.angular_rate_flu_radps)
    if not math.isfinite(total) or norm < 1e-3:
        return None
    return replace(setpoint, quat_wxyz=(w / norm, x / norm, y / norm, z / norm))
