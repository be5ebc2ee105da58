"""Recovery: a vehicle that is released in the air, at any attitude and rate, must come to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.types import IDLE, ControlLevel, Setpoint
from flightsim.plant import Plant, PlantCfg
from flightsim.plant.cfg import ADVANCE_HZ
from flightsim.world import World

HEIGHT_M = 150.0
"""Height of release above the ground."""
TRIAL_S = 8.0
_MAX_SPEED_MPS = 5.0
_MAX_RATE_RADPS = 15.0
"""Greatest rate of roll and pitch together."""
_MAX_YAW_RATE_RADPS = 5.0
_UPRIGHT_RAD = math.radians(30.0)
_AT_REST_RAD = math.radians(5.0)
_AT_REST_MPS = 0.3
_AT_REST_RADPS = 0.3
STAND_STILL = Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(0.0, 0.0, 0.0))


@dataclass(frozen=True, kw_only=True, slots=True)
class Recovery:
    """Result of one trial."""

    is_recovered: bool
    """True if it stood still, level and in the air at the end."""
    upright_s: float
    """Time after which the tilt stayed below 30 degrees."""
    height_lost_m: float
    start_tilt_rad: float


def recover(
    world: World, seed: int, rng: np.random.Generator, order: Setpoint = STAND_STILL
) -> Recovery:
    """Release a vehicle with idling rotors and observe it.

    The attitude is uniform over all rotations. The velocity is uniform in a ball of 5 m/s, the
    rates of roll and pitch in a disc of 15 rad/s. The yaw rate is uniform up to 5 rad/s, which half
    a second of yaw torque produces.

    Args:
        world: World with nothing but a vehicle.
        seed: Seed of the plant.
        rng: Source of the initial state.
        order: Setpoint of the vehicle.
    """
    plant = Plant(world, PlantCfg(seed=seed, state="truth"))
    _throw(plant, rng)
    # One tick with idling rotors, as if the vehicle was thrown.
    plant.apply(IDLE)
    plant.advance()
    heights, tilts = [], []
    start_tilt = _tilt(plant)
    for _ in range(round(TRIAL_S * ADVANCE_HZ)):
        plant.apply(order)
        plant.advance()
        heights.append(plant.truth.position_enu_m[2])
        tilts.append(_tilt(plant))
    # Upright from the tick after the last one that was tilted.
    tilted = [k for k, tilt in enumerate(tilts) if tilt > _UPRIGHT_RAD]
    return Recovery(
        is_recovered=_is_at_rest(plant),
        upright_s=(tilted[-1] + 1) / ADVANCE_HZ if tilted else 0.0,
        height_lost_m=HEIGHT_M - min(heights),
        start_tilt_rad=start_tilt,
    )


def _throw(plant: Plant, rng: np.random.Generator) -> None:
    model, body = plant.world.model, plant.world.vehicle_body_id
    q = model.jnt_qposadr[model.body_jntadr[body]]
    v = model.jnt_dofadr[model.body_jntadr[body]]
    # A normalised normal vector is uniform on the sphere of quaternions; the roots below make
    # rates uniform in a disc (square root) and velocities in a ball (cube root).
    quat = rng.normal(size=4)
    rate = _MAX_RATE_RADPS * math.sqrt(rng.uniform())
    about = rng.uniform(0.0, 2.0 * math.pi)
    direction = rng.normal(size=3)
    speed = _MAX_SPEED_MPS * rng.uniform() ** (1.0 / 3.0)
    plant.data.qpos[q : q + 7] = (0.0, 0.0, HEIGHT_M, *quat / np.linalg.norm(quat))
    plant.data.qvel[v : v + 3] = speed * direction / np.linalg.norm(direction)
    plant.data.qvel[v + 3 : v + 6] = (
        rate * math.cos(about),
        rate * math.sin(about),
        rng.uniform(-_MAX_YAW_RATE_RADPS, _MAX_YAW_RATE_RADPS),
    )


def _tilt(plant: Plant) -> float:
    _, x, y, _ = plant.truth.quat_wxyz
    return math.acos(min(max(1.0 - 2.0 * (x * x + y * y), -1.0), 1.0))


def _is_at_rest(plant: Plant) -> bool:
    truth = plant.truth
    return (
        plant.total_contact_ticks == 0
        and _tilt(plant) < _AT_REST_RAD
        and math.hypot(*truth.velocity_enu_mps) < _AT_REST_MPS
        and math.hypot(*truth.angular_rate_flu_radps) < _AT_REST_RADPS
    )
