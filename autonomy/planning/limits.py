"""Dynamic limits of a flight, and the bounds of velocity and acceleration that follow.

A vehicle is limited in thrust, tilt and body rate, which are not linear in a trajectory. The
optimiser bounds speeds and accelerations instead. This module derives bounds that keep thrust and
tilt in the worst case; the rest is checked and tightened afterwards (`demand`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.model.flatness import hover_drag_per_s
from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams
from autonomy.planning.errors import LimitsError

MIN_ACCELERATION_MPS2 = 0.2
"""Least acceleration with which a flight makes sense."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MotionBounds:
    """Greatest speeds and accelerations of a trajectory.

    The optimiser bounds these linearly; thrust and tilt follow from them only nearly.
    """

    speed_horizontal_mps: float
    speed_vertical_mps: float
    acceleration_horizontal_mps2: float
    acceleration_vertical_mps2: float

    def as_array(self) -> Float[np.ndarray, " 4"]:
        """The bounds as an array, in the order of the fields."""
        return np.array([getattr(self, name) for name in self.__slots__])


@dataclass(frozen=True, kw_only=True, slots=True)
class FlightLimits:
    """Limits of the motion that a trajectory may demand of the vehicle."""

    speed_horizontal_mps: float = 6.5
    speed_vertical_mps: float = 2.0
    acceleration_mps2: float = 4.0
    """Horizontal acceleration, m/s^2."""
    acceleration_vertical_mps2: float = 2.0
    thrust_fraction: float = 0.85
    """Share of the maximum collective thrust; the rest is left to torques."""
    tilt_rad: float = math.radians(30.0)
    body_rate_radps: float = math.radians(180.0)
    """Body rate about the axes across the thrust, by which the vehicle changes its tilt."""
    yaw_rate_radps: float = math.radians(90.0)
    yaw_acceleration_radps2: float = math.radians(180.0)

    def __post_init__(self) -> None:
        """Refuse limits that no flight can keep."""
        for name in self.__slots__:
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise LimitsError(f"{name} {value} is not valid; valid: a positive number")
        if not self.thrust_fraction <= 1:
            raise LimitsError(f"thrust_fraction {self.thrust_fraction} exceeds 1; valid: 0 to 1")
        for name in ("acceleration_mps2", "acceleration_vertical_mps2"):
            if getattr(self, name) < MIN_ACCELERATION_MPS2:
                raise LimitsError(
                    f"{name} {getattr(self, name)} is too little to fly by; "
                    f"valid: at least {MIN_ACCELERATION_MPS2:.2f}"
                )
        if not self.tilt_rad < math.pi / 2:
            raise LimitsError(f"tilt_rad {self.tilt_rad} is not valid; valid: below pi/2")

    def max_specific_thrust_mps2(self, quadrotor: QuadrotorParams) -> float:
        """Largest thrust over mass that a plan may use, m/s^2."""
        return self.thrust_fraction * quadrotor.max_thrust_n / quadrotor.mass_kg

    def motion_bounds(self, quadrotor: QuadrotorParams) -> MotionBounds:
        """Return the bounds from which an optimiser begins; tightening them allows for rotor drag.

        Raises:
            LimitsError: If hovering leaves too little of the thrust to accelerate.
        """
        horizontal, vertical = self.accelerations_mps2(quadrotor)
        # In level cruise the tilt overcomes the rotors' drag and still accelerates a little.
        thrust = self.max_specific_thrust_mps2(quadrotor)
        across = min(math.tan(self.tilt_rad) * GRAVITY_MPS2, math.sqrt(thrust**2 - GRAVITY_MPS2**2))
        drag = max(hover_drag_per_s(quadrotor), 1e-9)
        if across < 2 * MIN_ACCELERATION_MPS2:
            raise LimitsError(
                f"tilt_rad {self.tilt_rad} leaves {across:.2f} m/s^2 across; "
                f"valid: at least {2 * MIN_ACCELERATION_MPS2:.2f}"
            )
        return MotionBounds(
            speed_horizontal_mps=min(
                self.speed_horizontal_mps, (across - MIN_ACCELERATION_MPS2) / drag
            ),
            speed_vertical_mps=self.speed_vertical_mps,
            acceleration_horizontal_mps2=horizontal,
            acceleration_vertical_mps2=vertical,
        )

    def accelerations_mps2(self, quadrotor: QuadrotorParams) -> tuple[float, float]:
        """Horizontal and vertical bounds of acceleration that keep thrust and tilt, without drag.

        Thrust over mass is |a + g e3| and tilt its angle to the vertical. With vertical
        accelerations in +-v the worst of the first is at +v, of the second at -v.

        Raises:
            LimitsError: If hovering leaves too little of the thrust to accelerate.
        """
        thrust = self.max_specific_thrust_mps2(quadrotor)
        # Half of the surplus: the other half is for horizontal acceleration at the same time.
        vertical = min(self.acceleration_vertical_mps2, (thrust - GRAVITY_MPS2) / 2)
        if vertical < MIN_ACCELERATION_MPS2:
            raise LimitsError(
                f"thrust_fraction {self.thrust_fraction} leaves {thrust - GRAVITY_MPS2:.2f} m/s^2 "
                f"beyond hover; valid: at least {2 * MIN_ACCELERATION_MPS2:.2f}"
            )
        horizontal = min(
            self.acceleration_mps2,
            math.sqrt(thrust**2 - (GRAVITY_MPS2 + vertical) ** 2),
            math.tan(self.tilt_rad) * (GRAVITY_MPS2 - vertical),
        )
        return horizontal, vertical
