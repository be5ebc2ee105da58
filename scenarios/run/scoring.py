"""Score of a flight, judged by the truth: estimation errors, contacts, resting place."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import InteractionArea
from autonomy.types import ControlLevel, Vector3
from flightsim.plant import Plant

CONTACT_GAP_S = 0.2
"""Time below which two contacts count as one."""
LIFT_OFF_S = 0.5
"""A vehicle without contact for this long has left the ground."""
SURFACE_TOLERANCE_M = 0.15
"""Distance from sole to the area's plane within which a contact is one with the area."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FlightScore:
    """Figures of one flight; the defaults are of a run that was stopped before its first step."""

    position_rmse_m: float = math.nan
    """Estimated against true position from arming on, root mean square of the 3-D distance."""
    attitude_rmse_deg: float = math.nan
    """Estimated against true attitude from arming on, root mean square of the angle between."""
    has_flown: bool = False
    contacts_before_touchdown: int = 0
    """Separate contacts between lift-off and the first one with the area to land on."""
    has_touched_area: bool = False
    is_inside_area: bool = False
    """Whether the vehicle's centre ended over the area's polygon, in contact with it."""
    touchdown_error_m: float | None = None
    """Horizontal distance of the resting place from the chosen touchdown point."""
    tilt_at_rest_deg: float = 0.0


class FlightLog:
    """Keeps what the score needs; call `on_tick` after every simulator tick."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._history: list[np.ndarray] = []

    def on_tick(self) -> None:
        """Copy the last 20 ms."""
        self._history.append(self._plant.history.copy())

    def positions_m(self) -> Float[np.ndarray, "n 3"]:
        """True positions so far, ENU, one for each tick of the loop."""
        rows = [rows["position_true_enu_m"][-1] for rows in self._history]
        return np.array(rows, dtype=float).reshape(-1, 3)

    def state_hash(self) -> str:
        """BLAKE2b of every row so far: what was true, measured, estimated and commanded."""
        digest = hashlib.blake2b(digest_size=16)
        for rows in self._history:
            digest.update(rows.tobytes())
        return digest.hexdigest()

    def score(
        self, area: InteractionArea | None, touchdown_enu_m: Vector3 | None, leg_length_m: float
    ) -> FlightScore:
        """Judge the flight so far.

        Args:
            area: Area to land on; None if no landing was asked for.
            touchdown_enu_m: Touchdown point that the pilot chose; None if it never did.
            leg_length_m: Resting height of the vehicle's origin above its soles.
        """
        if not self._history:
            return FlightScore()
        return score_flight(np.concatenate(self._history), area, touchdown_enu_m, leg_length_m)


def score_flight(
    history: np.ndarray,
    area: InteractionArea | None,
    touchdown_enu_m: Vector3 | None,
    leg_length_m: float,
) -> FlightScore:
    """Judge a flight from its history, a row for each control tick (`flightsim.plant.record`)."""
    is_touching = history["is_touching"] > 0
    position_m = history["position_true_enu_m"]
    tick_s = (history["time_us"][1] - history["time_us"][0]) * 1e-6
    on_area = np.zeros_like(is_touching)
    if area is not None:
        on_area = is_touching & is_over_area(position_m - [0, 0, leg_length_m], area)
    lift_off = _lift_off(is_touching, round(LIFT_OFF_S / tick_s))
    touched = np.flatnonzero(on_area[lift_off:])
    touchdown = lift_off + int(touched[0]) if touched.size else len(history)
    rest = history[-1]
    error_m = None
    if touchdown_enu_m is not None:
        error_m = float(math.dist(rest["position_true_enu_m"][:2], touchdown_enu_m[:2]))
    armed = history[history["setpoint_level"] > ControlLevel.OFF]
    return FlightScore(
        position_rmse_m=_rms(armed["position_est_enu_m"] - armed["position_true_enu_m"]),
        attitude_rmse_deg=math.degrees(
            _rms(rotation_angle_rad(armed["quat_est_wxyz"], armed["quat_true_wxyz"])[:, None])
        ),
        has_flown=lift_off < len(history),
        contacts_before_touchdown=_count_episodes(
            is_touching[lift_off:touchdown], round(CONTACT_GAP_S / tick_s)
        ),
        has_touched_area=bool(touched.size),
        is_inside_area=bool(on_area[-1]),
        touchdown_error_m=error_m,
        tilt_at_rest_deg=math.degrees(_tilt_rad(rest["quat_true_wxyz"])),
    )


def is_over_area(
    soles_enu_m: Float[np.ndarray, "n 3"], area: InteractionArea
) -> Bool[np.ndarray, " n"]:
    """Whether each point lies over (or under) an area's polygon and close to its plane."""
    import shapely  # noqa: PLC0415 - only scored flights need it

    footprint = shapely.Polygon([corner[:2] for corner in area.polygon])
    height_m = np.abs(soles_enu_m[:, 2] - area.centroid[2])
    reach_m = np.linalg.norm(soles_enu_m[:, :2] - np.array(area.centroid[:2]), axis=1)
    is_level = height_m <= SURFACE_TOLERANCE_M + reach_m * math.tan(area.slope_rad)
    return shapely.contains_xy(footprint, soles_enu_m[:, 0], soles_enu_m[:, 1]) & is_level


def rotation_angle_rad(
    a_wxyz: Float[np.ndarray, "n 4"], b_wxyz: Float[np.ndarray, "n 4"]
) -> Float[np.ndarray, " n"]:
    """Angle of the rotation between two attitudes."""
    # Both parts of conj(a) b, because the scalar part alone loses small angles to rounding.
    scalar = np.abs(np.sum(a_wxyz * b_wxyz, axis=1))
    vector = (
        a_wxyz[:, :1] * b_wxyz[:, 1:]
        - b_wxyz[:, :1] * a_wxyz[:, 1:]
        - np.cross(a_wxyz[:, 1:], b_wxyz[:, 1:])
    )
    return 2.0 * np.arctan2(np.linalg.norm(vector, axis=1), scalar)


def _rms(errors: np.ndarray) -> float:
    """Root mean square of the norm of the rows; NaN without rows."""
    return math.sqrt(np.mean(np.sum(errors**2, axis=1))) if len(errors) else math.nan


def _tilt_rad(quat_wxyz: np.ndarray) -> float:
    _, x, y, _ = quat_wxyz
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))


def _lift_off(is_touching: np.ndarray, n_ticks: int) -> int:
    """First tick of the first `n_ticks` in a row without contact; the length if there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], is_touching, [True]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    long_runs = starts[ends - starts >= n_ticks]
    return int(long_runs[0]) if long_runs.size else len(is_touching)


def _count_episodes(is_touching: np.ndarray, gap_ticks: int) -> int:
    """Runs of contact, counting runs that are closer than `gap_ticks` as one."""
    ticks = np.flatnonzero(is_touching)
    return 0 if ticks.size == 0 else 1 + int(np.count_nonzero(np.diff(ticks) > gap_ticks))
