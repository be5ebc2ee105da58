"""Moving obstacles: upright rounded boxes, each predicted to keep its velocity for a while.

A rounded box is the set of points within a radius of a box: a ball if the box is a point, an
upright capsule if it is a line. One shape thus covers people, cars and drones, with a distance in
closed form. Uncertainty of the motion lets the radius grow with time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel


class Movers(NamedTuple):
    """Arrays of n moving obstacles for kernels."""

    positions: np.ndarray
    """Centres at time 0 (n, 3), ENU, m."""
    velocities: np.ndarray
    """Velocities (n, 3), ENU, m/s."""
    halves: np.ndarray
    """Half extents of the boxes (n, 3), m."""
    headings: np.ndarray
    """Cosine and sine of the headings (n, 2)."""
    radii: np.ndarray
    """Radii at time 0 (n,), m."""
    growth: float
    horizon: float


@dataclass(frozen=True, kw_only=True, eq=False)
class MovingObstacles:
    """Predictions, from time 0 of a plan on."""

    position_enu_m: Float[np.ndarray, "n 3"]
    """Centres at time 0."""
    velocity_enu_mps: Float[np.ndarray, "n 3"]
    radius_m: Float[np.ndarray, " n"]
    """Reach of the solid beyond its box."""
    half_extent_m: Float[np.ndarray, "n 3"]
    """Half extents of the box along its heading, to its left and up; zeros for a ball."""
    yaw_rad: Float[np.ndarray, " n"]
    growth_mps: float = 0.2
    """Growth of the radius with time."""
    horizon_s: float = 4.0
    """Time for which the prediction is believed. Later the obstacles are left out."""

    def __post_init__(self) -> None:
        """Refuse arrays of a wrong shape and negative numbers."""
        n = len(self.position_enu_m)
        for name, shape in (
            ("position_enu_m", (n, 3)),
            ("velocity_enu_mps", (n, 3)),
            ("radius_m", (n,)),
            ("half_extent_m", (n, 3)),
            ("yaw_rad", (n,)),
        ):
            value = np.asarray(getattr(self, name))
            if value.shape != shape or not np.all(np.isfinite(value)):
                raise ValueError(f"{name} has shape {value.shape}; valid: {shape}, all finite")
        if not (self.growth_mps >= 0 and self.horizon_s > 0):
            raise ValueError(
                f"growth_mps {self.growth_mps}, horizon_s {self.horizon_s} are not valid; "
                "valid: not negative and positive"
            )

    @classmethod
    def balls(
        cls,
        position_enu_m: Float[np.ndarray, "n 3"],
        velocity_enu_mps: Float[np.ndarray, "n 3"],
        radius_m: Float[np.ndarray, " n"],
        *,
        growth_mps: float = 0.2,
        horizon_s: float = 4.0,
    ) -> MovingObstacles:
        """Create moving balls.

        Args:
            position_enu_m: Centres at time 0.
            velocity_enu_mps: Velocities.
            radius_m: Radii at time 0.
            growth_mps: Growth of the radii with time.
            horizon_s: Time for which the prediction is believed.
        """
        position = np.asarray(position_enu_m, dtype=float).reshape(-1, 3)
        return cls(
            position_enu_m=position,
            velocity_enu_mps=np.asarray(velocity_enu_mps, dtype=float).reshape(-1, 3),
            radius_m=np.asarray(radius_m, dtype=float).reshape(-1),
            half_extent_m=np.zeros_like(position),
            yaw_rad=np.zeros(len(position)),
            growth_mps=growth_mps,
            horizon_s=horizon_s,
        )

    def __len__(self) -> int:
        return len(self.position_enu_m)

    @cached_property
    def movers(self) -> Movers:
        """The obstacles as arrays for kernels."""
        heading = np.column_stack([np.cos(self.yaw_rad), np.sin(self.yaw_rad)])
        arrays = (self.position_enu_m, self.velocity_enu_mps, self.half_extent_m, heading)
        p, v, h, c = (np.ascontiguousarray(array, dtype=float) for array in arrays)
        r = np.ascontiguousarray(self.radius_m, dtype=float)
        return Movers(p, v, h, c, r, float(self.growth_mps), float(self.horizon_s))

    def distances(
        self, points_enu_m: Float[np.ndarray, "k 3"], times_s: Float[np.ndarray, " k"]
    ) -> tuple[Float[np.ndarray, "n k"], Float[np.ndarray, "n k 3"]]:
        """Signed distance to each obstacle at each point's time, and the direction away from it.

        Within the box itself the direction is up, and the distance is minus the radius.
        """
        times = np.asarray(times_s)
        center = self.position_enu_m[:, None] + self.velocity_enu_mps[:, None] * times[:, None]
        c, s = np.cos(self.yaw_rad)[:, None], np.sin(self.yaw_rad)[:, None]
        d = np.asarray(points_enu_m) - center
        local = np.stack([c * d[..., 0] + s * d[..., 1], c * d[..., 1] - s * d[..., 0], d[..., 2]])
        half = self.half_extent_m.T[:, :, None]
        beyond = local - np.clip(local, -half, half)
        gap = np.linalg.norm(beyond, axis=0)
        x, y, z = np.where(gap > 1e-9, beyond / np.maximum(gap, 1e-9), [[[0.0]], [[0.0]], [[1.0]]])
        away = np.stack([c * x - s * y, s * x + c * y, z], axis=-1)
        radius = self.radius_m[:, None] + self.growth_mps * times
        return gap - radius, away

    def reach_m(self, index: int, normal: Float[np.ndarray, " 3"]) -> float:
        """Reach of an obstacle from its centre towards a unit direction, at time 0, m."""
        c, s = math.cos(self.yaw_rad[index]), math.sin(self.yaw_rad[index])
        local = np.array([c * normal[0] + s * normal[1], c * normal[1] - s * normal[0], normal[2]])
        return float(np.abs(local) @ self.half_extent_m[index] + self.radius_m[index])


NOTHING_MOVES = MovingObstacles.balls(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@kernel
def distance_to_movers(x: float, y: float, z: float, t: float, movers: Movers) -> tuple[float, int]:
    """Signed distance to the nearest moving obstacle at a time, and its index.

    The result is infinite and -1 beyond the horizon or if nothing moves. Inside a box the distance
    is minus the radius.
    """
    positions, velocities, halves, headings, radii, growth, horizon = movers
    best, nearest = np.inf, -1
    if t > horizon:
        return best, nearest
    for i in range(len(positions)):
        dx = x - positions[i, 0] - velocities[i, 0] * t
        dy = y - positions[i, 1] - velocities[i, 1] * t
        dz = z - positions[i, 2] - velocities[i, 2] * t
        c, s = headings[i, 0], headings[i, 1]
        u = max(abs(c * dx + s * dy) - halves[i, 0], 0.0)
        v = max(abs(c * dy - s * dx) - halves[i, 1], 0.0)
        w = max(abs(dz) - halves[i, 2], 0.0)
        distance = math.sqrt(u * u + v * v + w * w) - radii[i] - growth * t
        if distance < best:
            best, nearest = distance, i
    return best, nearest
