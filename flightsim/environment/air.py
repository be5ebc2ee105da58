"""The air around the vehicle, once a control tick: steady wind, turbulence and gusts.

A gust is a "one minus cosine" bump, v(t) = A / 2 (1 - cos(2 pi t / D)) for 0 <= t <= D
(CS-25.341, there over the distance flown), along the wind.

No wind blows in a room; within a metre of its walls and doors it grows to what blows outside.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from autonomy.types import ZERO3
from flightsim.environment.dryden import N_NORMALS, N_STATES, stationary_states, step_turbulence
from flightsim.environment.rooms import exposure
from flightsim.environment.wind import WindCfg

AIR_NORMALS = N_NORMALS

AIR_DTYPE = np.dtype(
    [
        ("is_steady", "i8"),  # nothing to do in a tick
        ("dt_s", "f8"),
        ("first_normal", "i8"),  # of its block among the plant's normals
        ("steady_enu_mps", "f8", 3),
        ("axis_enu", "f8", 2),
        ("turbulence_mps", "f8"),
        ("gust_mps", "f8"),
        ("gust_s", "f8"),
        ("gust_period_s", "f8"),
        ("gust_clock_s", "f8"),
        ("states", "f8", N_STATES),
        ("turbulence_wind_mps", "f8", 3),  # along, left, up
    ],
    align=True,
)


def new_air(generator: np.random.Generator, *, dt_s: float) -> np.ndarray:
    """Calm air, in an array of shape (1,).

    Args:
        generator: Of the turbulence's first state.
        dt_s: Control tick.
    """
    airs = np.zeros(1, AIR_DTYPE)
    airs["dt_s"] = dt_s
    airs["states"][0] = stationary_states(generator)
    set_wind(airs[0], WindCfg())
    return airs


def set_wind(air: np.void, cfg: WindCfg, *, has_rooms: bool = False) -> None:
    """Let another wind blow from the next tick on; the clock of the gusts starts anew.

    Args:
        air: `AIR_DTYPE`, changed.
        cfg: The wind under the open sky.
        has_rooms: Whether there is anywhere that it does not blow.
    """
    is_steady = cfg.turbulence_mps == 0.0 and cfg.gust_mps == 0.0
    is_still = cfg.steady_enu_mps == ZERO3
    air["is_steady"] = is_steady and (is_still or not has_rooms)
    air["steady_enu_mps"] = cfg.steady_enu_mps
    air["axis_enu"] = cfg.axis_enu
    for name in ("turbulence_mps", "gust_mps", "gust_s", "gust_period_s"):
        air[name] = getattr(cfg, name)
    air["gust_clock_s"] = 0.0


@kernel
def move_air(
    air: np.record,
    position_enu_m: np.ndarray,
    velocity_enu_mps: np.ndarray,
    rooms: np.ndarray,
    normals: np.ndarray,
    wind_enu_mps: np.ndarray,
) -> None:
    """Advance by one control tick.

    Args:
        air: Changed.
        position_enu_m: True position of the vehicle; its height is above the ground plane.
        velocity_enu_mps: True velocity.
        rooms: Where no wind blows (n, 8), `flightsim.environment.rooms`.
        normals: Standard normals (5,).
        wind_enu_mps: Result (3,), velocity of the air.
    """
    if air.is_steady == 1:
        return
    steady = air.steady_enu_mps
    if air.turbulence_mps > 0.0:
        x = velocity_enu_mps[0] - steady[0]
        y = velocity_enu_mps[1] - steady[1]
        z = velocity_enu_mps[2] - steady[2]
        speed = math.sqrt(x * x + y * y + z * z)
        step_turbulence(
            air.states,
            air.turbulence_wind_mps,
            position_enu_m[2],
            speed,
            air.turbulence_mps,
            air.dt_s,
            normals,
        )
    else:
        air.turbulence_wind_mps[:] = 0.0
    air.gust_clock_s += air.dt_s
    along = air.turbulence_wind_mps[0] + _gust(air)
    left = air.turbulence_wind_mps[1]
    share = exposure(rooms, position_enu_m)
    wind_enu_mps[0] = share * (steady[0] + along * air.axis_enu[0] - left * air.axis_enu[1])
    wind_enu_mps[1] = share * (steady[1] + along * air.axis_enu[1] + left * air.axis_enu[0])
    wind_enu_mps[2] = share * (steady[2] + air.turbulence_wind_mps[2])


@kernel
def _gust(air: np.record) -> float:
    """What the present gust adds along the wind."""
    since = air.gust_clock_s % air.gust_period_s
    if air.gust_clock_s < air.gust_period_s or since > air.gust_s:
        return 0.0
    return 0.5 * air.gust_mps * (1.0 - math.cos(2.0 * math.pi * since / air.gust_s))
