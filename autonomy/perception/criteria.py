"""Criteria of a landing site: each is defined once, for all cells of a map and in words.

The same definition judges a whole map at once and explains one refused place to a reader, so that
the two can never disagree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from autonomy.perception.needs import LandingNeeds

_SLOPE_SIGMAS = 2.0  # deviations of the slope that are added to it


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """The surroundings of a vehicle centred on each cell, or on one; NaN if unknown."""

    slope_rad: Float[np.ndarray, "*b"]
    """Slope of the plane under the feet."""
    slope_sigma_rad: Float[np.ndarray, "*b"]
    """Standard deviation of the slope due to the noise of depth."""
    roughness_m: Float[np.ndarray, "*b"]
    """Height range about the plane under the feet, less the part that noise may explain."""
    sigma_m: Float[np.ndarray, "*b"]
    """Standard deviation of the heights of the cells under the feet, root mean square."""
    rise_m: Float[np.ndarray, "*b"]
    """Greatest rise of anything within the body's radius above the plane; inf if unknown."""

    def at(self, cell: tuple[int, int]) -> Ground:
        """Surroundings centred on one cell."""
        return Ground(**{field.name: getattr(self, field.name)[cell] for field in fields(Ground)})


@dataclass(frozen=True, slots=True)
class Criterion:
    """One requirement of a landing site."""

    is_met: Callable[[Ground, LandingNeeds], Any]
    """Function that returns True for each cell that meets the criterion; False if that is unknown.
    """
    lack: Callable[[Ground, LandingNeeds], str]
    """Function that describes, in words, how a cell fails the criterion."""


def _slope(ground: Ground, needs: LandingNeeds) -> str:
    slope, doubt = math.degrees(ground.slope_rad), math.degrees(ground.slope_sigma_rad)
    most = math.degrees(needs.max_slope_rad)
    return f"slope {slope:.1f} deg, up to {_SLOPE_SIGMAS * doubt:.1f} more, at most {most:.1f}"


def _rise(ground: Ground, needs: LandingNeeds) -> str:
    if math.isinf(ground.rise_m):
        return f"not everything within {needs.body_radius_m:.2f} m was observed"
    rise, most = float(ground.rise_m), needs.max_rise_m
    return f"something rises {rise:.2f} m beside the vehicle, at most {most} m"


CRITERIA = (
    Criterion(
        lambda g, needs: g.slope_rad + _SLOPE_SIGMAS * g.slope_sigma_rad <= needs.max_slope_rad,
        _slope,
    ),
    Criterion(
        lambda g, needs: g.sigma_m <= needs.max_sigma_m,
        lambda g, needs: f"heights known to {g.sigma_m:.3f} m, needed {needs.max_sigma_m} m",
    ),
    Criterion(
        lambda g, needs: g.roughness_m <= needs.max_roughness_m,
        lambda g, needs: (
            f"height range {g.roughness_m:.2f} m under the feet, at most {needs.max_roughness_m} m"
        ),
    ),
    Criterion(lambda g, needs: g.rise_m <= needs.max_rise_m, _rise),
)
"""All criteria, in the order in which failures are reported."""


def is_safe(ground: Ground, needs: LandingNeeds) -> Bool[np.ndarray, "*b"]:
    """Return True for each cell on which the vehicle may stand."""
    return np.logical_and.reduce([criterion.is_met(ground, needs) for criterion in CRITERIA])


def first_lack(ground: Ground, needs: LandingNeeds) -> str | None:
    """Describe the first criterion that a cell fails; None if the cell is safe."""
    lacks = (each.lack(ground, needs) for each in CRITERIA if not each.is_met(ground, needs))
    return next(lacks, None)
