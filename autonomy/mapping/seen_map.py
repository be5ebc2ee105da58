"""Map of a place not known before: cells seen free, seen occupied, or unknown.

A depth image tells where space is free as well as where something is. The map keeps both, because
plans are proved against everything that was not seen free: unknown space is an obstacle. So a plan
that is certified today stays safe whatever the next image shows, unless something moves.

Everything else follows from the evidence of the cells. Distance fields are brought up to date when
somebody asks, about the cells that have changed since (`renewal`). Few positions are measured from
the cells around them instead (`distances`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from autonomy.mapping.cell_states import clear_ball, note_changes, unseen_states
from autonomy.mapping.distances import boxes_about, distance_to_cells, slices
from autonomy.mapping.rays import (
    FREE_AT,
    HIT,
    MOST_FREE,
    MOST_OCCUPIED,
    OCCUPIED_AT,
    frame_for,
    integrate,
    weigh,
)
from autonomy.mapping.renewal import gauge_for, renew, renew_routes, route_of_block, unseen
from autonomy.mapping.seen_map_cfg import SeenMapCfg
from autonomy.pages import untouched_zeros
from autonomy.perception.depth_image import DepthImage
from autonomy.planning.field import DistanceField
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.openings import Opening
from autonomy.planning.search import SeenRoom
from autonomy.types import Vector3

UNSEEN_LACK = 0.25
"""Lack of comfort of unseen cells in a search, as a share of comfortable less needed distance: it
makes a path through unseen space a quarter longer than one of the same length in the open."""
_SURFACE_M = 0.05
"""Height below a surface or a sole within which a cell's middle still counts as above it."""
_SEEN_REACH_CELLS = 5
"""Number of cells up to which `distance_to_seen_m` looks."""


class SeenMap:
    """Map of the cells of a flight volume that grows with depth images.

    Attributes:
        evidence: Evidence of each cell, int8 (nx, ny, nz): free up to `FREE_AT`, occupied from
            `OCCUPIED_AT` on, else unknown.
        is_wide: True if the volume is so large that a search takes a part of it at a time.
        n_looks: Number of images so far of the camera that looks ahead.
        is_given: False, because the map grows with each image.
        eye_enu_m: Camera position of the last image; the start before the first one.
    """

    is_given = False

    def __init__(
        self, low_enu_m: Vector3, high_enu_m: Vector3, cfg: SeenMapCfg | None = None
    ) -> None:
        """Create an empty map of a flight volume, cut to a whole number of cells.

        Memory is taken for what is seen, not for the volume.

        Args:
            low_enu_m: Lower corner.
            high_enu_m: Upper corner.
            cfg: Settings; None for the usual ones.
        """
        self.cfg = SeenMapCfg() if cfg is None else cfg
        self.corner_enu_m = np.array(low_enu_m, dtype=float)
        size = (np.array(high_enu_m) - self.corner_enu_m) / self.cfg.resolution_m
        # A whole number of cells must not lose one to rounding.
        shape = np.maximum(np.floor(size + 1e-6), 1).astype(np.int64)
        self.evidence = untouched_zeros(tuple(shape.tolist()), np.int8)
        self.is_wide = self.evidence.size > self.cfg.most_whole_cells
        self.n_looks = 0
        x, y, z = ((np.array(low_enu_m) + high_enu_m) / 2).tolist()
        self.eye_enu_m: Vector3 = (x, y, z)
        # True for cells that were seen free and have not surely been occupied since.
        self._was_free = untouched_zeros(self.evidence.shape, np.bool_)
        self._gauge = gauge_for(self.evidence.shape, self.cfg.resolution_m, self.cfg.cap_m)
        has_route = not self.is_wide
        self._distances = unseen(self.evidence.shape, self._gauge, has_route=has_route)
        # States for which these distances hold, but for blocks of cells that it lists as stale.
        self._states = unseen_states(self.evidence.shape, self._gauge.reach)
        self._needed_m = 0.0
        # First cell, and the cell beyond the last, whose evidence may have changed since then.
        # The block is empty while its first cell is beyond its last one, as here.
        self._changed = np.array([shape, np.zeros(3, dtype=np.int64)])
        self._obstacles: Obstacles | None = None

    def observe(self, image: DepthImage, *, is_ahead: bool = True) -> None:
        """Update the map with a depth image.

        Args:
            image: Image, posed in the map.
            is_ahead: True for the camera that looks ahead, whose images are counted as looks.
        """
        cfg = self.cfg
        self.n_looks += is_ahead
        frame = frame_for(image, self.corner_enu_m, cfg.resolution_m, cfg.max_range_m)
        integrate(frame, image.pixels, cfg.max_range_m, image.inverse_depth_sigma_pm)
        weigh(frame, self.evidence, self._was_free)
        # Distances are left as they are until somebody asks: most images are followed by others.
        self.eye_enu_m = image.position_enu_m
        self._change(self._within(np.array([frame.first, frame.first + frame.marks.shape])))

    def assume_free_column(
        self, foot_enu_m: Vector3, *, radius_m: float = 1.1, height_m: float = 3.4
    ) -> None:
        """Assume that the air above the start is free, until it is seen otherwise.

        No camera sees that air before the vehicle is in it. The column is higher than the vehicle
        rises before it looks around.

        Args:
            foot_enu_m: Point of the surface that the vehicle stands on.
            radius_m: Radius of the column.
            height_m: Height of the column.
        """
        reach = (radius_m, radius_m, height_m)
        low = self.cells(np.array(foot_enu_m) - (radius_m, radius_m, 0.0))
        high = self.cells(np.array(foot_enu_m) + reach) + 1
        block = self._within(np.array([low, high]))
        x, y, z = self._away_from(foot_enu_m, block)
        # A cell whose middle the surface just reaches stands for the air above it.
        is_assumed = (np.hypot(x, y) <= radius_m) & (z >= -_SURFACE_M) & (z <= height_m)
        part = self.evidence[slices(block)]
        # As sure as can be, so that one image that errs does not close the air above the start.
        part[is_assumed & (part < OCCUPIED_AT)] = MOST_FREE
        self.eye_enu_m = foot_enu_m
        self._change(block)

    def be_at(self, position_enu_m: Vector3, radius_m: float, sole_m: float) -> None:
        """Take the air that a vehicle fills for free, except cells that several images hit.

        A camera that looks ahead does not see the air around the vehicle again, so that noise
        marked there would stay for ever.

        Args:
            position_enu_m: Position of the vehicle's origin.
            radius_m: Radius of the sphere of air.
            sole_m: Height of the origin over the soles; nothing below them changes.
        """
        at, step_m = np.array(position_enu_m), self.cfg.resolution_m
        block = self._within(np.array([self.cells(at - radius_m), self.cells(at + radius_m) + 1]))
        centre = (at - self.corner_enu_m) / step_m
        least_height = -(sole_m + _SURFACE_M) / step_m
        if clear_ball(self.evidence, block[0], block[1], centre, radius_m / step_m, least_height):
            self._change(block)

    def give_up(self, cells: Int[np.ndarray, "n 3"]) -> None:
        """Assume that cells that could not be seen are occupied, until they are seen.

        Args:
            cells: Indices of the cells; none outside the map.
        """
        # Just occupied, so that a single pass takes it back.
        self.evidence[tuple(cells.T)] = OCCUPIED_AT
        self._change(np.array([cells.min(axis=0), cells.max(axis=0) + 1]))

    def cells(self, points_enu_m: Float[np.ndarray, "*b 3"]) -> Int[np.ndarray, "*b 3"]:
        """Return the indices of the cells that hold points, which may lie outside the map."""
        offset = (np.asarray(points_enu_m) - self.corner_enu_m) / self.cfg.resolution_m
        return np.floor(offset).astype(np.int64)

    def centres(self, cells: Int[np.ndarray, "*b 3"]) -> Float[np.ndarray, "*b 3"]:
        """Return the centres of cells, ENU, m."""
        return self.corner_enu_m + (np.asarray(cells) + 0.5) * self.cfg.resolution_m

    def distance_to_seen_m(
        self, points_enu_m: Float[np.ndarray, "k 3"], at_least: int = HIT
    ) -> Float[np.ndarray, " k"]:
        """Return the distance to the nearest cell with enough evidence of a hit, up to five cells.

        Args:
            points_enu_m: Positions.
            at_least: Evidence from which on a cell counts; by default that of one hit.
        """
        return self._distance_m(points_enu_m, at_least, _SEEN_REACH_CELLS, is_walled=False)

    def static_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the distance to the nearest cell that several images hit, up to five cells.

        A mover leaves a cell before several images have hit it. The distance is 0 where nothing was
        ever free, so that a surface that comes into view is not taken for a mover.
        """
        distance_m = np.zeros(len(points_enu_m))
        was_free = np.flatnonzero(self._at(self._was_free, points_enu_m))
        distance_m[was_free] = self.distance_to_seen_m(points_enu_m[was_free], MOST_OCCUPIED)
        return distance_m

    def rough_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the distance from the middles of the points' cells to all that was not seen free.

        It comes from the distance field, which suits thousands of points. It is 0 outside the map.
        """
        return self._at(self.field.distance_m, points_enu_m)

    def distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Return the distance to everything that was not seen free, up to the cap; 0 within it.

        It comes from the cells around each point, which suits up to a few hundred points: the
        distance field would first have to be brought up to date.
        """
        # Everything outside the map counts as not seen.
        reach = round(self.cfg.cap_m / self.cfg.resolution_m)
        return self._distance_m(points_enu_m, FREE_AT + 1, reach, is_walled=True)

    def find_openings(self) -> Sequence[Opening]:
        """Return no passages: a growing map does not look for them."""
        return ()

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Return True: unseen cells may be free, and only a search finds out otherwise."""
        del point_enu_m
        return True

    @property
    def field(self) -> DistanceField:
        """Distance field of the whole map to everything that was not seen free, up to date."""
        self._refresh()
        return self._as_field(self._distances.to_not_free, np.zeros(3, dtype=np.int64))

    @property
    def obstacles(self) -> Obstacles:
        """Boxes over everything that was not seen free near the camera, and over all else.

        They reach `nearby_m` from the last camera position, and are kept until the map changes.
        """
        if self._obstacles is None:
            at, reach = np.array(self.eye_enu_m), self.cfg.nearby_m
            block = self._within(np.array([self.cells(at - reach), self.cells(at + reach) + 1]))
            self._obstacles = self.obstacles_in(block)
        return self._obstacles

    def obstacles_in(self, block: Int[np.ndarray, "2 3"]) -> Obstacles:
        """Return boxes over everything in a block that was not seen free, and over all outside it.

        Args:
            block: First cell, and the cell beyond the last.
        """
        is_free = np.ascontiguousarray(self.evidence[slices(block)] <= FREE_AT)
        corner = self.corner_enu_m + block[0] * self.cfg.resolution_m
        return boxes_about(is_free, corner, self.cfg.resolution_m)

    def field_in(self, block: Int[np.ndarray, "2 3"]) -> DistanceField:
        """Return the distance field of a block of cells, to everything that was not seen free."""
        self._refresh()
        part = np.ascontiguousarray(self._distances.to_not_free[slices(block)])
        return self._as_field(part, block[0])

    def search_block(self, cell: Int[np.ndarray, " 3"]) -> Int[np.ndarray, "2 3"]:
        """Return the first cell, and the cell beyond the last, of the block of a search.

        This is the whole map unless it is wide. A search of a wide one would take gigabytes and
        minutes, while one plan flies no farther than the camera sees.

        Args:
            cell: Cell from which the search begins.
        """
        if not self.is_wide:
            return np.array([np.zeros(3, dtype=np.int64), self.evidence.shape])
        return self.block_about(cell[None], self.cfg.search_m)

    def route_in(self, block: Int[np.ndarray, "2 3"], needed_m: float) -> DistanceField:
        """Return distances for a search of a `search_block` that also passes unseen cells.

        They are distances to cells that were seen occupied. If a cell has `needed_m` to those, but
        not as much that was seen free, its distance is less than comfortable. This is the price of
        unseen space.
        """
        self._refresh()
        self._need(needed_m)
        if not self.is_wide:
            return self._as_field(self._distances.route, block[0])
        i, j, k = block.T.tolist()
        ends = ((i[0], j[0], k[0]), (i[1], j[1], k[1]))
        numbers = (_single(needed_m), self._comfortable_m)
        return self._as_field(
            route_of_block(self._gauge, *numbers, self._distances, *ends), block[0]
        )

    def seen_room(self, block: Int[np.ndarray, "2 3"], needed_m: float) -> SeenRoom:
        """Return the cells of a `search_block` with as much room that was seen free.

        Args:
            block: The block, as `search_block` returns it.
            needed_m: Room that the vehicle needs.
        """
        self._refresh()
        self._need(needed_m)
        room_m, needed = self._distances.to_not_free, _single(needed_m)
        if self.is_wide:
            room_m = np.ascontiguousarray(room_m[slices(block)])
            layers = np.flatnonzero((room_m >= needed).any(axis=(0, 1)))
        else:
            layers = np.flatnonzero(self._distances.n_roomy)
        return SeenRoom(room_m, needed, int(layers[-1]) if len(layers) else -1)

    def block_about(self, cells: Int[np.ndarray, "n 3"], margin_m: float) -> Int[np.ndarray, "2 3"]:
        """Return the first cell, and the cell beyond the last, of a block with cells and a margin.

        The block is cut at the border of the map.
        """
        n = math.ceil(margin_m / self.cfg.resolution_m)
        return self._within(np.array([cells.min(axis=0) - n, cells.max(axis=0) + 1 + n]))

    def _at(self, cells: np.ndarray, points_enu_m: Float[np.ndarray, "k 3"]) -> np.ndarray:
        """Return the values of the cells that hold the points; 0 or False outside the map."""
        at = self.cells(points_enu_m)
        # Points outside look up cell (0, 0, 0), because no index may be out of range.
        is_inside = np.all((at >= 0) & (at < cells.shape), axis=1)
        return is_inside * cells[tuple(np.where(is_inside[:, None], at, 0).T)]

    def _distance_m(
        self, points_enu_m: np.ndarray, at_least: int, reach: int, *, is_walled: bool
    ) -> Float[np.ndarray, " k"]:
        points = np.ascontiguousarray(points_enu_m, dtype=float)
        where = (self.corner_enu_m, self.cfg.resolution_m)
        return distance_to_cells(points, self.evidence, at_least, *where, reach, is_walled)

    def _as_field(self, distance_m: np.ndarray, first: np.ndarray) -> DistanceField:
        x, y, z = self.centres(first).tolist()
        return DistanceField(
            origin_enu_m=(x, y, z), resolution_m=self.cfg.resolution_m, distance_m=distance_m
        )

    def _away_from(self, point_enu_m: Vector3, block: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the coordinates of a block's cell centres from a point, along each axis alone."""
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
        """Compute the route anew if the vehicle needs another room than before."""
        if needed_m != self._needed_m:
            self._needed_m = needed_m
            if not self.is_wide:
                needed = _single(needed_m)
                renew_routes(self._gauge, needed, self._comfortable_m, self._distances)

    @property
    def _comfortable_m(self) -> float:
        """Distance of the route in cells without seen room, m."""
        return self.cfg.cap_m - UNSEEN_LACK * (self.cfg.cap_m - self._needed_m)

    def _refresh(self) -> None:
        """Bring the distances up to date about the cells whose state has changed.

        Every property that reads distances calls it first.
        """
        low, high = self._changed
        if np.any(low >= high):
            return
        self._changed = np.array([self.evidence.shape, np.zeros(3, dtype=np.int64)])
        # Most images confirm what is known: then no state changes, and no distance does.
        states, gauge = self._states, self._gauge
        if note_changes(self.evidence, low, high, states, gauge.reach):
            needed = _single(self._needed_m)
            renew(states, gauge, needed, self._comfortable_m, self._distances)


def _single(number: float) -> float:
    """Round a number to single precision, so that an equal distance in it is not less."""
    return float(np.float32(number))
