"""Log of a flight: everything that is needed to score it afterwards.

Scoring needs the whole history at 250 Hz, because a contact may last a few milliseconds. A minute
of it takes a few megabytes. A run that nobody judges keeps only sums and a hash.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flightsim.plant import Plant
from flightsim.plant.cfg import ADVANCE_HZ
from flightsim.plant.record import without_gaps
from scenarios.trials.bounds import Touched, lift_off_row
from scenarios.trials.contacts import Contact, ContactFinder, MoverPoses
from scenarios.trials.figures import Goal, is_at_rest, rotors_turn
from scenarios.trials.limits import LIMITS
from scenarios.trials.measures.effort import measure_effort
from scenarios.trials.measures.estimation import EstimationErrors
from scenarios.trials.measures.room import room_to_movers_m, room_to_vehicle_m
from scenarios.trials.measures.track import TRACK_STEP_S, Track, track_of
from scenarios.trials.score import FlightScore, score_flight

_AWAY_M = 1.5
"""Positions nearer to the start or the resting place do not count for the clearance, because
take-off and landing must come near to a surface."""


_TICKS_AT_ONCE = 50
"""Number of ticks that are added up together: numpy has the same cost for one row as for a hundred.
"""


class FlightLog:
    """Keeps the rows that score and hash need; call `on_tick` after every simulator tick."""

    def __init__(self, plant: Plant, *, is_judged: bool = True) -> None:
        """Follow a flight.

        Args:
            plant: The vehicle.
            is_judged: True if a pilot flies who is judged at the end. A flight that is not judged
                keeps no rows, and takes no more memory after a day than after a minute.
        """
        self._plant = plant
        self._is_judged = is_judged
        self._ticks: list[bytes] = []
        """Rows of each tick: all of a flight that is judged, else those not yet added up."""
        self._digest = hashlib.blake2b(digest_size=16)
        self._n_hashed = 0
        """Number of the present ticks that the digest has."""
        self._errors = EstimationErrors()
        self._mover_poses: list[tuple[np.ndarray, np.ndarray]] = []
        self._room_to_movers_m: list[float] = []
        self._mates: tuple[FlightLog, ...] = ()

    def fly_with(self, mates: Sequence[FlightLog]) -> None:
        """Register the flights of the other vehicles in the world, in their order, as movers."""
        self._mates = tuple(mates)

    def on_tick(self) -> None:
        """Record the last 20 ms."""
        plant = self._plant
        # Bytes: numpy copies records of many fields one field at a time.
        self._ticks.append(plant.history.tobytes())
        if not self._is_judged:
            if len(self._ticks) >= _TICKS_AT_ONCE:
                self._add_up()
            return
        if not plant.world.obstacles:
            return
        # Copies: MuJoCo changes its arrays in place.
        self._mover_poses.append((plant.data.mocap_pos.copy(), plant.data.mocap_quat.copy()))
        vehicle_enu_m = np.array(plant.truth.position_enu_m)
        room_m = room_to_movers_m(vehicle_enu_m, plant.world.airframe, plant.obstacles_true)
        self._room_to_movers_m.append(room_m)

    def is_still(self) -> bool:
        """Return whether the vehicle and its rotors are at rest now, in a flight that is judged."""
        last = self._rows(-math.ceil(LIMITS.rest_s * ADVANCE_HZ))
        return is_at_rest(last) and not rotors_turn(last, self._plant.world.airframe)[-1]

    def is_in_the_air(self) -> bool:
        """Return whether it has touched nothing for a while, in a flight that is judged."""
        last = self._rows(-math.ceil(LIMITS.lift_off_s * ADVANCE_HZ))
        return not np.any(last["is_touching"])

    def state_hash(self) -> str:
        """The BLAKE2b hash of every row so far: truth, measurements, estimates and commands."""
        if self._n_hashed < len(self._ticks):
            self._digest.update(without_gaps(self._rows(self._n_hashed)).tobytes())
            self._n_hashed = len(self._ticks)
        return self._digest.hexdigest()

    def score(self, goal: Goal | None) -> FlightScore:
        """Measure the flight so far.

        Args:
            goal: Goal of the flight; None measures only figures that need none. A flight that is
                not judged has only the errors of the estimate.
        """
        if not self._is_judged:
            self._add_up()
            return FlightScore(
                position_rmse_m=self._errors.position_rmse_m,
                attitude_rmse_deg=self._errors.attitude_rmse_deg,
            )
        if not self._ticks:
            return FlightScore()
        # One copy of all rows; scoring then works on whole columns.
        history, airframe = self._rows(0), self._plant.world.airframe
        if goal is None:
            return score_flight(history, airframe, Goal())
        score = score_flight(history, airframe, goal, self._touched(history))
        if score.lift_off_s is None:
            return score
        return replace(
            score,
            effort=measure_effort(
                history,
                airframe,
                lift_off_s=score.lift_off_s,
                reached_s=score.reached_s,
                touchdown_s=score.touchdown_s,
            ),
            least_clearance_m=self._least_clearance_m(history),
            nearest_mover_m=self._nearest_mover_m(history, score),
        )

    def positions_enu_m(self) -> Float[np.ndarray, "n 3"]:
        """Return the true position at the end of every tick of a flight that is judged, ENU, m."""
        # The last row of each tick.
        rows = self._rows(0)["position_true_enu_m"]
        return rows[len(self._plant.history) - 1 :: len(self._plant.history)]

    def track(self) -> Track:
        """Return the true path of a flight that is judged, from its first row to its last."""
        # The last tick too, so that the track ends where the flight did.
        ticks = self._ticks[:: round(TRACK_STEP_S * ADVANCE_HZ)] + self._ticks[-1:]
        history = np.frombuffer(b"".join(ticks), self._plant.history.dtype)
        return track_of(history["position_true_enu_m"][:: len(self._plant.history)])

    def _rows(self, first: int) -> np.ndarray:
        """Return the rows from one tick on, one for each control tick."""
        return np.frombuffer(b"".join(self._ticks[first:]), self._plant.history.dtype)

    def _add_up(self) -> None:
        """Add the present ticks to hash and errors, and forget them."""
        if not self._ticks:
            return
        self.state_hash()
        self._errors.add(self._rows(0))
        self._ticks.clear()
        self._n_hashed = 0

    def _touched(self, history: np.ndarray) -> Touched:
        """The contacts from lift-off on, and the object that the vehicle stood on at the start."""
        counts = np.arange(len(history)) >= lift_off_row(history)
        is_touching = history["is_touching"] > 0
        if not np.any(counts & is_touching):
            return Touched(contacts=())
        # One row before lift-off is looked at too: its contact is the home.
        before = np.flatnonzero(is_touching & ~counts)[:1]
        counts[before] = True
        contacts = self._contacts(history, counts)
        if not before.size:
            return Touched(contacts=contacts)
        started_s = float(history["time_us"][before[0]]) * 1e-6
        homes = [contact.object_id for contact in contacts if contact.time_s == started_s]
        later = [contact for contact in contacts if contact.time_s != started_s]
        return Touched(contacts=later, home_id=homes[0] if homes else None)

    def _contacts(self, history: np.ndarray, counts: np.ndarray) -> tuple[Contact, ...]:
        n_rows, shape = (
            len(self._plant.history),
            (len(self._ticks), self._plant.world.model.nmocap),
        )
        positions_m = np.array([position for position, _ in self._mover_poses]).reshape(*shape, 3)
        quats_wxyz = np.array([quat for _, quat in self._mover_poses]).reshape(*shape, 4)
        movers = MoverPoses(
            position_enu_m=positions_m.repeat(n_rows, axis=0),
            quat_wxyz=quats_wxyz.repeat(n_rows, axis=0),
        )
        mates = [mate._rows(0) for mate in self._mates]
        return ContactFinder(self._plant.world).find(history, movers, counts, mates)

    def _least_clearance_m(self, history: np.ndarray) -> float | None:
        # Loads the planner's obstacles, which a run of a pilot of one's own may not need before.
        from scenarios.mission.clearance import flown_clearance_m

        world, n_rows = self._plant.world, len(self._plant.history)
        way_enu_m = history["position_true_enu_m"][n_rows - 1 :: n_rows]
        return flown_clearance_m(world.scene, world.airframe, way_enu_m, _AWAY_M)

    def _nearest_mover_m(self, history: np.ndarray, score: FlightScore) -> float | None:
        """Return the least room in flight to movers and other vehicles; None if nothing moves."""
        if score.lift_off_s is None or not (self._room_to_movers_m or self._mates):
            return None
        # A row a tick: the movers' distances were measured at the ends of ticks.
        n_rows = len(self._plant.history)
        rows = history[n_rows - 1 :: n_rows]
        time_s, way_enu_m = rows["time_us"] * 1e-6, rows["position_true_enu_m"]
        until_s = time_s[-1] if score.touchdown_s is None else score.touchdown_s
        flown = (time_s >= score.lift_off_s) & (time_s <= until_s)
        airframe = self._plant.world.airframe
        rooms_m = [np.array(self._room_to_movers_m)] if self._room_to_movers_m else []
        for mate in self._mates:
            theirs_enu_m = mate._rows(0)["position_true_enu_m"][n_rows - 1 :: n_rows]
            other = mate._plant.world.airframe
            rooms_m.append(room_to_vehicle_m(way_enu_m, airframe, theirs_enu_m, other))
        return float(np.min(rooms_m, axis=0)[flown].min(initial=np.inf))
