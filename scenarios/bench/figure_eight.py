"""Figure eight as a reference, and the tracking error of a vehicle on it.

The curve is the lemniscate of Gerono, (a sin s, a/2 sin 2s), at a constant phase rate s' after a
smooth start. Its acceleration is a s'^2 |(sin s, 2 sin 2s)|, whose largest value sets s'. An eight
turns both ways and its acceleration varies, so an error that a circle hides shows here. The smooth
start keeps the reference flat to the third derivative, since a jump would measure the recovery.

    symbol    name                              here
    a         half of the length, m             half_length_m
    s         phase, rad                        _phase
    s'        phase rate, rad/s                 phase_rate_radps
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from autonomy.types import IDLE, OFF, ControlLevel, Setpoint
from flightsim.plant import Plant
from flightsim.plant.cfg import ADVANCE_HZ

SETTLED_S = 4.0
"""Duration of the smooth start."""
# Largest |(sin s, 2 sin 2s)|, by sampling; exactly it is 17/8, at cos 2s = -1/16.
_PEAK_SHAPE = float(
    np.max(np.hypot(np.sin(s := np.linspace(0.0, np.pi, 20_001)), 2.0 * np.sin(2.0 * s)))
)
_ALIGN_S, _IDLE_S, _CLIMB_S = 2.0, 0.5, 6.0
_CLIMB_M = 15.0


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureEight:
    """A level eight with its crossing in the centre; its long axis points east."""

    centre_enu_m: tuple[float, float, float]
    peak_acceleration_mps2: float
    half_length_m: float = 8.0

    @property
    def phase_rate_radps(self) -> float:
        """Phase rate after the smooth start."""
        return math.sqrt(self.peak_acceleration_mps2 / (self.half_length_m * _PEAK_SHAPE))

    @property
    def peak_speed_mps(self) -> float:
        """Speed at the crossing."""
        return math.sqrt(2.0) * self.half_length_m * self.phase_rate_radps

    @property
    def lap_s(self) -> float:
        """Time of one lap."""
        return 2.0 * math.pi / self.phase_rate_radps

    def derivatives_enu(self, time_s: Float[np.ndarray, " n"]) -> Float[np.ndarray, "4 n 3"]:
        """Return position, velocity, acceleration and jerk.

        Args:
            time_s: Times since the start, 0 and later.

        Returns:
            Derivatives of order 0 to 3, in m and s, ENU.
        """
        s, s1, s2, s3 = self._phase(time_s)
        q = [np.stack([_sine(s, k), 0.5 * 2**k * _sine(2.0 * s, k), 0.0 * s], -1) for k in range(4)]
        s1, s2, s3 = s1[:, None], s2[:, None], s3[:, None]
        # The chain rule up to the third derivative (Faa di Bruno).
        curve = np.stack(
            [
                q[0],
                q[1] * s1,
                q[2] * s1**2 + q[1] * s2,
                q[3] * s1**3 + 3.0 * q[2] * s1 * s2 + q[1] * s3,
            ]
        )
        curve *= self.half_length_m
        curve[0] += self.centre_enu_m
        return curve

    def setpoint(self, time_s: float) -> Setpoint:
        """Return the setpoint at a time since the start: position to jerk, looking east."""
        p, v, a, j = (tuple(row.tolist()) for row in self.derivatives_enu(np.array([time_s]))[:, 0])
        return Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=p,
            velocity_enu_mps=v,
            acceleration_enu_mps2=a,
            jerk_enu_mps3=j,
            yaw_rad=0.0,
        )

    def _phase(self, time_s: Float[np.ndarray, " n"]) -> tuple[np.ndarray, ...]:
        """Return phase and three derivatives: its rate rises by a cubic, then stays constant."""
        # s' = w (3 u^2 - 2 u^3) with u = t / length, whose slope is zero at both ends.
        w, length = self.phase_rate_radps, SETTLED_S
        u = np.clip(time_s / length, 0.0, 1.0)
        after = np.maximum(time_s - length, 0.0)
        is_rising = time_s < length
        return (
            w * length * (u**3 - 0.5 * u**4) + w * after,
            w * (3.0 * u**2 - 2.0 * u**3),
            w / length * (6.0 * u - 6.0 * u**2),
            w / length**2 * (6.0 - 12.0 * u) * is_rising,
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class Track:
    """Flight along an eight, one row per control tick."""

    time_s: Float[np.ndarray, " n"]
    """Time since the start of the track."""
    error_true_m: Float[np.ndarray, "n 3"]
    """True position minus reference."""
    error_est_m: Float[np.ndarray, "n 3"]
    """Estimated position minus reference."""
    tilt_rad: Float[np.ndarray, " n"]
    is_touching: np.ndarray

    def rmse_m(self, state: Literal["truth", "estimate"]) -> float:
        """Return the root mean square error, in m, without the smooth start.

        Args:
            state: "truth" for the true position, "estimate" for the estimated one.
        """
        error = self.error_true_m if state == "truth" else self.error_est_m
        return float(np.sqrt(np.mean(np.sum(error[self.time_s >= SETTLED_S] ** 2, axis=1))))


def take_off(plant: Plant) -> tuple[float, float, float]:
    """Align, arm, climb 15 m and hold.

    Args:
        plant: Plant at rest at its start.

    Returns:
        The held position, in the frame of the state that the controller gets.
    """
    _repeat(plant, OFF, _ALIGN_S)
    _repeat(plant, IDLE, _IDLE_S)
    x, y, z = plant.estimate.position_enu_m
    if plant.cfg.state == "truth":
        x, y, z = plant.truth.position_enu_m
    hover_enu_m = (x, y, z + _CLIMB_M)
    _repeat(plant, hold(hover_enu_m), _CLIMB_S)
    return hover_enu_m


def hold(position_enu_m: tuple[float, float, float]) -> Setpoint:
    """Return a setpoint that stays at a position, looking east."""
    return Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=position_enu_m, yaw_rad=0.0)


def fly(plant: Plant, eight: FigureEight, seconds: float) -> Track:
    """Follow an eight, starting at its centre.

    Args:
        plant: Plant that hovers there.
        eight: Reference.
        seconds: Duration.

    Returns:
        The flight beside its reference.
    """
    start_us = plant.time_us
    rows = _record(plant, eight.setpoint, seconds)
    time_s = 1e-6 * (rows["time_us"] - start_us)
    where_enu_m = eight.derivatives_enu(time_s)[0]
    return _track(rows, time_s, where_enu_m)


def come_back(plant: Plant, position_enu_m: tuple[float, float, float], seconds: float) -> Track:
    """Fly to a point and stay there.

    Args:
        plant: Plant in the air.
        position_enu_m: Point to hold.
        seconds: Duration.

    Returns:
        The flight beside the point.
    """
    start_us = plant.time_us
    rows = _record(plant, lambda _: hold(position_enu_m), seconds)
    return _track(rows, 1e-6 * (rows["time_us"] - start_us), np.array(position_enu_m))


def _track(rows: np.ndarray, time_s: np.ndarray, where_enu_m: np.ndarray) -> Track:
    # 1 - 2 (x^2 + y^2) is the vertical part of the body's z axis: the cosine of the tilt.
    x, y = rows["quat_true_wxyz"][:, 1], rows["quat_true_wxyz"][:, 2]
    return Track(
        time_s=time_s,
        error_true_m=rows["position_true_enu_m"] - where_enu_m,
        error_est_m=rows["position_est_enu_m"] - where_enu_m,
        tilt_rad=np.arccos(np.clip(1.0 - 2.0 * (x**2 + y**2), -1.0, 1.0)),
        is_touching=rows["is_touching"] == 1,
    )


def _record(plant: Plant, setpoint: Callable[[float], Setpoint], seconds: float) -> np.ndarray:
    rows = []
    for k in range(round(seconds * ADVANCE_HZ)):
        plant.apply(setpoint(k / ADVANCE_HZ))
        plant.advance()
        rows.append(plant.history.copy())
    return np.concatenate(rows)


def _repeat(plant: Plant, setpoint: Setpoint, seconds: float) -> None:
    for _ in range(round(seconds * ADVANCE_HZ)):
        plant.apply(setpoint)
        plant.advance()


def _sine(angle: np.ndarray, order: int) -> np.ndarray:
    """Return the derivative of a sine of the given order; each turns the phase by a quarter."""
    return np.sin(angle + 0.5 * np.pi * order)
