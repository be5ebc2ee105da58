"""Samples of the optical-flow sensor in a recording, as the sensor reports them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenarios.recording import layout
from scenarios.recording.columns import send_scalars, sim_time
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    from flightsim.plant import Plant


class FlowLog:
    """Keeps each new sample until it is written with the others of its second."""

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._times_us: list[int] = []
        self._samples: list[tuple[float, ...]] = []
        self._last_us = 0

    def on_tick(self, plant: Plant) -> None:
        """Take the newest sample of a plant, unless it was taken already.

        Args:
            plant: Plant after a tick; one without the sensor adds nothing.
        """
        sample = plant.sensors.optical_flow
        # The integration time of a sensor that is not fitted stays zero.
        if sample.integration_us == 0 or sample.time_us == self._last_us:
            return
        self._last_us = sample.time_us
        self._times_us.append(sample.time_us)
        angles = (*sample.flow_frd_rad, *sample.gyro_frd_rad)
        self._samples.append((sample.integration_us, *angles, sample.distance_m, sample.quality))

    def flush(self) -> None:
        """Write the samples, in the order of `layout.OPTICAL_FLOW_PARTS`."""
        if self._samples:
            time = sim_time(np.array(self._times_us))
            send_scalars(self._stream, layout.OPTICAL_FLOW, time, np.array(self._samples))
            self._times_us.clear()
            self._samples.clear()
