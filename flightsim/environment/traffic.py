"""Traffic of a scene: number and random paths of its movers, in free space and never crossing.

People keep to pavements, squares, lawns and the floors of rooms, cars to roads and car parks,
drones to one height each. Without room there, people and cars use any free ground. Every mover has
its own stretch, so none ever meets another, and all keep away from where vehicles start. Paths
are fixed beforehand, so that a mover's place depends on time alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from math import ceil

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import Scene
from aeroscene.scene.catalogue import PARKING, ROADS, WATER
from aeroscene.solids.shapes import Primitive
from autonomy.types import Vector3
from flightsim.draws import seed_sequence
from flightsim.environment.floor import CELL_M, CLEARANCE_CAP_M, Columns, Floor
from flightsim.environment.movers import MAX_MOVERS, MOVER_KINDS, MoverName, MovingObstacle
from flightsim.environment.paths import smooth_path
from flightsim.environment.routes import distance_to_points, find_route, pull_straight

SurfaceHeight = Callable[[Float[np.ndarray, "n 3"]], Float[np.ndarray, " n"]]

_ATTEMPTS = 40
_START_KEPT_FREE_M = 3.0  # movers keep away from the starts of vehicles
_BETWEEN_MOVERS_M = 0.4
_SEEN_HEIGHT_M = 9.0
_GROUND_CLEARANCE_M = 0.02
"""Height by which movers hover, so that the ray that finds the surface below clears them."""
# Half a cell's diagonal and a bit, so that a column's centre stands for all of it.
_SIDE_MARGIN_M = 0.2
_ROUTE_M: dict[MoverName, tuple[float, float]] = {
    "person": (4.0, 30.0),
    "car": (6.0, 45.0),
    "drone": (8.0, 40.0),
}
_WISHED_TIMES = 3.0
"""Ratio of the desired to the least length of a route; long routes are tried first."""
_ACROSS = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Lateral positions of the surface samples, in half widths from the centre."""
_LEAST_TURN_RADIUS_M = 4.0
# Heights between which drones fly, below the ceiling of a room indoors.
_FLYING_M = {"indoor": (1.2, 1.9), "outdoor": (3.0, 7.0), "mixed": (3.0, 7.0)}


class TrafficError(ValueError):
    """A scene has no room for the traffic, or the traffic is invalid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TrafficCfg:
    """Number of movers of each kind, and their seed."""

    people: int = 0
    cars: int = 0
    drones: int = 0
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse invalid numbers.

        Raises:
            TrafficError: Naming the fault and the valid values.
        """
        for name, count in self.counts.items():
            if not 0 <= count <= MAX_MOVERS:
                raise TrafficError(f"traffic {name}={count}: 0 to {MAX_MOVERS} are valid")
        if sum(self.counts.values()) > MAX_MOVERS:
            raise TrafficError(
                f"traffic {sum(self.counts.values())} movers: {MAX_MOVERS} in all are valid"
            )

    @property
    def counts(self) -> dict[str, int]:
        """Number of movers by the plural of their kind."""
        return {"people": self.people, "cars": self.cars, "drones": self.drones}

    @property
    def has_any(self) -> bool:
        """True if there are any movers."""
        return any(self.counts.values())

    @classmethod
    def parse(cls, text: str, seed: int) -> TrafficCfg:
        """Read "people=3,cars=2,drones=1", any of them left out, or "none".

        Args:
            text: The text.
            seed: Seed of the paths.

        Raises:
            TrafficError: Naming the fault and the valid values.
        """
        counts: dict[str, int] = {}
        names = [field.name for field in fields(cls) if field.name != "seed"]
        for item in () if text == "none" else text.split(","):
            name, _, number = item.strip().partition("=")
            if name not in names or name in counts or not number.isdecimal():
                raise TrafficError(
                    f"traffic {text!r}: {item!r} is not valid; valid: none, or some of "
                    + ",".join(f"{name}=N" for name in names)
                )
            counts[name] = int(number)
        return cls(**counts, seed=seed)


def plan_traffic(
    cfg: TrafficCfg,
    scene: Scene,
    solids: Sequence[Primitive],
    surface_height: SurfaceHeight,
    starts_enu_m: Sequence[Vector3] = (),
) -> tuple[MovingObstacle, ...]:
    """Return paths for the movers of a scene.

    Args:
        cfg: Number of movers of each kind.
        scene: Scene to move in.
        solids: All static solids of the scene.
        surface_height: Exact height of the first surface below points, (n, 3) to (n,).
        starts_enu_m: Starting positions of vehicles; none for the scene's start alone.

    Raises:
        TrafficError: If there is no room for one of them.
    """
    counts: dict[MoverName, int] = {"person": cfg.people, "car": cfg.cars, "drone": cfg.drones}
    kinds: list[MoverName] = [kind for kind, count in counts.items() for _ in range(count)]
    if not kinds:
        return ()
    streets = _Streets(scene, solids, surface_height, starts_enu_m or [scene.start_position_enu_m])
    # Each mover draws from a stream of its own, by its number.
    return tuple(
        streets.place(
            kind, np.random.default_rng(seed_sequence(cfg.seed, scene.scene_id, "traffic", number))
        )
        for number, kind in enumerate(kinds)
    )


class _Streets:
    """Room for movers, and the part already taken."""

    def __init__(
        self,
        scene: Scene,
        solids: Sequence[Primitive],
        surface_height: SurfaceHeight,
        starts_enu_m: Sequence[Vector3],
    ) -> None:
        self._scene = scene
        self._surface_height = surface_height
        self._columns = Columns.from_scene(scene, solids, _SEEN_HEIGHT_M)
        self._from_starts_m = distance_to_points(self._columns, np.array(starts_enu_m)[:, :2])
        self._taken: dict[bool, list[tuple[np.ndarray, float]]] = {True: [], False: []}
        """Distances of the columns from each path, and the half width of its mover. True holds
        movers that fly, false the others: the two never share a height."""
        # All people are of one height and have one zone, and so have all cars.
        self._floors: dict[float, Floor] = {}
        self._zones: dict[tuple[MoverName, bool], Bool[np.ndarray, "nx ny"]] = {}

    def place(self, kind: MoverName, generator: np.random.Generator) -> MovingObstacle:
        """Place a mover on a path that no other crosses.

        Args:
            kind: Kind of mover, such as person.
            generator: Random numbers for its speed and its path.

        Raises:
            TrafficError: If no such path is found.
        """
        low, high = MOVER_KINDS[kind].speed_mps
        speed_mps, phase = float(generator.uniform(low, high)), float(generator.uniform())
        for is_choosy in (True, False):
            path = self._find(kind, generator, is_choosy=is_choosy)
            if path is not None:
                away_m = distance_to_points(self._columns, path[:, :2])
                self._taken[kind == "drone"].append((away_m, half_width_m(kind)))
                points = tuple((x, y, z) for x, y, z in path.tolist())
                return MovingObstacle(
                    kind=kind, path_enu_m=points, speed_mps=speed_mps, phase=phase
                )
        n_placed = len(self._taken[kind == "drone"])
        raise TrafficError(
            f"traffic: scene {self._scene.scene_id!r} ({self._scene.domain}) has no room for one "
            f"more {kind} after {n_placed} that share its space; valid: fewer, or another scene"
        )

    def _find(
        self, kind: MoverName, generator: np.random.Generator, *, is_choosy: bool
    ) -> Float[np.ndarray, "n 3"] | None:
        """Return a path in the kind's zone or, if not choosy, anywhere; long ones come first."""
        floor = self._floor(kind, generator)
        free = self._free(kind, floor, is_choosy=is_choosy)
        for attempt in range(_ATTEMPTS):
            least_m, most_m = _ROUTE_M[kind]
            if attempt < _ATTEMPTS // 2:
                least_m *= _WISHED_TIMES
            path = self._path(kind, floor, free, (least_m, most_m), generator)
            if path is not None:
                return path
        return None

    def _path(
        self,
        kind: MoverName,
        floor: Floor,
        free: Bool[np.ndarray, "nx ny"],
        length_m: tuple[float, float],
        generator: np.random.Generator,
    ) -> Float[np.ndarray, "n 3"] | None:
        """Return a random path, or None if the draw is unusable."""
        route = find_route(floor, free, length_m, generator)
        if route is None:
            return None
        path = self._lifted(kind, pull_straight(route, floor, free), floor)
        return path if path is not None and _has_room(kind, path, floor, free) else None

    def _floor(self, kind: MoverName, generator: np.random.Generator) -> Floor:
        height_m = MOVER_KINDS[kind].size_m[2]
        if kind != "drone":
            if height_m not in self._floors:
                self._floors[height_m] = self._columns.floor(height_m)
            return self._floors[height_m]
        low, high = _FLYING_M[self._scene.domain]
        above_m = float(generator.uniform(low, high))
        return self._columns.layer(self._scene.extent_min_enu_m[2] + above_m, height_m)

    def _free(self, kind: MoverName, floor: Floor, *, is_choosy: bool) -> Bool[np.ndarray, "nx ny"]:
        half_m = half_width_m(kind)
        free = floor.clearance_m >= half_m + _SIDE_MARGIN_M
        if kind != "drone":
            if (kind, is_choosy) not in self._zones:
                self._zones[kind, is_choosy] = self._zone(kind, is_choosy=is_choosy)
            free &= self._zones[kind, is_choosy]
        free &= self._from_starts_m > _START_KEPT_FREE_M + half_m
        for away_m, other_half_m in self._taken[kind == "drone"]:
            free &= away_m > half_m + other_half_m + _BETWEEN_MOVERS_M
        return free

    def _zone(self, kind: MoverName, *, is_choosy: bool) -> Bool[np.ndarray, "nx ny"]:
        """Zone of a kind: its usual ground or, if not choosy, all but water."""
        objects = self._scene.objects
        waters = self._columns.covered_by([o for o in objects if o.category in WATER])
        if not is_choosy:
            return ~waters & (kind != "car" or self._scene.domain != "indoor")
        roads = self._columns.covered_by([o for o in objects if o.category in ROADS | PARKING])
        return roads if kind == "car" else ~roads & ~waters

    def _lifted(
        self, kind: MoverName, route: Float[np.ndarray, "n 2"], floor: Floor
    ) -> Float[np.ndarray, "n 3"] | None:
        """Lift a route to the surface below it; None if that differs from the cells' height."""
        if kind == "drone":
            return np.column_stack([route, floor.level_m[floor.cells(route)]])
        # The mover's length on both sides, and one sample more for rounding.
        reach = ceil(MOVER_KINDS[kind].size_m[0] / 2 / CELL_M) + 1
        tread = _prolonged(route, reach)
        level_m = floor.level_m[floor.cells(tread)]
        ahead = np.gradient(tread, axis=0)
        left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
        left *= half_width_m(kind) / np.linalg.norm(left, axis=1, keepdims=True)
        above = [np.column_stack([tread + side * left, level_m + CELL_M]) for side in _ACROSS]
        surface_m = np.max([self._surface_height(points) for points in above], axis=0)
        if not np.all(np.abs(surface_m - level_m) <= 2 * CELL_M):
            return None
        # Use the highest surface underneath: a kerb lifts the mover, a step is a short ramp.
        windows = np.lib.stride_tricks.sliding_window_view(surface_m, 2 * reach + 1)
        return np.column_stack([route, windows.max(axis=1) + _GROUND_CLEARANCE_M])


def _prolonged(route: Float[np.ndarray, "n 2"], n: int) -> Float[np.ndarray, "m 2"]:
    """Return the route with n more points straight on at either end."""
    steps = np.arange(1, n + 1)[:, None]
    before = route[0] + steps[::-1] * (route[0] - route[1])
    return np.vstack([before, route, route[-1] + steps * (route[-1] - route[-2])])


def half_width_m(kind: MoverName) -> float:
    """Return half of a mover's width, or the radius that it sweeps if it turns on the spot, m."""
    x, y, _ = MOVER_KINDS[kind].size_m
    return y / 2 if kind == "car" else math.hypot(x, y) / 2


def _has_room(
    kind: MoverName, path: Float[np.ndarray, "n 3"], floor: Floor, free: np.ndarray
) -> bool:
    """Return true if the rounded path, and a long mover's ends on it, stay clear."""
    # Rounding cuts corners, so the polyline's own room says nothing.
    spline = smooth_path([(x, y, z) for x, y, z in path.tolist()], is_loop=False)
    if spline.length_m < _ROUTE_M[kind][0] / 2:
        return False
    points = spline.sample(np.arange(0.0, spline.length_m, CELL_M / 2))
    if not np.all(free[floor.cells(points)]):
        return False
    if kind != "car":
        return True
    ahead = np.diff(points[:, :2], axis=0)
    headings = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    # Number of samples in a metre of path.
    window = round(1.0 / (CELL_M / 2))
    if np.any(np.abs(headings[window:] - headings[:-window]) > 1.0 / _LEAST_TURN_RADIUS_M):
        return False
    directions = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    least_m = min(half_width_m(kind) + _SIDE_MARGIN_M / 2, CLEARANCE_CAP_M)
    for reach_m in np.linspace(-0.5, 0.5, 9) * MOVER_KINDS[kind].size_m[0]:
        shifted = points[:-1, :2] + reach_m * directions
        # The ends, beyond 40% of the length, need only a free column.
        inside_m = least_m if abs(reach_m) < 0.4 * MOVER_KINDS[kind].size_m[0] else 0.0
        if np.any(floor.clearance_m[floor.cells(shifted)] <= inside_m):
            return False
    return True
