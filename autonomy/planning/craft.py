"""The craft that flies: its limits, its mass and thrust, and the settings of its plans.

Planning, replanning and braking all need the same three things, so they travel as one `Craft`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal, get_args

from autonomy.model.quadrotor import QuadrotorParams
from autonomy.planning.certificate import certify
from autonomy.planning.errors import PlanningError
from autonomy.planning.limits import FlightLimits
from autonomy.planning.moving_obstacles import NOTHING_MOVES, MovingObstacles
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.trajectory import Trajectory

Method = Literal["optimise", "primitives"]
"""How a trajectory is made from a path: optimise space and time over a corridor, or string motion
primitives (Mueller 2015)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PlannerCfg:
    """Settings of a plan.

    Raises `PlanningError` if a setting makes plans impossible.
    """

    vehicle_radius_m: float
    """Radius of a sphere about the centre of mass that holds the vehicle."""
    method: Method = "optimise"
    margins_m: tuple[float, ...] = (0.6, 0.4, 0.25, 0.15)
    """Distances from that sphere to obstacles, tried in turn; the first that gives a plan is used.
    """
    min_margin_m: float = 0.05
    """Distance that the proof demands beyond the sphere."""
    comfortable_m: float = 1.5
    """Beyond this distance to the sphere, closeness to obstacles has no price in the search."""
    max_piece_m: float = 12.0
    """Length above which a leg is flown in several pieces."""
    search_excess: float = 0.0
    """Share by which the searched path may cost more than the cheapest one; a small share shortens
    a long search."""
    min_pieces: int = 1
    """Least number of pieces. More pieces can bend more often but take longer to plan."""

    def __post_init__(self) -> None:
        """Refuse settings by which no plan can be made."""
        checks = {
            "vehicle_radius_m": (0 < self.vehicle_radius_m < math.inf, "a positive number"),
            "method": (self.method in get_args(Method), "'optimise' or 'primitives'"),
            "margins_m": (
                len(self.margins_m) > 0 and all(0 <= m < math.inf for m in self.margins_m),
                "one or more, none negative",
            ),
            "min_margin_m": (0 <= self.min_margin_m < math.inf, "not negative"),
            "max_piece_m": (self.max_piece_m > 0, "a positive number"),
            "search_excess": (0 <= self.search_excess < math.inf, "not negative"),
        }
        for name, (is_valid, valid) in checks.items():
            if not is_valid:
                raise PlanningError(f"{name} {getattr(self, name)!r} is not valid; valid: {valid}")


@dataclass(frozen=True, slots=True)
class Craft:
    """The vehicle that a plan is made for."""

    limits: FlightLimits
    """Limits of the motion."""
    quadrotor: QuadrotorParams
    """Mass, thrust and drag."""
    cfg: PlannerCfg
    """Size, margins and method."""

    @property
    def keep_m(self) -> float:
        """Distance from the centre of mass to obstacles that the proof demands, m."""
        return self.cfg.vehicle_radius_m + self.cfg.min_margin_m

    def prove(
        self,
        trajectory: Trajectory,
        obstacles: Obstacles,
        *,
        moving: MovingObstacles = NOTHING_MOVES,
        margin_m: float | None = None,
    ) -> Trajectory:
        """Certify a trajectory and return it with its proved clearance.

        Args:
            trajectory: Trajectory to prove.
            obstacles: Static obstacles.
            moving: Moving obstacles, predicted from the trajectory's beginning on.
            margin_m: Distance that the vehicle's sphere must keep; None for `min_margin_m`.

        Raises:
            CertificateError: If the trajectory breaks the clearance or a limit.
        """
        proof = certify(
            trajectory,
            obstacles,
            self.cfg.vehicle_radius_m,
            self.limits,
            self.quadrotor,
            margin_m=self.cfg.min_margin_m if margin_m is None else margin_m,
            moving=moving,
        )
        return dataclasses.replace(trajectory, min_clearance_m=proof.min_clearance_m)
