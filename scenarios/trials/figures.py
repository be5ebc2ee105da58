"""Figures of a flight by the truth, each measured when it is asked for.

A verdict stops at the first objection and needs few figures. Environments end thousands of
episodes, so that measuring each figure on demand saves them most of the work.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import InteractionArea
from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.trials.bounds import Touched, bounds_of, is_in_footprint, is_over_area, n_ticks
from scenarios.trials.contacts import Contact, impact_mps
from scenarios.trials.limits import LIMITS


@dataclass(frozen=True, kw_only=True, eq=False)
class Goal:
    """Place where a flight should end, and its conditions."""

    area: InteractionArea | None = None
    """Assigned area; None if no landing was asked for."""
    chosen_enu_m: Vector3 | None = None
    """Point that the pilot chose to land on. None, or a point beside the area, stands for the
    area's centroid."""
    others: Sequence[InteractionArea] = ()
    """Other areas that the flight may have ended on."""
    navigation_limit_s: float | None = None
    """Time after lift-off in which the flight must have come above the area; None for any."""
    stays_up: bool = False
    """True if a flight without an assigned area may touch nothing once it is in the air."""


class Figures:
    """Figures of one flight, as `FlightScore` has them, each measured when it is asked for.

    A verdict needs few of them, and an episode of an environment needs nothing but its verdict.
    """

    nearest_mover_m: float | None = None
    """Not measured here: it needs the movers' poses, which a history lacks."""

    def __init__(
        self, history: np.ndarray, airframe: Airframe, goal: Goal, touched: Touched | None = None
    ) -> None:
        """Prepare the figures of a flight; for the arguments see `score_flight`."""
        self._history, self._airframe, self._goal = history, airframe, goal
        self._touched, self._rest = touched, history[-1]
        self._bounds = bounds_of(history, airframe, goal.area, goal.others, touched)
        end = self._bounds.touchdown
        self._landed = history[end:] if end < len(history) else None

    @property
    def has_flown(self) -> bool:
        """True if the vehicle left the ground."""
        return self._bounds.lift_off < len(self._history)

    @property
    def is_down(self) -> bool:
        """True if the flight ended on the ground, or on something else.

        It is False while the vehicle flies, however low.
        """
        return self._landed is not None

    @property
    def lift_off_s(self) -> float | None:
        """Time at which the vehicle left the ground, s."""
        return _time_s(self._history[self._bounds.lift_off]) if self.has_flown else None

    @property
    def reached_s(self) -> float | None:
        """Time at which it was first in flight above the assigned area, s."""
        return reached_s(self._history[self._bounds.lift_off :], self._goal.area)

    @property
    def touchdown_s(self) -> float | None:
        """Time at which it came down for good, s."""
        return None if self._landed is None else _time_s(self._landed[0])

    @property
    def contacts_before_touchdown(self) -> int:
        """Number of contacts between lift-off and touchdown."""
        return self._bounds.n_contacts

    @property
    def touched_before(self) -> tuple[Contact, ...]:
        """The contacts between lift-off and touchdown."""
        return self._bounds.before

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """All contacts after lift-off."""
        return () if self._touched is None else tuple(self._touched.contacts)

    @cached_property
    def landed_area(self) -> int | None:
        """Area that all soles ended on, the assigned one or another; None if there is none.

        One sole beside it is enough for None, because three legs carry a vehicle only until
        something moves it.
        """
        if self._landed is None:
            return None
        # The assigned area first: where areas overlap, it is the one that counts.
        goal, soles_enu_m = self._goal, self._soles_enu_m
        candidates = goal.others if goal.area is None else (goal.area, *goal.others)
        landed = (area.id for area in candidates if is_over_area(soles_enu_m, area).all())
        return next(landed, None)

    @property
    def n_soles(self) -> int:
        """Number of soles that the vehicle has."""
        return len(self._airframe.soles_flu_m)

    @property
    def n_soles_inside(self) -> int:
        """Number of soles that ended on the assigned area."""
        if self._landed is None or self._goal.area is None:
            return 0
        return int(is_over_area(self._soles_enu_m, self._goal.area).sum())

    @property
    def touchdown_error_m(self) -> float | None:
        """Horizontal distance of the resting place from the chosen point, m."""
        return None if self._landed is None else _error_m(self._rest, self._goal)

    @cached_property
    def touchdown_speed_mps(self) -> float | None:
        """Speed at touchdown, m/s: the greatest in the 20 ms before it."""
        return None if self._landed is None else impact_mps(self._history, self._bounds.touchdown)

    @cached_property
    def slide_m(self) -> float | None:
        """Greatest horizontal distance from the place of the touchdown after it, m."""
        return None if self._landed is None else _slide_m(self._landed)

    @cached_property
    def tilt_at_rest_deg(self) -> float:
        """Tilt at the end, degrees."""
        return math.degrees(_tilt_rad(self._rest["quat_true_wxyz"]))

    @cached_property
    def is_at_rest(self) -> bool:
        """True if the vehicle was at rest at the end."""
        return is_at_rest(self._history)

    @cached_property
    def stopped_after_s(self) -> float | None:
        """Time from touchdown until the rotors stood still for good, s; None if they turn."""
        return None if self._landed is None else _stopped_after_s(self._landed, self._airframe)

    @cached_property
    def rotor_spin_ups(self) -> int:
        """Number of times that the rotors took the weight again after the touchdown."""
        return 0 if self._landed is None else _spin_ups(self._landed, self._airframe)

    @cached_property
    def _soles_enu_m(self) -> Float[np.ndarray, "n 3"]:
        return _soles_enu_m(self._rest, self._airframe)


def reached_s(flown: np.ndarray, area: InteractionArea | None) -> float | None:
    """The time of the first row above an area, low enough to look at it; None without any."""
    if area is None:
        return None
    x, y, z = flown["position_true_enu_m"].T
    height_m = z - area.centroid[2]
    is_above = (height_m >= 0.0) & (height_m <= LIMITS.above_m)
    rows = np.flatnonzero(is_above & is_in_footprint(area, x, y))
    return float(flown["time_us"][rows[0]]) * 1e-6 if rows.size else None


def _time_s(row: np.void) -> float:
    return float(row["time_us"]) * 1e-6


def _error_m(rest: np.void, goal: Goal) -> float | None:
    if goal.area is None:
        return None
    # A chosen point beside the area must not make the error small.
    at_enu_m, chosen = goal.area.centroid, goal.chosen_enu_m
    if chosen is not None and is_in_footprint(goal.area, *np.array(chosen)[:2, None])[0]:
        at_enu_m = chosen
    return math.dist(rest["position_true_enu_m"][:2], at_enu_m[:2])


def _soles_enu_m(row: np.void, airframe: Airframe) -> Float[np.ndarray, "n 3"]:
    scalar, axis = row["quat_true_wxyz"][0], row["quat_true_wxyz"][1:]
    soles_flu_m = np.array(airframe.soles_flu_m)
    # Rotation by a quaternion: v + 2 s (a x v) + 2 a x (a x v), with scalar s and axis part a.
    across = 2.0 * np.cross(axis, soles_flu_m)
    return row["position_true_enu_m"] + soles_flu_m + scalar * across + np.cross(axis, across)


def _slide_m(landed: np.ndarray) -> float:
    """Return the greatest horizontal distance from the beginning of a part of a history."""
    places_m = landed["position_true_enu_m"][:, :2]
    return float(np.linalg.norm(places_m - places_m[0], axis=1).max())


def is_at_rest(history: np.ndarray) -> bool:
    """Return whether the vehicle was at rest in the last part of a history."""
    return is_still(history[-n_ticks(history["time_us"][:2] * 1e-6, LIMITS.rest_s) :])


def is_still(history: np.ndarray) -> bool:
    """Return whether the vehicle was at rest in all rows of a history."""
    return all(
        float(np.linalg.norm(history[name], axis=1).max()) <= most
        for name, most in (
            ("velocity_true_enu_mps", LIMITS.rest_mps),
            ("angular_rate_true_flu_radps", LIMITS.rest_radps),
        )
    )


def rotors_turn(history: np.ndarray, airframe: Airframe) -> Bool[np.ndarray, " n"]:
    """Return whether any rotor turns, for each row of a history."""
    hover_radps = airframe.quadrotor.hover_speed_radps
    return np.max(history["rotor_speed_radps"], axis=1) > LIMITS.rotor_share * hover_radps


def _stopped_after_s(landed: np.ndarray, airframe: Airframe) -> float | None:
    # The last row with a turning rotor: before it they may have stopped and started again.
    turning = np.flatnonzero(rotors_turn(landed, airframe))
    if not turning.size:
        return 0.0
    last = landed[turning[-1]]
    is_turning = last["time_us"] == landed["time_us"][-1]
    return None if is_turning else float(last["time_us"] - landed["time_us"][0]) * 1e-6


def _spin_ups(landed: np.ndarray, airframe: Airframe) -> int:
    """Count the times that thrust rose above the upper share of the weight after the lower one."""
    constants = np.array([r.thrust_constant * r.axis_flu[2] for r in airframe.quadrotor.rotors])
    # Thrust over weight, by the true speeds of the rotors.
    share = (landed["rotor_speed_radps"] ** 2 @ constants) / _weight_n(airframe)
    # Only rows beyond one of the shares matter: a low one followed by a high one is a spin-up.
    is_high = share[(share < LIMITS.unloaded_share) | (share > LIMITS.loaded_share)] > (
        LIMITS.loaded_share
    )
    return int(np.count_nonzero(is_high[1:] & ~is_high[:-1]))


def _weight_n(airframe: Airframe) -> float:
    return airframe.quadrotor.mass_kg * GRAVITY_MPS2


def _tilt_rad(quat_wxyz: np.ndarray) -> float:
    # Third entry of the rotation matrix's third column; clipped, because rounding may exceed 1.
    _, x, y, _ = quat_wxyz
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))
