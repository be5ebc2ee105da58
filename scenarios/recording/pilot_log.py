"""Plans, observations and decisions of our own pilot in a recording."""

from __future__ import annotations

import numpy as np

from autonomy.planning import Trajectory
from flightsim.autopilot.events import Severity
from scenarios.pilot import Phase, Pilot
from scenarios.recording.state_log import StateLog
from scenarios.recording.vehicle_recorder import VehicleRecorder

_SAMPLE_S = 0.1
_TRACK_PERIOD_US = 200_000
"""Simulated time between two writings of tracks, the period of the pilot's looks."""


class PilotLog:
    """Samples the pilot after every tick and records what is new."""

    def __init__(self, pilot: Pilot, recorder: VehicleRecorder) -> None:
        self._pilot = pilot
        self._recorder = recorder
        self._plan: Trajectory | None = None
        self._landing_map: object = None
        self._tracks_due_us = 0
        self._n_transitions = 0
        self._n_replans = 0
        recorder.log_phase(0, pilot.phase.value)

    def on_tick(self, time_us: int) -> None:
        """Record a new plan, a new landing map, tracks of movers and new transitions.

        Args:
            time_us: Simulated time after the tick.
        """
        pilot, recorder = self._pilot, self._recorder
        # By identity, because each plan of the pilot is a new object.
        if pilot.trajectory is not self._plan:
            self._plan = pilot.trajectory
            recorder.plans.log(time_us, _points(self._plan), self._plan.duration_s)
        if recorder.states is not None:
            self._log_sights(time_us, recorder.states)
        self._log_decisions()

    def _log_sights(self, time_us: int, states: StateLog) -> None:
        """Record the landing map and the tracks of movers."""
        pilot = self._pilot
        landing_map = pilot.landing_map
        if landing_map is not None and landing_map is not self._landing_map:
            self._landing_map = landing_map
            states.landing.log(time_us, landing_map, pilot.touchdown_enu_m)
        if time_us >= self._tracks_due_us:
            self._tracks_due_us = time_us + _TRACK_PERIOD_US
            states.tracks.log(time_us, pilot.moving)

    def _log_decisions(self) -> None:
        pilot, recorder = self._pilot, self._recorder
        for transition in pilot.transitions[self._n_transitions :]:
            # A failure must stand out among the messages.
            severity = Severity.ERROR if transition.target is Phase.FAILED else Severity.INFO
            text = f"pilot: {transition.target.value}: {transition.reason}"
            recorder.log_statustext(transition.time_us, severity, text)
            recorder.log_phase(transition.time_us, transition.target.value)
        self._n_transitions = len(pilot.transitions)
        for replan in pilot.replans[self._n_replans :]:
            text = f"pilot: new plan: {replan.reason}"
            recorder.log_statustext(replan.time_us, Severity.INFO, text)
        self._n_replans = len(pilot.replans)


def _points(plan: Trajectory) -> np.ndarray:
    """Return points along a plan, evenly in time and including its end."""
    n_steps = max(1, round(plan.duration_s / _SAMPLE_S))
    return plan.positions(np.linspace(0.0, plan.duration_s, n_steps + 1))
