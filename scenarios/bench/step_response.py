"""Hover throttle and step responses of a vehicle, by the true state in still air."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.types import ControlLevel, Setpoint
from flightsim.plant import Plant, PlantCfg
from flightsim.plant.cfg import ADVANCE_HZ
from flightsim.world import World
from scenarios.bench.figure_eight import come_back, take_off

ROLL_RAD = math.radians(15.0)
ASIDE_M = 2.0
_SETTLE_S, _HOVER_S, _ROLL_S, _ASIDE_S = 4.0, 2.0, 0.8, 8.0
_SETTLED_M = 0.05


@dataclass(frozen=True, kw_only=True, slots=True)
class StepResponse:
    """Figures of a vehicle's response to a step of its attitude and to one of its position."""

    hover_throttle: float
    """Commanded collective thrust in hover, as a share of the greatest."""
    roll_rise_s: float
    """Time from 10 to 90 % of a step of the roll angle."""
    roll_overshoot: float
    """Roll beyond the step, as a share of the step."""
    aside_settled_s: float
    """Time after which it stays within 5 cm of a point 2 m aside."""
    aside_overshoot_m: float


def step_response(world: World, seed: int) -> StepResponse:
    """Fly the steps and return their figures.

    Args:
        world: World with nothing but a vehicle.
        seed: Seed of the plant.
    """
    plant = Plant(world, PlantCfg(seed=seed, state="truth"))
    hover_enu_m = take_off(plant)
    come_back(plant, hover_enu_m, _SETTLE_S)
    throttles = []
    for _ in range(round(_HOVER_S * ADVANCE_HZ)):
        plant.advance()
        throttles.append(plant.collective_thrust_fraction)
    throttle = float(np.mean(throttles))
    x, y, z = hover_enu_m
    aside = come_back(plant, (x, y + ASIDE_M, z), _ASIDE_S)
    away_m = np.linalg.norm(aside.error_true_m, axis=1)
    # Settled after the last moment outside, not after the first one inside.
    outside = np.flatnonzero(away_m > _SETTLED_M)
    come_back(plant, hover_enu_m, _ASIDE_S)
    # The attitude last, because the vehicle flies away while its roll is commanded.
    share = _roll(plant, throttle) / ROLL_RAD
    return StepResponse(
        hover_throttle=throttle,
        roll_rise_s=_rise_s(share, plant.cfg.control_hz),
        roll_overshoot=max(float(share.max()) - 1.0, 0.0),
        aside_settled_s=float(aside.time_s[outside[-1]]) if outside.size else 0.0,
        aside_overshoot_m=max(float(aside.error_true_m[:, 1].max()), 0.0),
    )


def _roll(plant: Plant, throttle: float) -> Float[np.ndarray, " n"]:
    """Return the roll angle at each control tick after a step of the attitude."""
    half = 0.5 * ROLL_RAD
    tilted = Setpoint(
        level=ControlLevel.ATTITUDE,
        quat_wxyz=(math.cos(half), math.sin(half), 0.0, 0.0),
        thrust=throttle,
    )
    rows = []
    for _ in range(round(_ROLL_S * ADVANCE_HZ)):
        plant.apply(tilted)
        plant.advance()
        rows.append(plant.history["quat_true_wxyz"].copy())
    w, x, y, z = np.concatenate(rows).T
    return np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x**2 + y**2))


def _rise_s(share: Float[np.ndarray, " n"], rate_hz: int) -> float:
    """Return the time between the first rows beyond 10 and 90 %, infinite without the latter."""
    low, high = (np.flatnonzero(share > level) for level in (0.1, 0.9))
    return float(high[0] - low[0]) / rate_hz if high.size else math.inf
