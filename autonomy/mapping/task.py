"""Task of one plan through a place that is only partly seen.

The parts of exploring (`exploring`, `errands`, `gestures`) share this task: it answers where the
vehicle is and what it needs, and makes or proves trajectories against what was seen.
"""

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
"""Margin around the path within which the plan may run."""
_CALM = 0.5
"""Share of the acceleration limits for a second try."""
_AT_REST_MPS = 0.3
"""Bounds of speed, acceleration and yaw rate below which the vehicle counts as at rest."""
_AT_REST_MPS2 = 0.5
_AT_REST_RADPS = 0.2


@dataclasses.dataclass(frozen=True, slots=True)
class Task:
    """State, goal, map and agenda of a vehicle for one plan."""

    seen: SeenMap
    agenda: Agenda
    start: FlatReference
    """State from which the plan begins."""
    goal_enu_m: Vector3
    craft: Craft

    @property
    def needed_m(self) -> float:
        """Least distance of a path to everything that was not seen free, m.

        It is the vehicle's sphere and the smallest margin with which the planner still tries.
        """
        return self.craft.cfg.vehicle_radius_m + self.craft.cfg.margins_m[-1]

    @property
    def start_cell(self) -> Int[np.ndarray, " 3"]:
        """Index of the cell that the vehicle is in."""
        return self.seen.cells(np.array(self.start.position_enu_m))

    @property
    def goal_cell(self) -> Int[np.ndarray, " 3"]:
        """Index of the cell that the goal is in."""
        return self.seen.cells(np.array(self.goal_enu_m))

    @property
    def is_moving(self) -> bool:
        """True if the vehicle still flies or turns.

        Nods and looks begin at rest, and calmer limits suit a start at rest alone.
        """
        start = self.start
        return (
            math.hypot(*start.velocity_enu_mps) > _AT_REST_MPS
            or math.hypot(*start.acceleration_enu_mps2) > _AT_REST_MPS2
            or abs(start.yaw_rate_radps) > _AT_REST_RADPS
        )

    def point(self, cell: Int[np.ndarray, " 3"]) -> Vector3:
        """Return the centre of a cell, ENU, m."""
        x, y, z = self.seen.centres(cell).tolist()
        return (x, y, z)

    def away_m(self, point_enu_m: Vector3) -> float:
        """Return the distance of a place from the vehicle, m."""
        return math.dist(point_enu_m, self.start.position_enu_m)

    def fly(self, path: Int[np.ndarray, "n 3"], goal_enu_m: Vector3) -> Trajectory:
        """Plan a trajectory along a path through seen free space.

        If the vehicle is at rest and no plan can be proved, a calmer one is tried: it keeps nearer
        to the path.

        Args:
            path: Cells of the path.
            goal_enu_m: Position at which the plan comes to rest.

        Raises:
            PlanningError: If there is no trajectory, or it cannot be proved.
        """
        # The corridor and the proof stay within this block; all outside counts as an obstacle.
        block = self.seen.block_about(path, _AROUND_M)
        field, obstacles = self.seen.field_in(block), self.seen.obstacles_in(block)
        world = (goal_enu_m, field, obstacles)
        try:
            return plan_trajectory(self.start, *world, self.craft)
        except CertificateError:
            # In flight the start may already be beyond calmer limits.
            if self.is_moving:
                raise
        calmer = dataclasses.replace(self.craft, limits=_calmer(self.craft.limits))
        return plan_trajectory(self.start, *world, calmer)

    def proved(self, trajectory: Trajectory, margin_m: float = 0.0) -> Trajectory:
        """Certify that a short trajectory from the vehicle's position keeps to seen free space.

        Args:
            trajectory: Motion of at most 4 m from the vehicle's cell along each axis.
            margin_m: Distance beyond the vehicle's sphere to keep.

        Returns:
            The trajectory with its clearance.

        Raises:
            CertificateError: If the trajectory does not, or breaks a limit.
        """
        block = self.seen.block_about(self.start_cell[None], 2 * _AROUND_M)
        return self.craft.prove(trajectory, self.seen.obstacles_in(block), margin_m=margin_m)


def _calmer(limits: FlightLimits) -> FlightLimits:
    """Return limits for a short path among clutter, calmer than those of the vehicle.

    The planner accepts no acceleration below `MIN_ACCELERATION_MPS2`.
    """
    return dataclasses.replace(
        limits,
        acceleration_mps2=max(_CALM * limits.acceleration_mps2, MIN_ACCELERATION_MPS2),
        acceleration_vertical_mps2=max(
            _CALM * limits.acceleration_vertical_mps2, MIN_ACCELERATION_MPS2
        ),
    )


def in_words(point: Vector3 | Float[np.ndarray, " 3"]) -> str:
    """Return the text of a position, for messages."""
    return f"({point[0]:.2f}, {point[1]:.2f}, {point[2]:.2f}) m"
