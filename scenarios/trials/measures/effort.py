"""Effort of a flight by its history: time, electrical energy, jerk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.battery import watts_per_cubed_speed

_BLOCK_S = 0.1
"""Time over which the velocity is averaged before it is differentiated twice. Without it the jerk
would be mostly vibration."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Effort:
    """Figures that compare pilots on the same task; None if a figure does not apply."""

    navigation_s: float | None = None
    """Time from lift-off until it was first above the assigned area."""
    flight_s: float | None = None
    """Time from lift-off to touchdown."""
    energy_j: float | None = None
    """Electrical energy of motors and avionics from lift-off to touchdown, or to the end."""
    jerk_rms_mps3: float | None = None
    """Root mean square of the jerk from lift-off to touchdown, or to the end."""


def measure_effort(
    history: np.ndarray,
    airframe: Airframe,
    *,
    lift_off_s: float,
    reached_s: float | None,
    touchdown_s: float | None,
) -> Effort:
    """Measure the effort of a flight.

    Args:
        history: Row for each control tick (`flightsim.plant.record`).
        airframe: Vehicle that flew, with its battery.
        lift_off_s: Time at which it left the ground.
        reached_s: Time at which it was first above the assigned area; None if it never was.
        touchdown_s: Time of the touchdown; None if it ended in the air.
    """
    time_s = history["time_us"] * 1e-6
    until_s = time_s[-1] if touchdown_s is None else touchdown_s
    flown = history[(time_s >= lift_off_s) & (time_s < until_s)]
    tick_s = float(time_s[1] - time_s[0])
    return Effort(
        navigation_s=None if reached_s is None else reached_s - lift_off_s,
        flight_s=None if touchdown_s is None else touchdown_s - lift_off_s,
        energy_j=_energy_j(flown, airframe, tick_s),
        jerk_rms_mps3=_jerk_rms_mps3(flown, tick_s),
    )


def _energy_j(flown: np.ndarray, airframe: Airframe, tick_s: float) -> float:
    """The energy that the battery's model draws, without the losses of its own resistance."""
    battery = airframe.battery
    cubes = float(np.sum(np.abs(flown["rotor_speed_radps"]) ** 3))
    power_w = battery.avionics_power_w * len(flown) + watts_per_cubed_speed(battery) * cubes
    return power_w * tick_s


def _jerk_rms_mps3(flown: np.ndarray, tick_s: float) -> float | None:
    n_rows = round(_BLOCK_S / tick_s)
    n_blocks = len(flown) // n_rows
    # A second difference needs three values.
    if n_blocks < 3:
        return None
    velocity_mps = flown["velocity_true_enu_mps"][: n_blocks * n_rows]
    means_mps = velocity_mps.reshape(n_blocks, n_rows, 3).mean(axis=1)
    jerk_mps3 = np.diff(means_mps, 2, axis=0) / _BLOCK_S**2
    return float(np.sqrt(np.mean(np.sum(jerk_mps3**2, axis=1))))
