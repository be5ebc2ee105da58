"""Bounds of a flight: lift-off, touchdown, and the contacts between the two.

A touchdown is a contact with a surface to land on: the ground and the floors that people walk on,
the place of an area, or the place where the vehicle stood at the start. Any other contact is a
collision. It counts as a contact before the touchdown even if no free flight follows it, because
the fall of a vehicle that hit a wall is no landing.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import InteractionArea
from aeroscene.scene.catalogue import BRIDGES, DECKS, FLOORS, GROUND, PADS, ROOFS, ROOMS, WATER
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.trials.contacts import Contact
from scenarios.trials.limits import LIMITS

GROUNDS = (GROUND | PADS | DECKS | BRIDGES | FLOORS | ROOMS | ROOFS) - WATER
"""Categories that people walk on: a vehicle that comes down there has landed, if not on an area."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Bounds:
    """Rows of a history at which a flight begins and ends."""

    lift_off: int
    """The number of rows if it never left the ground."""
    touchdown: int
    """The number of rows if it ended in the air."""
    n_contacts: int
    """Number of contacts before the touchdown."""
    before: tuple[Contact, ...] = ()
    """The contacts before the touchdown; empty if it is unknown what was touched."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Touched:
    """Contacts of a flight from lift-off on."""

    contacts: Sequence[Contact]
    """In the order of time."""
    home_id: int | None = None
    """Object under the vehicle at the start; None for the bare ground."""


def lift_off_row(history: np.ndarray) -> int:
    """Return the first row of the first free flight; the number of rows if there was none."""
    flights = _free_flights(history)
    return flights[0][0] if flights else len(history)


def bounds_of(
    history: np.ndarray,
    airframe: Airframe,
    assigned: InteractionArea | None,
    others: Sequence[InteractionArea] = (),
    touched: Touched | None = None,
) -> Bounds:
    """Find lift-off and touchdown, and count the contacts between them.

    Args:
        history: Rows of control ticks (`flightsim.plant.record`).
        airframe: Vehicle that flew.
        assigned: Assigned area, if there is one.
        others: Other areas that the flight may have ended on.
        touched: Contacts of the flight. None if they are unknown: then any surface that ends the
            last free flight counts as a surface to land on.
    """
    flights, n_rows = _free_flights(history), len(history)
    if not flights:
        return Bounds(lift_off=n_rows, touchdown=n_rows, n_contacts=0)
    (lift_off, _), (_, touchdown) = flights[0], flights[-1]
    landing = _Landing(history, airframe, assigned, others, touched)
    # Otherwise the flight ended in the air.
    if touchdown < n_rows:
        on_area = landing.first_on_assigned(lift_off)
        touchdown = landing.on_something_else(touchdown) if on_area is None else on_area
    if touched is None:
        n_brushes = landing.n_brushes(lift_off, touchdown)
        return Bounds(lift_off=lift_off, touchdown=touchdown, n_contacts=n_brushes)
    before = landing.contacts_before(touchdown, touched.contacts)
    n_before = len(before)
    return Bounds(lift_off=lift_off, touchdown=touchdown, n_contacts=n_before, before=before)


class _Landing:
    """Searches a history for the touchdown."""

    def __init__(
        self,
        history: np.ndarray,
        airframe: Airframe,
        assigned: InteractionArea | None,
        others: Sequence[InteractionArea],
        touched: Touched | None,
    ) -> None:
        self._history, self._leg_m = history, [0.0, 0.0, airframe.leg_length_m]
        self._is_touching = history["is_touching"] > 0
        self._assigned, self._touched = assigned, touched
        self._areas = others if assigned is None else (assigned, *others)

    @functools.cached_property
    def _time_s(self) -> np.ndarray:
        return self._history["time_us"] * 1e-6

    @functools.cached_property
    def _soles_enu_m(self) -> np.ndarray:
        return self._history["position_true_enu_m"] - self._leg_m

    def first_on_assigned(self, lift_off: int) -> int | None:
        """Return the first row on the assigned area's own surface; None if there is none."""
        area = self._assigned
        if area is None:
            return None
        is_on = self._is_touching & is_over_area(self._soles_enu_m, area)
        if self._touched is not None:
            spans = (c for c in self._touched.contacts if _is_surface(c, area))
            is_on &= np.any([self._during(contact) for contact in spans] or [[False]], axis=0)
        rows = np.flatnonzero(is_on[lift_off:])
        return lift_off + int(rows[0]) if rows.size else None

    def on_something_else(self, ended: int) -> int:
        """The row at which it came down elsewhere, at or after the end of the last free flight.

        After a collision that is the first row on a surface to land on. If it never reached one, as
        in the branches of a tree, it is the row of the collision.
        """
        if self._touched is None:
            return ended
        for contact in self._touched.contacts:
            if contact.until_s < self._time_s[ended]:
                continue
            # A nanosecond of tolerance: times are rounded from microseconds.
            # A contact that began before the last flight ended counts from that end on.
            row = max(ended, int(np.searchsorted(self._time_s, contact.time_s - 1e-9)))
            if self._bears(contact, row):
                return row
        return ended

    def n_brushes(self, lift_off: int, touchdown: int) -> int:
        """Return the number of stretches of contact between two rows, whatever was touched."""
        ticks = np.flatnonzero(self._is_touching[lift_off:touchdown])
        if not ticks.size:
            return 0
        # Stretches that are close together count as one.
        n_gap = n_ticks(self._time_s, LIMITS.contact_gap_s)
        return 1 + int(np.count_nonzero(np.diff(ticks) > n_gap))

    def contacts_before(self, touchdown: int, contacts: Sequence[Contact]) -> tuple[Contact, ...]:
        """Return the contacts up to the touchdown, without the touchdown itself."""
        if touchdown == len(self._time_s):
            return tuple(contacts)
        landed_s = float(self._time_s[touchdown])

        def is_touchdown(contact: Contact) -> bool:
            is_new = landed_s - contact.time_s <= LIMITS.contact_gap_s
            return is_new and self._bears(contact, touchdown)

        until_now = (contact for contact in contacts if contact.time_s <= landed_s + 1e-9)
        return tuple(contact for contact in until_now if not is_touchdown(contact))

    def _bears(self, contact: Contact, row: int) -> bool:
        """Return whether a contact is one with a surface to land on."""
        touched, soles_enu_m = self._touched, self._soles_enu_m[row]
        assert touched is not None
        is_home = contact.object_id is not None and contact.object_id == touched.home_id
        # A roof above the soles is a ceiling, not a surface to stand on.
        is_below = contact.position_enu_m[2] <= soles_enu_m[2] + LIMITS.surface_tolerance_m
        if contact.is_with_ground or (is_below and (is_home or contact.category in GROUNDS)):
            return True
        areas = (area for area in self._areas if _is_surface(contact, area))
        return any(is_over_area(soles_enu_m[None], area)[0] for area in areas)

    def _during(self, contact: Contact) -> Bool[np.ndarray, " n"]:
        return (self._time_s >= contact.time_s - 1e-9) & (self._time_s <= contact.until_s + 1e-9)


def _is_surface(contact: Contact, area: InteractionArea) -> bool:
    """Return whether a contact is one with the object under an area."""
    if area.object_id is None:
        return contact.is_with_ground
    return contact.object_id == area.object_id


def is_over_area(
    soles_enu_m: Float[np.ndarray, "n 3"], area: InteractionArea
) -> Bool[np.ndarray, " n"]:
    """Return whether each point lies over (or under) an area's polygon and close to its plane."""
    height_m = np.abs(soles_enu_m[:, 2] - area.centroid[2])
    reach_m = np.linalg.norm(soles_enu_m[:, :2] - np.array(area.centroid[:2]), axis=1)
    # A sloped area's plane is farther from the centroid's height the farther out a sole stands.
    is_level = height_m <= LIMITS.surface_tolerance_m + reach_m * math.tan(area.slope_rad)
    return is_in_footprint(area, soles_enu_m[:, 0], soles_enu_m[:, 1]) & is_level


def is_in_footprint(area: InteractionArea, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    """Return whether each point lies over (or under) an area's polygon."""
    import shapely

    return shapely.contains_xy(_footprint(tuple(area.polygon)), x_m, y_m)


@functools.lru_cache(maxsize=256)
def _footprint(corners_enu_m: tuple[Vector3, ...]) -> Any:
    """The polygon of an area on the ground plane; cached, because flights repeat the same ones."""
    import shapely

    return shapely.Polygon([corner[:2] for corner in corners_enu_m])


def n_ticks(time_s: np.ndarray, seconds: float) -> int:
    """Return the number of rows in a time, from the times of the rows."""
    # Rows are evenly spaced, so two of them give the rate.
    return round(seconds / (time_s[1] - time_s[0]))


def _free_flights(history: np.ndarray) -> list[tuple[int, int]]:
    """Return begin and end (the row after) of each stretch without contact that is long enough."""
    is_free = history["is_touching"] == 0
    changes = np.flatnonzero(is_free[1:] != is_free[:-1]) + 1
    stretches = pairwise([0, *changes.tolist(), len(is_free)])
    n_least = n_ticks(history["time_us"][:2] * 1e-6, LIMITS.lift_off_s)
    return [(a, b) for a, b in stretches if b - a >= n_least and is_free[a]]
