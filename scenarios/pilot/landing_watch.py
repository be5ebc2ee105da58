"""Landing watch: maps a landing area with the downward camera and chooses where to touch down.

It joins the judgement of the ground (`autonomy.perception`) with knowledge that depth from above
cannot give: the area's outline, and the free column above each cell by the map. Each search begins
with an empty map, because the estimate may have moved since the last one.
"""

from __future__ import annotations

import math

import numpy as np

from aeroscene.scene import InteractionArea
from autonomy.perception import (
    DepthImage,
    ElevationMap,
    LandingMap,
    LandingNeeds,
    LandingSite,
    assess,
    choose_site,
    objection,
    site_at,
)
from autonomy.perception.needs import MAX_RISE_M, MAX_ROUGHNESS_M
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.surroundings import Surroundings

CAMERA = "down"
FRAME_PERIOD_US = 200_000
SCATTER_M = 0.1
"""Greatest horizontal error of a touchdown: estimate, tracking and map together."""
PERCHING_SCATTER_M = 0.05
"""Greatest error that a perch allows: places of 22 cm for feet of 17 cm."""
_BORDER_M = 0.8
"""Width of the map's border around the area."""
_MAX_HALF_EXTENT_M = 4.0  # half the width of the map, at most
# Grid of the check of the air above the cells, coarser than they are, and the room it needs.
_COLUMN_STEP_M = 0.25
_COLUMN_MARGIN_M = 0.05
_ROUGHNESS = 1.0 / 7.0
"""Height range under the feet over their stance: 8 deg with one foot so much higher."""
_RISE = 0.7
"""Rise within the body's radius over the height of the rotors."""
_SEEN_M = 0.02
"""Least height that counts, above the noise of the map."""
# Least distance of a chosen place to unsafe cells.
_LEAST_CLEARANCE_M = 0.1
_LEAST_PERCHING_CLEARANCE_M = 0.05


def landing_needs(airframe: Airframe, scatter_m: float = SCATTER_M) -> LandingNeeds:
    """Return the needs of an airframe for standing safely within the scatter of a touchdown.

    Args:
        airframe: The vehicle; its legs, rotors and size count.
        scatter_m: Greatest horizontal error of a touchdown.
    """
    lowest_hub_m = min(rotor.position_flu_m[2] for rotor in airframe.quadrotor.rotors)
    hub_height_m = airframe.leg_length_m + lowest_hub_m
    return LandingNeeds(
        footprint_radius_m=airframe.leg_spread_m + scatter_m,
        body_radius_m=airframe.collision_radius_m + scatter_m,
        max_roughness_m=_within(_ROUGHNESS * 2.0 * airframe.leg_spread_m, MAX_ROUGHNESS_M),
        max_rise_m=_within(_RISE * hub_height_m, MAX_RISE_M),
    )


def _within(needed_m: float, most_m: float) -> float:
    """Limit a vehicle's tolerance to the range from what can be seen to a common vehicle's."""
    return min(max(needed_m, _SEEN_M), most_m)


class LandingWatch:
    """One observation of one area; a new one starts with an empty map.

    Attributes:
        n_frames: Depth images fused so far.
        n_blind: Images without a measured pixel since the last one fused.
        is_hovering: True once the vehicle has come to the hover point.
        n_hovering: Depth images since then.
        sway_m: Greatest level deviation from the hover point while it was observed.
        elevation: Elevation map fused so far.
        is_allowed: Cells that may be landed on: within the area, and free above.
        map: Latest assessment of the area, None before the first.
    """

    def __init__(
        self, surroundings: Surroundings, area: InteractionArea, hover_enu_m: Vector3
    ) -> None:
        """Start with an empty map of an area.

        Args:
            surroundings: Prior map of the scene.
            area: Area to land on.
            hover_enu_m: Hover point from which it is observed.
        """
        is_perch = area.kind == "perching"
        self._needs = landing_needs(
            surroundings.airframe, PERCHING_SCATTER_M if is_perch else SCATTER_M
        )
        self._least_m = _LEAST_PERCHING_CLEARANCE_M if is_perch else _LEAST_CLEARANCE_M
        self._preferred_enu_m = area.centroid
        reach_m = max(math.dist(corner[:2], area.centroid[:2]) for corner in area.polygon)
        half_extent_m = min(reach_m + _BORDER_M, _MAX_HALF_EXTENT_M)
        self.elevation = ElevationMap(area.centroid, half_extent_m=half_extent_m)
        self._world, self._span_m = surroundings, (area.centroid[2], hover_enu_m[2])
        self._is_within = self.elevation.cells_within(area.polygon)
        self.is_allowed = self._is_within & _is_open_above(
            self.elevation, surroundings, *self._span_m
        )
        self._due_us = 0
        self.n_frames = 0
        self.n_blind = 0
        self.is_hovering = False
        self.n_hovering = 0
        self.sway_m = 0.0
        self.map: LandingMap | None = None

    def is_due(self, time_us: int) -> bool:
        """Return whether the next depth image may be fused."""
        return time_us >= self._due_us

    def miss(self, time_us: int) -> None:
        """Skip an image without a measured pixel; the next is due one period later."""
        self.n_blind += 1
        self._due_us = time_us + FRAME_PERIOD_US

    def fuse(self, time_us: int, image: DepthImage) -> None:
        """Fuse a depth image of the downward camera, and judge the area anew."""
        self._due_us = time_us + FRAME_PERIOD_US
        self.elevation.add(image)
        self.n_blind = 0
        self.n_frames += 1
        if not self._world.is_known:
            # Each image shows more of the air below.
            self.is_allowed = self._is_within & _is_open_above(
                self.elevation, self._world, *self._span_m
            )
        self.map = assess(self.elevation, self._needs, self.is_allowed)

    def choose(self) -> LandingSite | None:
        """Return the best place in the present map, None if none is safe with enough room."""
        if self.map is None:
            return None
        site = choose_site(self.map, self.elevation, self._needs, self._preferred_enu_m)
        return site if site is not None and site.clearance_m >= self._least_m else None

    def objection(self, site: LandingSite) -> str | None:
        """Return the reason against a chosen place by the present map, None if there is none."""
        if self.map is None:
            return "nothing was seen yet"
        return objection(self.map, self.elevation, self._needs, site.position_enu_m)

    def site_below(self, place_enu_m: Vector3) -> LandingSite | None:
        """Return the place right below a position if it could have been chosen, else None."""
        if self.map is None:
            return None
        site = site_at(self.map, self.elevation, place_enu_m)
        if site is None or site.clearance_m < self._least_m:
            return None
        return site if self.objection(site) is None else None

    def again(self, site: LandingSite) -> LandingSite:
        """Return a chosen place with its present height and slope."""
        latest = (
            None if self.map is None else site_at(self.map, self.elevation, site.position_enu_m)
        )
        return site if latest is None else latest


def _is_open_above(
    elevation: ElevationMap, surroundings: Surroundings, surface_m: float, top_m: float
) -> np.ndarray:
    """Mark cells above which the vehicle has room from just over the surface up to a height.

    A given map has branches and eaves that a camera below them cannot see.
    """
    stride = max(1, round(_COLUMN_STEP_M / elevation.resolution_m))
    east, north = (axis[::stride] for axis in elevation.cell_centres())
    lowest_m = surface_m + surroundings.lift_m + surroundings.radius_m + _COLUMN_STEP_M
    heights = np.arange(lowest_m, top_m + _COLUMN_STEP_M / 2, _COLUMN_STEP_M)
    z, y, x = np.meshgrid(heights, north, east, indexing="ij")
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    room_m = surroundings.map.rough_distance_m(points) - surroundings.radius_m
    is_open = np.all(room_m.reshape(z.shape) >= _COLUMN_MARGIN_M, axis=0)
    n = len(elevation.height_m)
    # Each coarse cell becomes a block of the map's cells, cut to the map's size.
    return np.kron(is_open, np.ones((stride, stride), dtype=bool))[:n, :n]
