"""Landing phases: search for a place, align above it, descend, and climb back if it turns bad.

The given map says where an area is, but not whether something lies on it. So the place to touch
down on is chosen from depth images, and watched on the way down until it is too late to stop. After
several failures at one area the next one is tried.
"""

from __future__ import annotations

import logging
import math
from typing import Protocol

from aeroscene.scene import InteractionArea
from autonomy.planning import PlanningError
from scenarios.pilot.depth_frames import NoDepthError
from scenarios.pilot.final_descent import (
    CARRIED_OFF_M,
    COMMIT_HEIGHTS_M,
    steady_within,
)
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.landing_watch import CAMERA, LandingWatch
from scenarios.pilot.phases import Phase, Step
from scenarios.pilot.second_look import look_from_below, look_nearer

_LOG = logging.getLogger(__name__)

SEARCH_FRAMES = 6
"""Number of depth images fused before a place is chosen."""
HOVERING_FRAMES = 3
"""Number of these images that are taken in the hover, for as long as gusts need to show."""
# After this many images a place with too little room for the felt gusts is accepted.
MAX_SEARCH_FRAMES = 20
STEEP = 1.0
"""Least ratio of descent to level distance for a straight line down to a place, so that the place
stays in view."""
MAX_LOOKS = 4
"""Number of searches and descents at one area before the next is tried."""
MAX_AREAS = 3
MAX_BLIND_FRAMES = 5
"""Number of consecutive images without depth after which the pilot holds."""


class Fallbacks(Protocol):
    """Actions for an area that allows no landing now."""

    def hold(self, reason: str) -> Step:
        """Come to rest and wait."""
        ...

    def go_home(self, reason: str) -> Step:
        """Give up and fly home."""
        ...


class LandingPhases:
    """Flies the phases above and on the area.

    Attributes:
        fallbacks: Called when the area is left without a landing.
    """

    fallbacks: Fallbacks

    def __init__(self, flight: FlightState) -> None:
        self._flight = flight

    def look(self, reason: str) -> Step:
        """Start a new search of the area, or go on to the next area after too many."""
        flight = self._flight
        flight.n_looks += 1
        if flight.n_looks > MAX_LOOKS:
            return self.give_up(f"{reason}, for the {MAX_LOOKS}th time")
        flight.watch = LandingWatch(flight.mission.surroundings, flight.area, flight.hover_enu_m)
        return Phase.SEARCH, reason

    def give_up(self, reason: str) -> Step:
        """Fly to the next reachable area, else home.

        At most `MAX_AREAS` are tried in a flight.
        """
        flight = self._flight
        flight.n_looks, flight.watch = 0, None
        while flight.alternates and flight.n_areas < MAX_AREAS:
            area = flight.alternates.pop(0)
            if self._set_out_for(area):
                return Phase.NAVIGATE, f"{reason}; on to area {area.id}"
        return self.fallbacks.go_home(reason)

    def _set_out_for(self, area: InteractionArea) -> bool:
        flight = self._flight
        hover = flight.mission.surroundings.hover_point(area)
        if hover is None:
            return False
        try:
            flight.plan_to(hover)
        except PlanningError as error:
            _LOG.info("area %d: %s", area.id, error)
            return False
        # Only now: the old area is kept if no path leads to the new one.
        flight.n_areas += 1
        flight.area, flight.hover_enu_m, flight.site = area, hover, None
        return True

    def search(self) -> Step:
        """Fuse depth images until a place is good enough, with room for gusts felt meanwhile."""
        flight, watch = self._flight, self._watching()
        watch.is_hovering = watch.is_hovering or flight.has_arrived
        if watch.is_hovering:
            watch.sway_m = max(watch.sway_m, flight.level_deviation_m)
        if not self._see(watch):
            return self._blind(watch)
        # Gusts show only in the hover, so images on the way there do not count.
        watch.n_hovering += watch.is_hovering
        if watch.n_frames < SEARCH_FRAMES or watch.n_hovering < HOVERING_FRAMES:
            return None
        if flight.level_deviation_m > CARRIED_OFF_M:
            return None  # A path down begins at the hover point.
        flight.site = watch.choose()
        has_room = flight.site is not None and flight.site.clearance_m >= watch.sway_m
        if not has_room and watch.n_frames < MAX_SEARCH_FRAMES:
            return None
        if flight.site is None:
            reason = f"no safe place seen on area {flight.area.id}"
            again = look_nearer(flight, reason) or look_from_below(flight, reason)
            return again or self.give_up(reason)
        x, y, _ = flight.site.position_enu_m
        chose = (
            f"chose ({x:.2f}, {y:.2f}): slope {math.degrees(flight.site.slope_rad):.1f} deg, "
            f"roughness {100 * flight.site.roughness_m:.0f} cm, "
            f"{flight.site.clearance_m:.2f} m of room"
        )
        if self._goes_straight_down():
            return Phase.DESCEND, chose
        try:
            flight.go((x, y, flight.hover_enu_m[2]))
        except PlanningError as error:
            return self.give_up(f"no certified way above ({x:.2f}, {y:.2f}): {error}")
        return Phase.ALIGN, chose

    def _goes_straight_down(self) -> bool:
        """Begin a straight line to above the chosen place, if it is steep and free."""
        here, goal = self._flight.setpoint.position_enu_m, self._flight.chosen.position_enu_m
        if here[2] - goal[2] < STEEP * math.dist(here[:2], goal[:2]):
            return False
        try:
            self._go_down()
        except PlanningError:
            return False
        return True

    def _go_down(self) -> None:
        """Begin a straight line to where the last stretch begins, as low as can be certified.

        Raises:
            PlanningError: If it can be certified to no height.
        """
        flight = self._flight
        x, y, _ = flight.chosen.position_enu_m
        # Not above the hover point, from which the line starts.
        lower_m, higher_m = (
            min(flight.resting_height_m + height_m, flight.hover_enu_m[2])
            for height_m in COMMIT_HEIGHTS_M
        )
        try:
            leg = flight.leg((x, y, lower_m), flight.pace.descent_mps)
        except PlanningError:
            leg = flight.leg((x, y, higher_m), flight.pace.descent_mps)
        flight.begin_with(leg)

    def align(self) -> Step:
        """Fly to above the chosen place, then descend."""
        flight = self._flight
        if not flight.has_arrived:
            return None
        try:
            self._go_down()
        except PlanningError as error:
            x, y, _ = flight.chosen.position_enu_m
            reason = f"no certified way down at ({x:.2f}, {y:.2f}): {error}"
            # A growing map may take noise for something in the way, until it has seen more.
            is_sure = flight.mission.surroundings.is_known
            return self.give_up(reason) if is_sure else self.look(reason)
        return Phase.DESCEND, "above the touchdown point"

    def descend(self) -> Step:
        """Descend while watching the place, down to the commit height."""
        flight, watch = self._flight, self._watching()
        if self._see(watch):
            # The map near the place gets better on the way down, so its height is taken anew.
            flight.site = watch.again(flight.chosen)
            if reason := watch.objection(flight.chosen):
                return self._climb_back(f"the touchdown point no longer looks safe: {reason}")
        elif step := self._blind(watch):
            return step
        if not flight.has_arrived and not self._sinks_steadily():
            return None
        flight.touch_down(flight.resting_height_m)
        return Phase.TOUCHDOWN, "still safe from here"

    def _sinks_steadily(self) -> bool:
        """Return whether the vehicle is above the place, and slows at the descent's end.

        Then the last stretch begins without a stop.
        """
        flight = self._flight
        most_m, most_mps = steady_within(flight.tracking)
        return (
            flight.course.is_slower_than(flight.pace.touchdown_mps, flight.time_us)
            and flight.level_deviation_m <= most_m
            and math.hypot(*flight.telemetry.velocity_enu_mps[:2]) <= most_mps
        )

    def climb(self) -> Step:
        """Climb back, then search again."""
        return self.look("climbed back") if self._flight.has_arrived else None

    def _climb_back(self, reason: str) -> Step:
        """Stop, and climb back to the height of the hover point."""
        flight = self._flight
        x, y, z = flight.setpoint.position_enu_m
        try:
            flight.plan_to((x, y, max(z, flight.hover_enu_m[2])))
        except PlanningError as error:
            return self.fallbacks.hold(f"{reason}; {error}")
        return Phase.CLIMB, reason

    def _see(self, watch: LandingWatch) -> bool:
        """Fuse an image if one is due and has depth; return whether one was fused."""
        flight = self._flight
        if not watch.is_due(flight.time_us):
            return False
        try:
            image = flight.senses.take(CAMERA)
        except NoDepthError as error:
            watch.miss(flight.time_us)
            _LOG.info("%s", error)
            return False
        watch.fuse(flight.time_us, image)
        return True

    def _blind(self, watch: LandingWatch) -> Step:
        """Hold if there was no depth for too long."""
        n_blind = watch.n_blind
        if n_blind < MAX_BLIND_FRAMES:
            return None
        watch.n_blind = 0
        return self.fallbacks.hold(f"camera {CAMERA} measured nothing in {n_blind} images")

    def _watching(self) -> LandingWatch:
        assert self._flight.watch is not None
        return self._flight.watch
