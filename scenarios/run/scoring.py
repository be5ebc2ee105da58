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
_TICKS_AT_ONCE = 50
"""Ticks that are counted together: numpy has the same cost for one row as for a hundred."""


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
    """Keeps what score and hash need, however long the flight; call `on_tick` after every tick."""

    def __init__(self, plant: Plant, *, is_judged: bool = True) -> None:
        """Follow a flight.

        Args:
            plant: The vehicle.
            is_judged: Whether a landing may be judged at the end. A flight that is not takes no
                more memory after a day than after a minute.
        """
        self._plant = plant
        self._waiting: list[bytes] = []
        self._digest = hashlib.blake2b(digest_size=16)
        self._tally = FlightTally(keeps_contacts=is_judged)

    def on_tick(self) -> None:
        """Take the last 20 ms."""
        # Bytes: numpy copies records of many fields one field at a time.
        self._waiting.append(self._plant.history.tobytes())
        if len(self._waiting) >= _TICKS_AT_ONCE:
            self._count()

    def state_hash(self) -> str:
        """BLAKE2b of every row so far: what was true, measured, estimated and commanded."""
        self._count()
        return self._digest.hexdigest()

    def score(
        self, area: InteractionArea | None, touchdown_enu_m: Vector3 | None, leg_length_m: float
    ) -> FlightScore:
        """Judge the flight so far.

        Args:
            area: Area to land on; None if no landing was asked for.
            touchdown_enu_m: Touchdown point that the pilot chose; None if it never did.
            leg_length_m: Resting height of the vehicle's origin above its soles.
        """
        self._count()
        return self._tally.score(area, touchdown_enu_m, leg_length_m)

    def _count(self) -> None:
        if not self._waiting:
            return
        rows = b"".join(self._waiting)
        self._waiting.clear()
        self._digest.update(rows)
        self._tally.add(np.frombuffer(rows, self._plant.history.dtype))


class FlightTally:
    """Sums over the history of a flight that grows; `score` reads them.

    Of the rows themselves it keeps the last, and those of contacts after lift-off: whether these
    were on the area to land on can only be said at the end.
    """

    def __init__(self, *, keeps_contacts: bool = True) -> None:
        """Begin with no row; without its contacts a flight cannot be judged by an area."""
        self._keeps_contacts = keeps_contacts
        self._n_rows = 0
        self._rest: np.ndarray | None = None
        self._tick_s = math.nan
        self._n_armed = 0
        self._squared_position_m2 = 0.0
        self._squared_angle_rad2 = 0.0
        self._n_aloft = 0
        """Rows without contact up to now, in a row; frozen once the vehicle has lifted off."""
        self._lift_off: int | None = None
        self._contact_ticks: list[np.ndarray] = []
        self._contact_positions_m: list[np.ndarray] = []

    def add(self, history: np.ndarray) -> None:
        """Add rows, one for each control tick (`flightsim.plant.record`); at least two at first."""
        if self._rest is None:
            self._tick_s = float(history["time_us"][1] - history["time_us"][0]) * 1e-6
        self._add_errors(history[history["setpoint_level"] > ControlLevel.OFF])
        is_touching = history["is_touching"] > 0
        first = 0 if self._lift_off is not None else self._rows_before_lift_off(is_touching)
        if self._keeps_contacts and self._lift_off is not None:
            contacts = first + np.flatnonzero(is_touching[first:])
            if contacts.size:
                self._contact_ticks.append(self._n_rows + contacts)
                self._contact_positions_m.append(history["position_true_enu_m"][contacts])
        self._rest = history[-1:].copy()
        self._n_rows += len(history)

    def _add_errors(self, armed: np.ndarray) -> None:
        if not len(armed):
            return
        error_m = armed["position_est_enu_m"] - armed["position_true_enu_m"]
        angle_rad = rotation_angle_rad(armed["quat_est_wxyz"], armed["quat_true_wxyz"])
        self._n_armed += len(armed)
        self._squared_position_m2 += float(np.sum(error_m**2))
        self._squared_angle_rad2 += float(np.sum(angle_rad**2))

    def _rows_before_lift_off(self, is_touching: np.ndarray) -> int:
        """Look for the first rows without contact for long enough.

        Returns:
            Index within these rows of the first that counts as flown; their number if none does.
        """
        needed = round(LIFT_OFF_S / self._tick_s)
        for index in range(len(is_touching)):
            self._n_aloft = 0 if is_touching[index] else self._n_aloft + 1
            if self._n_aloft == needed:
                self._lift_off = self._n_rows + index + 1 - needed
                return index + 1
        return len(is_touching)

    def score(
        self, area: InteractionArea | None, touchdown_enu_m: Vector3 | None, leg_length_m: float
    ) -> FlightScore:
        """Judge the rows so far; see `FlightLog.score`."""
        if self._rest is None:
            return FlightScore()
        rest = self._rest[0]
        ticks = np.concatenate([np.empty(0, int), *self._contact_ticks])
        on_area = np.zeros(len(ticks), bool)
        is_inside = False
        if area is not None:
            soles_m = [0, 0, leg_length_m]
            positions_m = np.concatenate([np.empty((0, 3)), *self._contact_positions_m])
            on_area = is_over_area(positions_m - soles_m, area)
            at_rest = is_over_area(self._rest["position_true_enu_m"] - soles_m, area)
            is_inside = bool(at_rest[0] and rest["is_touching"] > 0)
        touched = np.flatnonzero(on_area)
        before = ticks[: touched[0]] if touched.size else ticks
        error_m = None
        if touchdown_enu_m is not None:
            error_m = float(math.dist(rest["position_true_enu_m"][:2], touchdown_enu_m[:2]))
        return FlightScore(
            position_rmse_m=self._rms(self._squared_position_m2),
            attitude_rmse_deg=math.degrees(self._rms(self._squared_angle_rad2)),
            has_flown=self._lift_off is not None,
            contacts_before_touchdown=_count_episodes(before, round(CONTACT_GAP_S / self._tick_s)),
            has_touched_area=bool(touched.size),
            is_inside_area=is_inside,
            touchdown_error_m=error_m,
            tilt_at_rest_deg=math.degrees(_tilt_rad(rest["quat_true_wxyz"])),
        )

    def _rms(self, sum_of_squares: float) -> float:
        """Root mean square over the armed rows; NaN without any."""
        return math.sqrt(sum_of_squares / self._n_armed) if self._n_armed else math.nan


def score_flight(
    history: np.ndarray,
    area: InteractionArea | None,
    touchdown_enu_m: Vector3 | None,
    leg_length_m: float,
) -> FlightScore:
    """Judge a flight from its whole history."""
    tally = FlightTally()
    tally.add(history)
    return tally.score(area, touchdown_enu_m, leg_length_m)


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


def _tilt_rad(quat_wxyz: np.ndarray) -> float:
    _, x, y, _ = quat_wxyz
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))


def _count_episodes(ticks: np.ndarray, gap_ticks: int) -> int:
    """Runs of contact among the numbers of rows with one; runs closer than the gap are one."""
    return 0 if ticks.size == 0 else 1 + int(np.count_nonzero(np.diff(ticks) > gap_ticks))
