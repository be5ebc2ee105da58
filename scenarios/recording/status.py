"""Reports of the autopilot in a recording: mode, armed state, battery, estimated errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from scenarios.recording import layout
from scenarios.recording.columns import send_scalars, set_sim_time, sim_time
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    from flightsim.autopilot.reports import FlightReports
    from flightsim.plant import Plant

SAMPLE_TICKS = 5
"""Number of ticks of 20 ms between two samples of every gauge."""

# Entity, legend, colour, and the function that reads the value.
_Gauge = tuple[str, str, tuple[int, int, int], "Callable[[Plant], float]"]

_ACROSS, _UPWARDS = f"{layout.POSITION_SIGMA}/horizontal", f"{layout.POSITION_SIGMA}/vertical"
_GAUGES: tuple[_Gauge, ...] = (
    (layout.BATTERY_VOLTAGE, "voltage V", (240, 210, 70), lambda p: p.battery.voltage_v),
    (layout.BATTERY_CURRENT, "current A", (230, 80, 80), lambda p: p.battery.current_a),
    (layout.BATTERY_REMAINING, "remaining %", (90, 200, 90), lambda p: 100 * p.battery.remaining),
    (_ACROSS, "sigma horizontal m", (190, 120, 255), lambda p: p.estimator.sigma_horizontal_m),
    (_UPWARDS, "sigma vertical m", (60, 200, 190), lambda p: p.estimator.sigma_vertical_m),
)
_SENSORS_RGB = ((255, 150, 50), (60, 200, 190), (190, 120, 255), (240, 210, 70))


def _sensor_gauges() -> Iterator[_Gauge]:
    """Yield the gauges of the sensors that have something to plot."""
    from flightsim.plant.sensing import SENSORS

    found = [(sensor, *sensor.gauge) for sensor in SENSORS if sensor.gauge]
    for (sensor, legend, value), rgb in zip(found, cycle(_SENSORS_RGB), strict=False):
        yield (
            layout.sensor(sensor.setting),
            legend,
            rgb,
            # Defaults bind the present sensor; a plain closure would read the last one.
            lambda plant, sensor=sensor, value=value: value(plant.sensors.read(sensor)),
        )


_ARMED_RGB = {"disarmed": (90, 96, 105), "armed": (220, 70, 70)}


class StatusLog:
    """Samples gauges into columns and writes states when they change."""

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._ticks = 0
        self._times_us: list[int] = []
        self._samples: list[tuple[float, ...]] = []
        self._states: dict[str, str] = {}
        self._gauges = (*_GAUGES, *_sensor_gauges())
        for entity, name, rgb, _ in self._gauges:
            stream.log(entity, rr.SeriesLines(names=name, colors=rgb, widths=1.2), static=True)
        colours = list(_ARMED_RGB.values())
        states = rr.StateConfiguration(values=list(_ARMED_RGB), colors=colours)
        stream.log(layout.ARMED, states, static=True)

    def on_tick(self, plant: Plant, autopilot: FlightReports | None) -> None:
        """Sample the vehicle after a tick.

        Args:
            plant: Plant of the vehicle.
            autopilot: Reports of the flight stack; None writes no states.
        """
        time_us = plant.time_us
        if autopilot is not None:
            failsafe = autopilot.failsafe
            self._set_state(time_us, layout.MODE, autopilot.mode.value)
            self._set_state(time_us, layout.ARMED, "armed" if autopilot.is_armed else "disarmed")
            self._set_state(time_us, layout.LANDED, autopilot.landed_state.value)
            self._set_state(time_us, layout.FAILSAFE, failsafe.value if failsafe else "none")
        if self._ticks % SAMPLE_TICKS == 0:
            self._times_us.append(time_us)
            self._samples.append(tuple(read(plant) for _, _, _, read in self._gauges))
        self._ticks += 1

    def flush(self) -> None:
        """Write the buffered samples."""
        if not self._samples:
            return
        time = sim_time(np.array(self._times_us))
        values = np.array(self._samples)
        # A gap in a plot means "nothing measured". An infinite value would spoil its axis.
        values[~np.isfinite(values)] = math.nan
        self._times_us.clear()
        self._samples.clear()
        for (entity, _, _, _), column in zip(self._gauges, values.T, strict=True):
            send_scalars(self._stream, entity, time, column[:, None])

    def _set_state(self, time_us: int, entity: str, state: str) -> None:
        if self._states.get(entity) == state:
            return
        self._states[entity] = state
        set_sim_time(self._stream, time_us)
        self._stream.log(entity, rr.StateChange(state=state))
