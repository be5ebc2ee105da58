"""Map of a place not known before: cells seen free, seen occupied, or not seen.

Whatever was not seen free is an obstacle to the proof of a plan.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from autonomy.mapping.cell_states import note_changes, note_freed, unseen_states
from autonomy.mapping.distances import boxes_about, distance_to_cells, slices
from autonomy.mapping.rays import (
    FREE_AT,
    HIT,
    MOST_FREE,
    MOST_OCCUPIED,
    OCCUPIED_AT,
    Cells,
    integrate,
)
from autonomy.mapping.renewal import gauge_for, renew, renew_routes, unseen
from autonomy.mapping.seen_map_cfg import SeenMapCfg
from autonomy.perception.depth_image import DepthImage
from autonomy.planning.field import DistanceField
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.openings import Opening
from autonomy.planning.search import SeenRoom
from autonomy.types import Vector3

UNSEEN_LACK = 0.25
"""Share of comfortable less needed distance that cells without seen room lack for the search."""
_SURFACE_M = 0.05
_N_NUMBERS = 127


class SeenMap:
    """Cells of a flight volume.

    Attributes:
        evidence: Of each cell: free up to `FREE_AT`, occupied from `OCCUPIED_AT` on, else unknown.
        n_looks: Images so far of the camera that looks ahead.
        is_given: False: the map grows with what is seen.
        eye_enu_m: Camera position of the last image; the start before the first one.
    """

    is_given = False

    def __init__(
        self, low_enu_m: Vector3, high_enu_m: Vector3, cfg: SeenMapCfg | None = None
    ) -> None:
        """Create an empty map of a flight volume, cut to a whole number of cells."""
        self.cfg = SeenMapCfg() if cfg is None else cfg
        self.corner_enu_m = np.array(low_enu_m, dtype=float)
        size = (np.array(high_enu_m) - self.corner_enu_m) / self.cfg.resolution_m
        shape = np.maximum(np.floor(size + 1e-6), 1).astype(np.int64)
        self.evidence = np.zeros(shape, dtype=np.int8)
        self.n_looks = 0
        self._n_images = 0
        x, y, z = ((np.array(low_enu_m) + high_enu_m) / 2).tolist()
        self.eye_enu_m: Vector3 = (x, y, z)
        self._seen_in = np.zeros(shape, dtype=np.int8)
        # Cells that were seen free since they were last known to stand.
        self._was_free = np.zeros(shape, dtype=np.bool_)
        self._gauge = gauge_for(self.evidence.shape, self.cfg.resolution_m, self.cfg.cap_m)
        self._distances = unseen(self.evidence.shape, self.cfg.cap_m)
        # States for which these distances hold, but for blocks of cells that it lists as stale.
        self._states = unseen_states(self.evidence.shape, self._gauge.reach)
        self._needed_m = 0.0
        # First cell, and the cell beyond the last, whose evidence may have changed since then.
        self._changed = np.array([shape, np.zeros(3, dtype=np.int64)])
        self._obstacles: Obstacles | None = None

    def observe(self, image: DepthImage, *, is_ahead: bool = True) -> None:
        """Update the map with a depth image, of the camera that looks ahead or of another one."""
        cfg = self.cfg
        self.n_looks += is_ahead
        self._n_images += 1
        integrate(
            Cells(self.evidence, self._seen_in, self.corner_enu_m, cfg.resolution_m),
            1 + self._n_images % _N_NUMBERS,
            image.pixels,
            cfg.max_range_m,
            image.inverse_depth_sigma_pm,
        )
        self.eye_enu_m = image.position_enu_m
        ends = np.array([image.position_enu_m, *image.corners_enu_m(cfg.max_range_m)])
        block = self.block_about(self.cells(ends), cfg.resolution_m)
        note_freed(self.evidence, block[0], block[1], self._was_free)
        self._change(block)

    def assume_free_column(
        self, foot_enu_m: Vector3, *, radius_m: float = 1.1, height_m: float = 3.4
    ) -> None:
        """Assume that the air above the start is free, until it is seen otherwise.

        The column is higher than the vehicle rises before it looks around.
        """
        reach = (radius_m, radius_m, height_m)
        low = self.cells(np.array(foot_enu_m) - (radius_m, radius_m, 0.0))
        high = self.cells(np.array(foot_enu_m) + reach) + 1
        block = self._within(np.array([low, high]))
        x, y, z = self._away_from(foot_enu_m, block)
        # A cell whose middle the surface just reaches stands for the air above it.
        is_assumed = (np.hypot(x, y) <= radius_m) & (z >= -_SURFACE_M) & (z <= height_m)
        part = self.evidence[slices(block)]
        part[is_assumed & (part < OCCUPIED_AT)] = MOST_FREE
        self.eye_enu_m = foot_enu_m
        self._change(block)

    def be_at(self, position_enu_m: Vector3, radius_m: float, sole_m: float) -> None:
        """Take the air that a vehicle fills for free, but for cells that several images hit.

        A camera that looks ahead does not see the air around the vehicle again, so what noise
        marked there would stay. Nothing below the soles, `sole_m` lower than the position, counts.
        """
        at = np.array(position_enu_m)
        block = self._within(np.array([self.cells(at - radius_m), self.cells(at + radius_m) + 1]))
        half = self.cfg.resolution_m / 2
        away = self._away_from(position_enu_m, block)
        gaps = [np.maximum(np.abs(axis) - half, 0.0) for axis in away]
        part = self.evidence[slices(block)]
        is_marked = (part > FREE_AT) & (part < MOST_OCCUPIED) & (away[2] >= -sole_m - _SURFACE_M)
        is_filled = is_marked & (sum(gap * gap for gap in gaps) < radius_m**2)
        if np.any(is_filled):
            part[is_filled] = FREE_AT
            self._change(block)

    def give_up(self, cells: Int[np.ndarray, "n 3"]) -> None:
        """Assume that cells that could not be seen are occupied, until they are seen."""
        self.evidence[tuple(cells.T)] = OCCUPIED_AT
        self._change(np.array([cells.min(axis=0), cells.max(axis=0) + 1]))

    def cells(self, points_enu_m: Float[np.ndarray, "*b 3"]) -> Int[np.ndarray, "*b 3"]:
        """Indices of the cells that hold the points."""
        offset = (np.asarray(points_enu_m) - self.corner_enu_m) / self.cfg.resolution_m
        return np.floor(offset).astype(np.int64)

    def centres(self, cells: Int[np.ndarray, "*b 3"]) -> Float[np.ndarray, "*b 3"]:
        """Centres of cells, ENU, m."""
        return self.corner_enu_m + (np.asarray(cells) + 0.5) * self.cfg.resolution_m

    def distance_to_seen_m(
        self, points_enu_m: Float[np.ndarray, "k 3"], at_least: int = HIT
    ) -> Float[np.ndarray, " k"]:
        """Distance to the nearest cell with enough evidence of a hit, up to five cells."""
        points = np.ascontiguousarray(points_enu_m, dtype=float)
        return distance_to_cells(
            points, self.evidence, at_least, self.corner_enu_m, self.cfg.resolution_m
        )

    def static_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance to the nearest cell that several images hit, so that no mover did.

        It is 0 where nothing was ever free: no mover counts there.
        """
        distance_m = np.zeros(len(points_enu_m))
        was_free = np.flatnonzero(self._at(self._was_free, points_enu_m))
        distance_m[was_free] = self.distance_to_seen_m(points_enu_m[was_free], MOST_OCCUPIED)
        return distance_m

    def rough_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance from the middles of the points' cells to everything that was not seen free."""
        return self._at(self.field.distance_m, points_enu_m)

    def distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance to everything that was not seen free, at most 0 within it."""
        away_m = self._obstacles_about(points_enu_m).signed_distance(points_enu_m)[0]
        # Of what was not seen free the boxes hold the skin only.
        is_free = self._at(self.evidence <= FREE_AT, points_enu_m)
        return np.where(is_free, away_m, np.minimum(away_m, 0.0))

    def find_openings(self) -> Sequence[Opening]:
        """No passages: a growing map does not look for them."""
        return ()

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Always true: unseen cells may be free."""
        del point_enu_m
        return True

    @property
    def field(self) -> DistanceField:
        """Distance field of everything that was not seen free."""
        self._refresh()
        return self._as_field(self._distances.to_not_free, np.zeros(3, dtype=np.int64))

    @property
    def obstacles(self) -> Obstacles:
        """Boxes over everything near the camera that was not seen free, and all beyond that."""
        if self._obstacles is None:
            at, reach = np.array(self.eye_enu_m), self.cfg.nearby_m
            block = self._within(np.array([self.cells(at - reach), self.cells(at + reach) + 1]))
            self._obstacles = self.obstacles_in(block)
        return self._obstacles

    def _obstacles_about(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Obstacles:
        """Boxes over everything about some points that was not seen free, and all beyond that."""
        away = np.abs(points_enu_m - np.array(self.eye_enu_m))
        if np.all(away < self.cfg.nearby_m - self.cfg.cap_m):
            return self.obstacles
        return self.obstacles_in(self.block_about(self.cells(points_enu_m), self.cfg.cap_m))

    def obstacles_in(self, block: Int[np.ndarray, "2 3"]) -> Obstacles:
        """Boxes over everything in a block of cells that was not seen free, and all outside it."""
        is_free = np.ascontiguousarray(self.evidence[slices(block)] <= FREE_AT)
        corner = self.corner_enu_m + block[0] * self.cfg.resolution_m
        return boxes_about(is_free, corner, self.cfg.resolution_m)

    def field_in(self, block: Int[np.ndarray, "2 3"]) -> DistanceField:
        """Distance field of a block of cells, to everything that was not seen free."""
        self._refresh()
        part = np.ascontiguousarray(self._distances.to_not_free[slices(block)])
        return self._as_field(part, block[0])

    def route_m(self, needed_m: float) -> Float[np.ndarray, "nx ny nz"]:
        """Distances for a search that also passes unseen cells, at a price.

        Where there is less than `needed_m` to what was seen occupied the distance to that, else,
        where that much room was not seen free, a distance that is less than comfortable.
        """
        self._refresh()
        self._need(needed_m)
        return self._distances.route

    def seen_room(self, needed_m: float) -> SeenRoom:
        """Cells with as much room that was seen free, for a search."""
        self._refresh()
        self._need(needed_m)
        layers = np.flatnonzero(self._distances.n_roomy)
        top = int(layers[-1]) if len(layers) else -1
        return SeenRoom(self._distances.to_not_free, _single(needed_m), top)

    def block_about(self, cells: Int[np.ndarray, "n 3"], margin_m: float) -> Int[np.ndarray, "2 3"]:
        """First cell, and the cell beyond the last, of a block that holds cells and a margin."""
        n = math.ceil(margin_m / self.cfg.resolution_m)
        return self._within(np.array([cells.min(axis=0) - n, cells.max(axis=0) + 1 + n]))

    def _at(self, cells: np.ndarray, points_enu_m: Float[np.ndarray, "k 3"]) -> np.ndarray:
        """Values of the cells that hold the points; 0 or False outside the map."""
        at = self.cells(points_enu_m)
        is_inside = np.all((at >= 0) & (at < cells.shape), axis=1)
        return is_inside * cells[tuple(np.where(is_inside[:, None], at, 0).T)]

    def _as_field(self, distance_m: np.ndarray, first: np.ndarray) -> DistanceField:
        x, y, z = self.centres(first).tolist()
        return DistanceField(
            origin_enu_m=(x, y, z), resolution_m=self.cfg.resolution_m, distance_m=distance_m
        )

    def _away_from(self, point_enu_m: Vector3, block: np.ndarray) -> tuple[np.ndarray, ...]:
        """Coordinates of the cell centres of a block from a point, each along its own axis."""
        axes = [
            self.corner_enu_m[n] + (np.arange(*block[:, n]) + 0.5) * self.cfg.resolution_m
            for n in range(3)
        ]
        return np.meshgrid(*map(np.subtract, axes, point_enu_m), indexing="ij", sparse=True)

    def _within(self, block: np.ndarray) -> np.ndarray:
        return np.clip(block, 0, self.evidence.shape)

    def _change(self, block: np.ndarray) -> None:
        np.minimum(self._changed[0], block[0], out=self._changed[0])
        np.maximum(self._changed[1], block[1], out=self._changed[1])
        self._obstacles = None

    def _need(self, needed_m: float) -> None:
        """Compute the route anew if another room is needed than before."""
        if needed_m != self._needed_m:
            self._needed_m = needed_m
            needed = _single(needed_m)
            renew_routes(self._gauge, needed, self._comfortable_m, self._distances)

    @property
    def _comfortable_m(self) -> float:
        """Distance that a route is given in cells without seen room."""
        return self.cfg.cap_m - UNSEEN_LACK * (self.cfg.cap_m - self._needed_m)

    def _refresh(self) -> None:
        """Compute the distances anew about cells that are free or occupied now and were not."""
        low, high = self._changed
        if np.any(low >= high):
            return
        self._changed = np.array([self.evidence.shape, np.zeros(3, dtype=np.int64)])
        states, gauge = self._states, self._gauge
        if note_changes(self.evidence, low, high, states, gauge.reach):
            needed = _single(self._needed_m)
            renew(states, gauge, needed, self._comfortable_m, self._distances)


def _single(number: float) -> float:
    """A number in single precision, with which distances in single precision are compared."""
    return float(np.float32(number))
