"""The landing map in a recording: layers to switch between, and the points that were chosen.

The map is the largest part of a recording of states, because every look of the pilot changes it.
Safety alone is therefore written with every look. The other layers follow once a second, thinned
for the viewer, and as one grid of half-precision numbers from which pictures are drawn later.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
from jaxtyping import Float, UInt8

from autonomy.types import Vector3
from scenarios.recording import layout
from scenarios.recording.columns import set_sim_time
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    # Reading a recording should not load perception.
    from autonomy.perception import LandingMap

LAYER_PERIOD_US = 1_000_000
"""Simulated time from one writing of all layers to the next; safety is written with every look."""
_THINNED = 2
"""Step in cells along each axis at which layers that are switched off are drawn."""
_CELL_RADIUS_M = 0.025
SAFE_RGB, UNSAFE_RGB = (60, 200, 90), (220, 50, 40)
_LOW_RGB, _HIGH_RGB = (40, 60, 160), (255, 230, 60)
_STEEP_RAD, _ROUGH_M = math.radians(20.0), 0.08
"""Slope and roughness of the brightest colour: twice the limits of a vehicle."""
TOUCHDOWN_RGB, _TOUCHDOWN_RADIUS_M = (255, 255, 255), 0.08
CHOICE_RGB, _CHOICE_RADIUS_M = (255, 190, 60), 0.05
_SAME_PLACE_M = 0.01


class LandingLog:
    """Writes the pilot's map of the ground on which it wants to land."""

    def __init__(self, stream: EntityStream) -> None:
        self._stream = stream
        self._layers_due_us = 0
        self._chosen_enu_m: Vector3 | None = None

    def log(self, time_us: int, landing: LandingMap, touchdown_enu_m: Vector3 | None) -> None:
        """Write a map, and the touchdown point that was chosen on it.

        Args:
            time_us: Simulated time at which the map was known.
            landing: Map in the pilot's own frame, which errs as the estimate does.
            touchdown_enu_m: Chosen point; None as long as there is none.
        """
        set_sim_time(self._stream, time_us)
        cells_enu_m, cost = landing.cells_enu_m, landing.cost
        self._log_points(layout.LANDING_SAFETY, cells_enu_m, _mixed(cost, SAFE_RGB, UNSAFE_RGB))
        is_new = touchdown_enu_m is not None and self._is_elsewhere(touchdown_enu_m)
        if is_new or time_us >= self._layers_due_us:
            self._layers_due_us = time_us + LAYER_PERIOD_US
            self._log_layers(landing)
        if touchdown_enu_m is not None:
            point = rr.Points3D([touchdown_enu_m], colors=TOUCHDOWN_RGB, radii=_TOUCHDOWN_RADIUS_M)
            self._stream.log(layout.TOUCHDOWN, point)
            if is_new:
                self._log_choice(time_us, touchdown_enu_m)
        self._chosen_enu_m = touchdown_enu_m

    def _is_elsewhere(self, place_enu_m: Vector3) -> bool:
        """Return true if a place differs from the last one horizontally."""
        last = self._chosen_enu_m
        return last is None or math.dist(last[:2], place_enu_m[:2]) > _SAME_PLACE_M

    def _log_choice(self, time_us: int, place_enu_m: Vector3) -> None:
        words = [f"chosen at {time_us * 1e-6:.1f} s"]
        choice = rr.Points3D([place_enu_m], colors=CHOICE_RGB, radii=_CHOICE_RADIUS_M, labels=words)
        self._stream.log(layout.CHOICES, choice)

    def _log_layers(self, landing: LandingMap) -> None:
        """Write all layers: thinned for the viewer, whole for pictures."""
        seen = landing.is_observed
        shown = np.zeros_like(seen)
        shown[::_THINNED, ::_THINNED] = seen[::_THINNED, ::_THINNED]
        cells_enu_m = landing.cells_enu_m[shown[seen]]
        for entity, values, top in (
            (layout.LANDING_SLOPE, landing.slope_rad, _STEEP_RAD),
            (layout.LANDING_ROUGHNESS, landing.roughness_m, _ROUGH_M),
            (layout.LANDING_CLEARANCE, landing.clearance_m, landing.enough_clearance_m),
        ):
            # A cell without a value gets the brightest colour.
            share = np.nan_to_num(values[shown].astype(float) / top, nan=1.0)
            self._log_points(entity, cells_enu_m, _mixed(share, _LOW_RGB, _HIGH_RGB), _THINNED)
        east_m, north_m = landing.axes_enu_m
        self._stream.log(
            layout.LANDING_GRID,
            rr.AnyValues(
                east_m=east_m,
                north_m=north_m,
                is_observed=seen.ravel(),
                is_safe=landing.is_safe[seen],
                # Half precision has steps of 16 mm beyond 16 m, which is too coarse for heights.
                height_m=landing.height_m[seen].astype(np.float32),
                slope_rad=landing.slope_rad[seen].astype(np.float16),
                roughness_m=landing.roughness_m[seen].astype(np.float16),
                clearance_m=landing.clearance_m[seen].astype(np.float16),
            ),
        )

    def _log_points(
        self, entity: str, cells_enu_m: np.ndarray, colours: np.ndarray, width: int = 1
    ) -> None:
        points = rr.Points3D(cells_enu_m, colors=colours, radii=width * _CELL_RADIUS_M)
        self._stream.log(entity, points)


def _mixed(
    share: Float[np.ndarray, " n"], low_rgb: tuple[int, int, int], high_rgb: tuple[int, int, int]
) -> UInt8[np.ndarray, "n 3"]:
    """Return colours from `low_rgb` at 0 to `high_rgb` at 1 and above."""
    part = np.clip(share, 0.0, 1.0)[:, None]
    return ((1 - part) * np.array(low_rgb) + part * np.array(high_rgb)).astype(np.uint8)
