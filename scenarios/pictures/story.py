"""What pictures tell of a flight, wherever it comes from."""

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
"""A plan that begins this close to where another ends goes on from it."""


class PictureError(ValueError):
    """Pictures that cannot be drawn; says of what or where."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """Where the vehicle was, and where it was thought and meant to be; a row for each moment."""

    time_s: Float[np.ndarray, " n"]
    true_enu_m: Float[np.ndarray, "n 3"]
    est_enu_m: Float[np.ndarray, "n 3"]
    ref_enu_m: Float[np.ndarray, "n 3"]
    """What the controller followed; NaN while the rotors stood."""

    @property
    def speed_mps(self) -> Float[np.ndarray, " n"]:
        """Of the true positions."""
        if len(self.time_s) < 2:
            return np.zeros(len(self.time_s))
        return np.linalg.norm(np.gradient(self.true_enu_m, self.time_s, axis=0), axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class PlannedLeg:
    """A plan that was flown, or begun."""

    time_s: float
    """When it was taken up."""
    points_enu_m: Float[np.ndarray, "n 3"]
    """Along all of it, evenly in time."""
    step_s: float
    """From one of them to the next."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MoverPath:
    """Where something that moves by itself went."""

    name: str
    points_enu_m: Float[np.ndarray, "n 3"]


@dataclass(frozen=True, kw_only=True, eq=False)
class LandingLayers:
    """What the pilot knew of the ground when it landed; rows along north, columns along east."""

    east_m: Float[np.ndarray, " n"]
    north_m: Float[np.ndarray, " n"]
    height_m: Float[np.ndarray, "n n"]
    """NaN where nothing was seen, as in all layers."""
    slope_rad: Float[np.ndarray, "n n"]
    roughness_m: Float[np.ndarray, "n n"]
    clearance_m: Float[np.ndarray, "n n"]
    """Distance to the nearest cell that is unsafe or not allowed; 0 in those."""
    is_safe: Bool[np.ndarray, "n n"]
    """As ground; some of it may lie off the area or below something."""

    @classmethod
    def of(cls, landing: LandingMap) -> Self:
        """The layers of a map."""
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
    """Everything that the pictures of a flight show."""

    scene: Scene
    airframe: Airframe
    title: str
    """Which run, and how it ended."""
    track: Track
    phases: tuple[tuple[float, str], ...] = ()
    """When the pilot entered each phase, s, and its name."""
    plans: tuple[PlannedLeg, ...] = ()
    movers: tuple[MoverPath, ...] = ()
    area: InteractionArea | None = None
    """Where it wanted to land at last."""
    touchdown_enu_m: Vector3 | None = None
    """The point that it chose."""
    landing: LandingLayers | None = None

    def superseded(self) -> tuple[bool, ...]:
        """Of each plan, whether the next took over before it was flown to its end."""
        ends = [leg.points_enu_m[-1] for leg in self.plans]
        begins = [leg.points_enu_m[0] for leg in self.plans]
        gaps = [np.linalg.norm(begin - end) for end, begin in zip(ends, begins[1:], strict=False)]
        return (*(bool(gap > _JOINED_M) for gap in gaps), *([False] if self.plans else []))


def title_of(scene: Scene, airframe: Airframe, ending: str) -> str:
    """Which flight, and how it ended."""
    return f"{scene.scene_id} ({scene.domain}), {airframe.title}: {ending}"
