"""Checks of a plant's inputs: worlds that fit together, and finite setpoints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from autonomy.types import Setpoint
from flightsim.plant.cfg import NotAlignedError, PlantCfg, PlantError
from flightsim.world import World


def unaligned(setpoint: Setpoint, time_us: int) -> NotAlignedError:
    """Return the error for a setpoint that comes before the estimator is aligned."""
    return NotAlignedError(
        f"setpoint at level {setpoint.level.name} after {1e-6 * time_us:.2f} s: the "
        "estimator is not aligned yet; valid: OFF and IDLE, or call align() before"
    )


def check_worlds(worlds: Sequence[World], cfgs: Sequence[PlantCfg]) -> None:
    """Refuse worlds and configurations from which no plants can be made; see `Plant` and `Fleet`.

    Raises:
        PlantError: If their numbers or rates differ, or a world has no vehicle or is another's
            view.
    """
    if not worlds or len(worlds) != len(cfgs):
        raise PlantError(
            f"cfgs: {len(cfgs)} for {len(worlds)} worlds: as many as worlds are valid, at least one"
        )
    rates = {(cfg.physics_hz, cfg.control_hz, cfg.advance_hz) for cfg in cfgs}
    if len(rates) > 1:
        raise PlantError(f"cfgs: rates {sorted(rates)}: the same for all are valid")
    for i, (world, cfg) in enumerate(zip(worlds, cfgs, strict=True)):
        if not world.vehicles:
            raise PlantError(f"world {i}: it has no vehicle, build it with an airframe")
        if world.number:
            raise PlantError(
                f"world {i}: it is the view of vehicle {world.number + 1}; what build_world "
                "returns is valid"
            )
        cfg.check(world.model.opt.timestep)


def check_alike(worlds: Sequence[World]) -> None:
    """Refuse worlds whose vehicles do not fit into the arrays of one `Fleet`.

    Raises:
        PlantError: If the numbers of vehicles or of their rotors differ.
    """
    each = [vehicle for world in worlds for vehicle in world.vehicles]
    for what, numbers in (
        ("rotors", {len(vehicle.airframe.quadrotor.rotors) for vehicle in each}),
        ("vehicles", {world.n_vehicles for world in worlds}),
    ):
        if len(numbers) > 1:
            raise PlantError(f"worlds: {sorted(numbers)} {what}: the same number is valid")


def normalised(setpoint: Setpoint) -> Setpoint | None:
    """Return an attitude or rate setpoint with a unit quaternion, or None if it is not finite."""
    w, x, y, z = setpoint.quat_wxyz
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    # One infinite or NaN summand makes the sum infinite or NaN, so one test covers all numbers.
    total = setpoint.thrust + norm + sum(setpoint.angular_rate_flu_radps)
    if not math.isfinite(total) or norm < 1e-3:
        return None
    return replace(setpoint, quat_wxyz=(w / norm, x / norm, y / norm, z / norm))
