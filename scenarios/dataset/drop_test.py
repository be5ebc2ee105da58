"""Drop test: a vehicle without power must come to rest on the landing areas of a dataset.

Landing areas are derived from geometry, and `validate` checks them by geometry. This test checks
them by physics. An Iris with its rotors off falls from 0.3 m above an area's centroid, turned by a
random yaw. At rest it must stand over the area's polygon, at its height, and tilted by no more than
the area's slope and two degrees.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Generic

import numpy as np

from aeroscene.corpus.dataset import DatasetError
from aeroscene.corpus.summary import Entry, SceneSet
from aeroscene.processes import run_all
from aeroscene.scene import InteractionArea

if TYPE_CHECKING:
    from scenarios.dataset.falling_vehicle import Fall

VEHICLE = "iris"
TILT_MARGIN_RAD = math.radians(2.0)
HEIGHT_TOLERANCE_M = 0.05
"""Tolerance of the soles' height above the area's plane, since legs give and surfaces are not quite
flat."""
LEAST_SHARE = 0.99
"""Share of the drops that must come to rest on their areas."""


@dataclass(frozen=True, slots=True)
class Drop:
    """Judged result of one fall on one area."""

    scene_id: str
    area_id: int
    drone_class: str
    faults: tuple[str, ...]
    """Faults of the final position, in words; empty if there are none."""

    def to_plain(self) -> dict[str, Any]:
        """Return the drop as plain data.

        Keys are scene, area, drone_class and faults, the latter in words.
        """
        return {
            "scene": self.scene_id,
            "area": self.area_id,
            "drone_class": self.drone_class,
            "faults": list(self.faults),
        }


@dataclass(frozen=True, kw_only=True, slots=True)
class DropReport:
    """Results of all drops."""

    drops: tuple[Drop, ...]

    @property
    def failed(self) -> tuple[Drop, ...]:
        """Drops that did not come to rest on their areas."""
        return tuple(drop for drop in self.drops if drop.faults)

    @property
    def share(self) -> float:
        """Share of the drops that came to rest on their areas; 1 without drops."""
        return 1.0 - len(self.failed) / max(len(self.drops), 1)

    def to_plain(self) -> dict[str, Any]:
        """Return the report as plain data, with the failed drops in full."""
        return {
            "count": len(self.drops),
            "share": self.share,
            "target": LEAST_SHARE,
            "failed": [drop.to_plain() for drop in self.failed],
        }


@dataclass(frozen=True, slots=True)
class _Task(Generic[Entry]):
    """Drops in one scene."""

    entry: Entry
    drops: tuple[tuple[int, float], ...]
    """Index of the landing area and yaw in rad of each drop."""


def drop_all(
    dataset: SceneSet[Entry], count: int, seed: int, jobs: int, on_drops: Callable[[int], None]
) -> DropReport:
    """Drop a vehicle on landing areas of all scenes, with equal probability for each area.

    Args:
        dataset: Scenes to test.
        count: Number of drops; fewer if there are fewer areas.
        seed: Seed of the areas and yaws.
        jobs: Number of processes.
        on_drops: Called after each scene with its number of drops.

    Raises:
        SceneError: If a scene cannot be read, or the vehicle cannot stand at its start.
    """
    drops: list[Drop] = []
    tasks = _draw(dataset.entries, count, np.random.default_rng(seed))
    with closing(run_all(partial(_drop_in_scene, dataset.select(())), tasks, jobs)) as results:
        for made in results:
            drops += made
            on_drops(len(made))
    return DropReport(drops=tuple(drops))


def _draw(entries: Sequence[Entry], count: int, rng: np.random.Generator) -> list[_Task[Entry]]:
    ends = np.cumsum([0, *(entry.n_landing for entry in entries)])
    total = int(ends[-1])
    # Areas are numbered through all scenes. Sorted, so that each scene is compiled only once.
    chosen = np.sort(rng.choice(total, min(count, total), replace=False))
    yaws_rad = rng.uniform(-math.pi, math.pi, len(chosen))
    drawn: dict[int, list[tuple[int, float]]] = defaultdict(list)
    for number, yaw_rad in zip(chosen.tolist(), yaws_rad.tolist(), strict=True):
        scene = int(np.searchsorted(ends, number, side="right")) - 1
        drawn[scene].append((number - int(ends[scene]), yaw_rad))
    return [_Task(entries[scene], tuple(drops)) for scene, drops in drawn.items()]


def _drop_in_scene(reader: SceneSet[Entry], task: _Task[Entry]) -> list[Drop]:
    # Import MuJoCo only in processes that drop.
    from flightsim.vehicles.catalogue import airframe_by_name
    from flightsim.world import WorldError
    from scenarios.dataset.falling_vehicle import FallingVehicle

    scene = reader.read(task.entry)
    try:
        vehicle = FallingVehicle(scene, airframe_by_name(VEHICLE))
    except WorldError as error:
        raise DatasetError(f"scene {scene.scene_id!r}: {error}") from None
    drops = []
    for number, yaw_rad in task.drops:
        area = scene.landing_areas[number]
        faults = tuple(_faults(vehicle.fall(area, yaw_rad), area))
        drops.append(Drop(scene.scene_id, area.id, area.drone_class, faults))
    return drops


def _faults(fall: Fall, area: InteractionArea) -> list[str]:
    faults = []
    # Conditions are negated as a whole, so that NaN counts as a fault.
    if not fall.rested:
        faults.append("does not come to rest")
    if not fall.inside_m >= 0:
        faults.append(f"rests {-fall.inside_m:.2f} m outside the area")
    if not abs(fall.height_m) <= HEIGHT_TOLERANCE_M:
        faults.append(f"rests {fall.height_m:+.2f} m from the area's plane")
    if not fall.tilt_rad <= area.slope_rad + TILT_MARGIN_RAD:
        tilt_deg, slope_deg = math.degrees(fall.tilt_rad), math.degrees(area.slope_rad)
        faults.append(f"tilts {tilt_deg:.1f} degrees on a slope of {slope_deg:.1f}")
    return faults
