"""What our own pilot plans, sees and decides, into a recording."""

from __future__ import annotations

import numpy as np

from autonomy.planning import Trajectory
from flightsim.autopilot.events import Severity
from scenarios.pilot import Phase, Pilot
from scenarios.recording.recorder import Recorder

_SAMPLE_S = 0.1


class PilotLog:
    """Looks at the pilot after every tick and records what is new."""

    def __init__(self, pilot: Pilot, recorder: Recorder) -> None:
        self._pilot = pilot
        self._recorder = recorder
        self._legs_enu_m: dict[Trajectory, np.ndarray] = {}
        self._landing_map: object = None
        self._n_transitions = 0

    def on_tick(self, time_us: int) -> None:
        """Record a new plan, a new landing map, new transitions."""
        pilot, recorder = self._pilot, self._recorder
        leg = pilot.trajectory
        if leg not in self._legs_enu_m:
            times_s = np.arange(0.0, leg.duration_s + _SAMPLE_S, _SAMPLE_S)
            self._legs_enu_m[leg] = leg.positions(times_s)
            recorder.log_plan(time_us, list(self._legs_enu_m.values()))
        landing_map = pilot.landing_map
        if landing_map is not None and landing_map is not self._landing_map:
            self._landing_map = landing_map
            recorder.log_landing_map(
                time_us, landing_map.cells_enu_m, landing_map.cost, pilot.touchdown_enu_m
            )
        for transition in pilot.transitions[self._n_transitions :]:
            severity = Severity.ERROR if transition.target is Phase.FAILED else Severity.INFO
            text = f"pilot: {transition.target.value}: {transition.reason}"
            recorder.log_statustext(transition.time_us, severity, text)
        self._n_transitions = len(pilot.transitions)
