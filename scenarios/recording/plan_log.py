"""Plans in a recording: the present one bright, earlier ones dim, each with its time."""

from __future__ import annotations

import numpy as np
import rerun as rr
from jaxtyping import Float

from scenarios.recording import layout
from scenarios.recording.columns import set_sim_time
from scenarios.recording.entity_stream import EntityStream

PLANNED_RGB, FLOWN_RGB, REPLACED_RGB = (255, 80, 200), (150, 70, 125), (120, 120, 130)
_ON_TIME_S = 0.05  # A plan that is replaced this shortly before its end was flown as a whole.


class PlanLog:
    """Writes each plan when it takes effect, and its fate when the next one does.

    A plan that was flown to its end becomes a dim line of the same colour. A plan that was replaced
    earlier becomes grey from the place where the vehicle left it.
    """

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._last: tuple[int, np.ndarray, float] | None = None
        self._n_plans = 0
        style = rr.LineStrips3D.from_fields(colors=PLANNED_RGB, radii=rr.Radius.ui_points(1.5))
        stream.log(layout.PLANNED, style, static=True)
        thin = rr.LineStrips3D.from_fields(radii=rr.Radius.ui_points(1.0), show_labels=False)
        stream.log(layout.EARLIER_PLANS, thin, static=True)

    def log(self, time_us: int, points_enu_m: Float[np.ndarray, "n 3"], duration_s: float) -> None:
        """Write a plan that takes effect, and the fate of the one before.

        Args:
            time_us: Simulated time at which it takes effect.
            points_enu_m: Points along all of it, evenly in time, from its start to its end.
            duration_s: Duration of the plan.
        """
        set_sim_time(self._stream, time_us)
        if self._last is not None:
            self._log_earlier(time_us, *self._last)
        self._n_plans += 1
        points = points_enu_m.astype(np.float32)
        self._stream.log(
            layout.PLANNED,
            rr.LineStrips3D.from_fields(strips=[points], labels=[self._name(time_us)]),
            # The strip has no times; its points are even in time, so the duration gives them.
            rr.AnyValues(duration_s=duration_s),
        )
        self._last = (time_us, points, duration_s)

    def _log_earlier(
        self, time_us: int, begun_us: int, points: np.ndarray, duration_s: float
    ) -> None:
        flown_s = (time_us - begun_us) * 1e-6
        name = self._name(begun_us)
        if flown_s > duration_s - _ON_TIME_S:
            strips, colours, labels = [points], [FLOWN_RGB], [name]
        else:
            # Points are even in time, so the share of time gives the index. A line needs two.
            left_at = max(1, round(flown_s / duration_s * (len(points) - 1)))
            strips = [points[: left_at + 1], points[left_at:]]
            colours = [FLOWN_RGB, REPLACED_RGB]
            labels = [name, f"{name}, replaced at {time_us * 1e-6:.1f} s"]
        earlier = rr.LineStrips3D.from_fields(strips=strips, colors=colours, labels=labels)
        self._stream.log(layout.EARLIER_PLANS, earlier)

    def _name(self, time_us: int) -> str:
        return f"plan {self._n_plans} since {time_us * 1e-6:.1f} s"
