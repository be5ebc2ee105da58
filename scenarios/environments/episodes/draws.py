"""What differs from one episode to the next besides where it begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flightsim.environment.wind import CALM, SIGMA_OVER_W20, WindCfg
from scenarios.environments.cfg import RandomisationCfg


@dataclass(frozen=True, kw_only=True, eq=False)
class Draws:
    """Conditions of one episode."""

    plant_seed: int
    wind: WindCfg
    mass_share: float
    """Mass over the one that the controller believes."""
    rotor_shares: Float[np.ndarray, " r"]
    """Thrust and torque of each rotor, likewise."""
    noise_level: float
    latency: int
    """Steps by which actions act later."""


def draw_conditions(
    rng: np.random.Generator, cfg: RandomisationCfg, longest_latency: int, n_rotors: int
) -> Draws:
    """Draw the conditions of an episode; as many numbers whatever is configured."""
    plant_seed = int(rng.integers(2**31))
    speed_mps, from_deg = uniform(rng, 0.0, cfg.wind_mps), uniform(rng, 0.0, 360.0)
    wind = CALM
    if speed_mps > 0.0:
        sigma_mps = SIGMA_OVER_W20 * speed_mps
        wind = WindCfg(speed_mps=speed_mps, from_deg=from_deg, turbulence_mps=sigma_mps)
    return Draws(
        plant_seed=plant_seed,
        wind=wind,
        mass_share=1.0 + uniform(rng, -cfg.mass, cfg.mass),
        rotor_shares=1.0 + rng.uniform(-cfg.rotors, cfg.rotors, n_rotors),
        noise_level=uniform(rng, 0.0, cfg.noise),
        latency=int(rng.integers(1 + longest_latency)),
    )


def uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """What `rng.uniform(low, high)` draws, in half the time."""
    return low + (high - low) * rng.random()
