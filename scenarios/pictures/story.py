"""Story of a flight: the data of its pictures, from a run or from a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import InteractionArea, Scene
from autonomy.perception import LandingMap
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe

_JOINED_M = 0.05
"""Greatest distance from the end of a plan to the start of the next one that continues it."""


class PictureError(ValueError):
    """Pictures cannot be drawn; the message names the recording or the file."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """True, estimated and reference positions of the vehicle; a row for each moment."""

    time_s: Float[np.ndarray, " n"]
    true_enu_m: Float[np.ndarray, "n 3"]
    est_enu_m: Float[np.ndarray, "n 3"]
    ref_enu_m: Float[np.ndarray, "n 3"]
    """Reference of the controller; NaN while the rotors stood."""

    @property
    def speed_mps(self) -> Float[np.ndarray, " n"]:
        """Speed at the true positions."""
        if len(self.time_s) < 2:
            return np.zeros(len(self.time_s))
        return np.linalg.norm(np.gradient(self.true_enu_m, self.time_s, axis=0), axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class PlannedLeg:
    """Plan that was flown at least in part."""

    time_s: float
    """Time from which the plan was flown."""
    points_enu_m: Float[np.ndarray, "n 3"]
    """Points along the whole plan, evenly spaced in time."""
    step_s: float
    """Time from one point to the next."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MoverPath:
    """Path of a mover."""

    name: str
    points_enu_m: Float[np.ndarray, "n 3"]


@dataclass(frozen=True, kw_only=True, eq=False)
class LandingLayers:
    """The pilot's map of the ground at its landing; rows along north, columns along east."""

    east_m: Float[np.ndarray, " n"]
    north_m: Float[np.ndarray, " n"]
    height_m: Float[np.ndarray, "n n"]
    """Height of each cell; NaN where nothing was seen, as in all layers."""
    slope_rad: Float[np.ndarray, "n n"]
    roughness_m: Float[np.ndarray, "n n"]
    clearance_m: Float[np.ndarray, "n n"]
    """Distance to the nearest cell that is unsafe or not allowed; 0 in those."""
    is_safe: Bool[np.ndarray, "n n"]
    """True for safe ground, some of which may lie off the area or below something."""

    @classmethod
    def from_map(cls, landing: LandingMap) -> Self:
        """Return the layers of a pilot's map, as copies.

        Args:
            landing: Map, which the pilot may go on changing.
        """
        east_m, north_m = landing.axes_enu_m
        seen = landing.is_observed

        def known(layer: np.ndarray) -> np.ndarray:
            return np.where(seen, layer.astype(float), np.nan)

        return cls(
            east_m=east_m,
            north_m=north_m,
            height_m=known(landing.height_m),
            slope_rad=known(landing.slope_rad),
            roughness_m=known(landing.roughness_m),
            clearance_m=known(landing.clearance_m),
            is_safe=landing.is_safe & seen,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class FlightStory:
    """All data that the pictures of a flight show, whether from a run or from a recording."""

    scene: Scene
    airframe: Airframe
    title: str
    """Title with scene, vehicle and result of the run."""
    track: Track
    phases: tuple[tuple[float, str], ...] = ()
    """Time in s at which the pilot entered each phase, and the phase's name."""
    plans: tuple[PlannedLeg, ...] = ()
    movers: tuple[MoverPath, ...] = ()
    area: InteractionArea | None = None
    """Area that the pilot wanted to land on last."""
    touchdown_enu_m: Vector3 | None = None
    """Touchdown point that the pilot chose."""
    landing: LandingLayers | None = None

    def superseded(self) -> tuple[bool, ...]:
        """Return, for each plan, true if it was replaced before it was flown to its end."""
        # A plan that starts where the last one ends continues it; any other replaces it.
        ends = [leg.points_enu_m[-1] for leg in self.plans]
        begins = [leg.points_enu_m[0] for leg in self.plans]
        gaps = [np.linalg.norm(begin - end) for end, begin in zip(ends, begins[1:], strict=False)]
        return (*(bool(gap > _JOINED_M) for gap in gaps), *([False] if self.plans else []))


def title_of(scene: Scene, airframe: Airframe, ending: str) -> str:
    """Return the title of a flight.

    Args:
        scene: Scene of the flight.
        airframe: Vehicle.
        ending: Result in a few words.
    """
    return f"{scene.scene_id} ({scene.domain}), {airframe.title}: {ending}"
