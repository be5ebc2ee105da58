"""Task of one plan through a place that is only partly seen."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Float, Int

from autonomy.mapping.agenda import Agenda
from autonomy.mapping.seen_map import SeenMap
from autonomy.planning.craft import Craft
from autonomy.planning.errors import CertificateError
from autonomy.planning.limits import MIN_ACCELERATION_MPS2, FlightLimits
from autonomy.planning.planner import plan_trajectory
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference, Vector3

_AROUND_M = 2.0
"""Margin about the way to fly that the plan may use."""
_CALM = 0.5
_AT_REST_MPS = 0.3
_AT_REST_MPS2 = 0.5
_AT_REST_RADPS = 0.2


@dataclasses.dataclass(frozen=True, slots=True)
class Task:
    """State, goal, map and agenda of a vehicle for one plan."""

    seen: SeenMap
    agenda: Agenda
    start: FlatReference
    goal_enu_m: Vector3
    craft: Craft

    @property
    def needed_m(self) -> float:
        """Least distance from a way to everything that was not seen free."""
        return self.craft.cfg.vehicle_radius_m + self.craft.cfg.margins_m[-1]

    @property
    def start_cell(self) -> Int[np.ndarray, " 3"]:
        """Cell that the vehicle is in."""
        return self.seen.cells(np.array(self.start.position_enu_m))

    @property
    def is_moving(self) -> bool:
        """Whether the vehicle still flies or turns."""
        start = self.start
        return (
            math.hypot(*start.velocity_enu_mps) > _AT_REST_MPS
            or math.hypot(*start.acceleration_enu_mps2) > _AT_REST_MPS2
            or abs(start.yaw_rate_radps) > _AT_REST_RADPS
        )

    def point(self, cell: Int[np.ndarray, " 3"]) -> Vector3:
        """Centre of a cell, ENU, m."""
        x, y, z = self.seen.centres(cell).tolist()
        return (x, y, z)

    def away_m(self, point_enu_m: Vector3) -> float:
        """Distance of a place from the vehicle."""
        return math.dist(point_enu_m, self.start.position_enu_m)

    def fly(self, path: Int[np.ndarray, "n 3"], goal_enu_m: Vector3) -> Trajectory:
        """Plan a trajectory about a way through seen free space.

        Raises:
            PlanningError: If there is no trajectory, or it cannot be proved.
        """
        block = self.seen.block_about(path, _AROUND_M)
        field, obstacles = self.seen.field_in(block), self.seen.obstacles_in(block)
        world = (goal_enu_m, field, obstacles)
        try:
            return plan_trajectory(self.start, *world, self.craft)
        except CertificateError:
            if self.is_moving:
                raise
        calmer = dataclasses.replace(self.craft, limits=_calmer(self.craft.limits))
        return plan_trajectory(self.start, *world, calmer)

    def proved(self, trajectory: Trajectory, margin_m: float = 0.0) -> Trajectory:
        """Certify that a trajectory from the vehicle's position keeps to seen free space.

        Raises:
            CertificateError: If the trajectory does not, or breaks a limit.
        """
        block = self.seen.block_about(self.start_cell[None], 2 * _AROUND_M)
        return self.craft.prove(trajectory, self.seen.obstacles_in(block), margin_m=margin_m)


def _calmer(limits: FlightLimits) -> FlightLimits:
    """Limits for a short way among clutter, calmer than those of the vehicle."""
    return dataclasses.replace(
        limits,
        acceleration_mps2=max(_CALM * limits.acceleration_mps2, MIN_ACCELERATION_MPS2),
        acceleration_vertical_mps2=max(
            _CALM * limits.acceleration_vertical_mps2, MIN_ACCELERATION_MPS2
        ),
    )


def in_words(point: Vector3 | Float[np.ndarray, " 3"]) -> str:
    """Text of a position, for messages."""
    return f"({point[0]:.2f}, {point[1]:.2f}, {point[2]:.2f}) m"
