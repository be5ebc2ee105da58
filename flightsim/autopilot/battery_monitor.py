"""Battery monitor: reports the charge, and warns when it runs low."""

from __future__ import annotations

from flightsim.autopilot.events import EventLog, Severity
from flightsim.autopilot.modes import BatteryWarning
from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.status import BatteryView
from flightsim.sensors.failure import Failure
from flightsim.vehicles.battery import Battery

_TEXTS = {
    BatteryWarning.LOW: (Severity.WARNING, "Low battery level, return advised"),
    BatteryWarning.CRITICAL: (Severity.CRITICAL, "Critical battery level, land now"),
    BatteryWarning.EMERGENCY: (Severity.EMERGENCY, "Dangerous battery level, landing is urgent"),
}

BATTERY_FAILURES = frozenset({Failure.NONE, Failure.OFF, Failure.WRONG, Failure.STUCK})
"""Kinds of failure that the battery monitor can have."""
_WRONG_REMAINING = 0.1  # charge that a wrong monitor reads at most: low, so that failsafes act


class BatteryMonitor:
    """Battery state for reports, with a warning level that only rises while armed."""

    def __init__(self, parameters: Parameters, events: EventLog, n_cells: int) -> None:
        self._parameters = parameters
        self._events = events
        self._n_cells = n_cells
        self.warning = BatteryWarning.NONE
        self.failure = Failure.NONE
        """Injected failure. OFF reads an empty battery, as in PX4; WRONG reads 10% at most; STUCK
        repeats the last charge."""
        self.view = BatteryView(n_cells=n_cells)

    def update(self, battery: Battery, *, is_armed: bool) -> None:
        """Read the battery, update `view` and `warning`, and announce each new warning level.

        Args:
            battery: Simulated battery.
            is_armed: True keeps the highest warning so far; on the ground it may fall again.
        """
        remaining = self._read(battery.remaining)
        level = self._level(remaining)
        if level > self.warning and level in _TEXTS:
            self._events.report(*_TEXTS[level])
        self.warning = max(level, self.warning) if is_armed else level
        self.view = BatteryView(
            voltage_v=battery.voltage_v,
            current_a=battery.current_a,
            consumed_mah=battery.consumed_mah,
            remaining=remaining,
            warning=self.warning,
            n_cells=self._n_cells,
        )

    def _read(self, remaining: float) -> float:
        said = {
            Failure.OFF: 0.0,
            Failure.WRONG: min(remaining, _WRONG_REMAINING),
            Failure.STUCK: self.view.remaining,
        }
        return said.get(self.failure, remaining)

    def _level(self, remaining: float) -> BatteryWarning:
        p = self._parameters
        if remaining < p["BAT_EMERGEN_THR"]:
            return BatteryWarning.EMERGENCY
        if remaining < p["BAT_CRIT_THR"]:
            return BatteryWarning.CRITICAL
        return BatteryWarning.LOW if remaining < p["BAT_LOW_THR"] else BatteryWarning.NONE
