"""Wind: steady, turbulent and in gusts, with checks of its settings and the air's motion.

A gust is a "one minus cosine" bump, v(t) = A / 2 (1 - cos(2 pi t / D)) for 0 <= t <= D
(CS-25.341, there over the distance flown), along the wind.

Among buildings the steady wind and its gusts follow the flow around them
(`flightsim.environment.shelter`). No wind blows in a room; within a metre of its walls and doors it
grows to the outside wind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from autonomy.jit import fields, kernel
from autonomy.types import ZERO3, Vector3
from flightsim.environment.dryden import N_NORMALS, N_STATES, step_turbulence
from flightsim.environment.rooms import exposure
from flightsim.environment.shelter import flow_at

# Larger values are taken for mistakes.
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
    """Motion of the air over the scene; `parameter` names the parameter that sets a field."""

    speed_mps: float = field(default=0.0, metadata={"parameter": "SIM_WIND_SPD"})
    """Steady horizontal wind."""
    from_deg: float = field(default=0.0, metadata={"parameter": "SIM_WIND_DIR"})
    """Direction of origin, clockwise from north; the axis of gusts and turbulence."""
    up_mps: float = 0.0
    """Steady upward wind."""
    turbulence_mps: float = field(default=0.0, metadata={"parameter": "SIM_WIND_TURB"})
    """Standard deviation of vertical turbulence; the horizontal ones follow from the height."""
    gust_mps: float = field(default=0.0, metadata={"parameter": "SIM_WIND_GUST"})
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
        """Return the steady wind with a given velocity of the air.

        Args:
            velocity_enu_mps: Velocity of the air.

        Raises:
            WindError: If a component is not finite or the speed exceeds `MAX_WIND_MPS`.
        """
        east, north, up = (float(v) for v in velocity_enu_mps)
        from_deg = math.degrees(math.atan2(-east, -north)) % 360.0 if (east or north) else 0.0
        # Not finite: the check of the speed refuses it, with a message about the speed.
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
    """Return the standard deviation of vertical turbulence, from a word or a number, m/s.

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


AIR_NORMALS = N_NORMALS

_TAKEN_OVER = ("turbulence_mps", "gust_mps", "gust_s", "gust_period_s")
"""Fields of `WindCfg` that the record of the air has too."""

AIR_DTYPE = np.dtype(
    [
        ("is_steady", "i8"),  # nothing to do in a tick
        ("first_normal", "i8"),  # of its block among the plant's normals
        ("is_sheltered", "i8"),  # by buildings or hills
        *fields("dt_s", "gust_clock_s", *_TAKEN_OVER),
        *fields("speed_mps", "up_mps", "shelter_cell_m"),
        *fields("shelter_origin_enu_m", "flow", shape=(3,)),  # velocity over the open wind's
        ("steady_enu_mps", "f8", 3),
        ("axis_enu", "f8", 2),
        ("states", "f8", N_STATES),
        ("turbulence_wind_mps", "f8", 3),  # along, left, up
    ],
    align=True,
)


def new_air(dt_s: float) -> np.ndarray:
    """Return calm air for ticks of `dt_s`, in an array of shape (1,).

    Before it becomes turbulent, its `states` are to be drawn (`dryden.stationary_states`).
    """
    airs = np.zeros(1, AIR_DTYPE)
    airs["dt_s"] = dt_s
    set_wind(airs[0], WindCfg())
    return airs


def set_wind(
    air: np.void, cfg: WindCfg, *, has_rooms: bool = False, is_sheltered: bool = False
) -> None:
    """Change the wind from the next tick on; the clock of the gusts restarts.

    Args:
        air: Record of `AIR_DTYPE`, changed.
        cfg: Wind under the open sky.
        has_rooms: True if there are rooms without wind.
        is_sheltered: True if the field about buildings and hills holds for this direction.
    """
    is_steady = cfg.turbulence_mps == 0.0 and cfg.gust_mps == 0.0
    is_still = cfg.steady_enu_mps == ZERO3
    # Steady wind that is the same everywhere needs no work in a tick.
    air["is_steady"] = is_steady and (is_still or not (has_rooms or is_sheltered))
    air["is_sheltered"] = is_sheltered
    air["speed_mps"], air["up_mps"] = cfg.speed_mps, cfg.up_mps
    air["steady_enu_mps"] = cfg.steady_enu_mps
    air["axis_enu"] = cfg.axis_enu
    for name in _TAKEN_OVER:
        air[name] = getattr(cfg, name)
    air["gust_clock_s"] = 0.0


@kernel
def move_air(
    air: np.record,
    position_enu_m: np.ndarray,
    height_m: float,
    velocity_enu_mps: np.ndarray,
    rooms: np.ndarray,
    shelter: np.ndarray,
    normals: np.ndarray,
    wind_enu_mps: np.ndarray,
) -> None:
    """Advance the air by one control tick.

    Args:
        air: Record of the air, changed.
        position_enu_m: True position of the vehicle.
        height_m: Its height above the ground.
        velocity_enu_mps: True velocity.
        rooms: Rooms without wind (n, 8), see `flightsim.environment.rooms`.
        shelter: Velocity over the open wind's (nx, ny, nz, 3), if the air is sheltered.
        normals: Standard normals (5,).
        wind_enu_mps: Velocity of the air (3,), written.
    """
    if air.is_steady == 1:
        return
    steady = air.steady_enu_mps
    if air.turbulence_mps > 0.0:
        # Turbulence is met at the speed through the steady wind; gusts and turbulence itself do not
        # count.
        x = velocity_enu_mps[0] - steady[0]
        y = velocity_enu_mps[1] - steady[1]
        z = velocity_enu_mps[2] - steady[2]
        speed = math.sqrt(x * x + y * y + z * z)
        step_turbulence(
            air.states,
            air.turbulence_wind_mps,
            height_m,
            speed,
            air.turbulence_mps,
            air.dt_s,
            normals,
        )
    else:
        air.turbulence_wind_mps[:] = 0.0
    air.gust_clock_s += air.dt_s
    along, left, up = air.turbulence_wind_mps
    share, mean, flow = exposure(rooms, position_enu_m), air.speed_mps + _gust(air), air.flow
    _follow_buildings(air, position_enu_m, shelter)
    # Rotated from the wind's axes (along, left) to east and north.
    wind_enu_mps[0] = share * (mean * flow[0] + along * air.axis_enu[0] - left * air.axis_enu[1])
    wind_enu_mps[1] = share * (mean * flow[1] + along * air.axis_enu[1] + left * air.axis_enu[0])
    wind_enu_mps[2] = share * (mean * flow[2] + air.up_mps + up)


@kernel
def _follow_buildings(air: np.record, position_enu_m: np.ndarray, shelter: np.ndarray) -> None:
    """Set the flow at a position: the open wind's, except near buildings."""
    if air.is_sheltered == 1 and flow_at(
        shelter, air.shelter_origin_enu_m, air.shelter_cell_m, position_enu_m, air.flow
    ):
        return
    air.flow[0], air.flow[1], air.flow[2] = air.axis_enu[0], air.axis_enu[1], 0.0


@kernel
def _gust(air: np.record) -> float:
    """Return the speed that the present gust adds along the wind, m/s."""
    since = air.gust_clock_s % air.gust_period_s
    # None before the first period has passed.
    if air.gust_clock_s < air.gust_period_s or since > air.gust_s:
        return 0.0
    return 0.5 * air.gust_mps * (1.0 - math.cos(2.0 * math.pi * since / air.gust_s))
