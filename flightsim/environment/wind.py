"""Wind settings: steady wind, turbulence and gusts, with their checks."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autonomy.model.quadrotor import Vector3

MAX_WIND_MPS = 30.0
MAX_TURBULENCE_MPS = 5.0
MAX_GUST_MPS = 20.0

_KNOT_MPS = 1852.0 / 3600.0
SIGMA_OVER_W20 = 0.1
"""Standard deviation of vertical turbulence over the wind 20 ft above ground (MIL-F-8785C)."""
TURBULENCE_MPS = {
    "none": 0.0,
    "light": SIGMA_OVER_W20 * 15.0 * _KNOT_MPS,
    "moderate": SIGMA_OVER_W20 * 30.0 * _KNOT_MPS,
    "severe": SIGMA_OVER_W20 * 45.0 * _KNOT_MPS,
}
"""MIL-F-8785C, figure 10: winds of 15, 30 and 45 knots at 20 ft, as standard deviations."""
NATURAL = "natural"
"""Turbulence that corresponds to the steady wind, taken as the wind at 20 ft."""


class WindError(ValueError):
    """The wind is invalid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class WindCfg:
    """Motion of the air over the scene."""

    speed_mps: float = 0.0
    """Steady horizontal wind."""
    from_deg: float = 0.0
    """Direction of origin, clockwise from north; the axis of gusts and turbulence."""
    up_mps: float = 0.0
    """Steady upward wind."""
    turbulence_mps: float = 0.0
    """Standard deviation of vertical turbulence; the horizontal ones follow from the height."""
    gust_mps: float = 0.0
    """Peak speed that a gust adds along the wind."""
    gust_s: float = 3.0
    """Duration of a gust."""
    gust_period_s: float = 15.0
    """Time between the starts of two gusts; the first starts after one period."""

    def __post_init__(self) -> None:
        """Refuse an invalid wind.

        Raises:
            WindError: Naming the field, its value and the valid values.
        """
        speed = math.hypot(self.speed_mps, self.up_mps)
        if not speed <= MAX_WIND_MPS:
            raise WindError(
                f"wind ({self.speed_mps}, up {self.up_mps}): finite speeds of at most "
                f"{MAX_WIND_MPS:g} m/s are valid"
            )
        self._check("wind", self.speed_mps, 0.0, MAX_WIND_MPS, "m/s")
        self._check("wind from", self.from_deg, -360.0, 360.0, "degrees clockwise from north")
        self._check("turbulence", self.turbulence_mps, 0.0, MAX_TURBULENCE_MPS, "m/s")
        self._check("gust", self.gust_mps, 0.0, MAX_GUST_MPS, "m/s")
        self._check("gust seconds", self.gust_s, 0.1, 3600.0, "s")
        self._check("gust period", self.gust_period_s, self.gust_s, 3600.0, "s")

    def _check(self, what: str, value: float, low: float, high: float, unit: str) -> None:
        if not low <= value <= high:
            raise WindError(f"{what} = {value}: {low:g} to {high:g} {unit} are valid")

    @classmethod
    def towards(cls, velocity_enu_mps: Vector3) -> WindCfg:
        """Steady wind with a given velocity of the air.

        Raises:
            WindError: If a component is not finite or the speed exceeds `MAX_WIND_MPS`.
        """
        east, north, up = (float(v) for v in velocity_enu_mps)
        from_deg = math.degrees(math.atan2(-east, -north)) % 360.0 if (east or north) else 0.0
        if not math.isfinite(from_deg):
            from_deg = 0.0
        return cls(speed_mps=math.hypot(east, north), from_deg=from_deg, up_mps=up)

    @property
    def axis_enu(self) -> tuple[float, float]:
        """Horizontal unit vector (east, north) along which the wind blows."""
        angle = math.radians(self.from_deg)
        return (-math.sin(angle), -math.cos(angle))

    @property
    def steady_enu_mps(self) -> Vector3:
        """Velocity of the air without turbulence and gusts."""
        east, north = self.axis_enu
        return (self.speed_mps * east, self.speed_mps * north, self.up_mps)


CALM = WindCfg()


def turbulence_mps(text: str, wind_mps: float) -> float:
    """Standard deviation of vertical turbulence, from a word or a number.

    Args:
        text: A word of `TURBULENCE_MPS`, `NATURAL`, or the number itself.
        wind_mps: Speed of the steady wind.

    Raises:
        WindError: If it is neither.
    """
    if text in TURBULENCE_MPS:
        return TURBULENCE_MPS[text]
    if text == NATURAL:
        return SIGMA_OVER_W20 * wind_mps
    try:
        return float(text)
    except ValueError:
        words = ", ".join((*TURBULENCE_MPS, NATURAL))
        raise WindError(
            f"turbulence {text!r} is unknown; valid: {words}, or a standard deviation in m/s"
        ) from None
