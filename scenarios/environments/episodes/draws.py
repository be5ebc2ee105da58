"""Random conditions of an episode besides its start and its target."""

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
    """True mass over the mass that the controller believes."""
    rotor_shares: Float[np.ndarray, " r"]
    """Thrust and torque of each rotor over those that the controller believes."""
    noise_level: float
    latency: int
    """Number of steps by which actions act later."""


def draw_conditions(
    rng: np.random.Generator, cfg: RandomisationCfg, longest_latency: int, n_rotors: int
) -> Draws:
    """Draw the conditions of an episode.

    The number of draws does not depend on the configuration, so that later draws stay the same if
    one source of variation is switched on or off.
    """
    plant_seed = int(rng.integers(2**31))
    speed_mps, from_deg = uniform(rng, 0.0, cfg.wind_mps), uniform(rng, 0.0, 360.0)
    wind = CALM
    if speed_mps > 0.0:
        # Natural turbulence grows with the wind.
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
    """Return what `rng.uniform(low, high)` draws, in half the time."""
    return low + (high - low) * rng.random()
