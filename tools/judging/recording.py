"""A recorded flight: the vehicle's motion and shape, the place and the task, from the file alone.

Nothing of the recorder's own classes is used, so that the second judge sees what any reader sees.
Names of entities are those of docs/recording.md, written out here on purpose.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

from judging.solids import Solid, solids_of

_STEP_M = 0.015
"""Distance between two points on the vehicle's hull."""
_VEHICLE, _PLANNED = "/world/vehicle", "/world/trajectory/planned"


class Plan(NamedTuple):
    """A trajectory that the pilot took up, from its start in simulated time."""

    begun_s: float
    duration_s: float
    points_enu_m: np.ndarray
    """Places along it, evenly in time, m x 3."""


@dataclass(eq=False)
class Recording:
    """A flight as recorded; n rows of the vehicle's motion.

    Frames are ENU for places and the vehicle's own, forward, left and up, for its shape.
    """

    time_s: np.ndarray = field(default_factory=lambda: np.empty(0))
    position_enu_m: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    attitude: Rotation = field(default_factory=Rotation.identity)
    rotor_time_s: np.ndarray = field(default_factory=lambda: np.empty(0))
    rotor_speed_radps: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))
    hull_flu_m: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    """Points on the vehicle's surface, or in the middle of its thin parts."""
    hull_radius_m: np.ndarray = field(default_factory=lambda: np.empty(0))
    """Thickness of the vehicle about each point: 0 on a surface."""
    soles_flu_m: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    solids: list[Solid] = field(default_factory=list)
    scene: dict[str, Any] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=dict)
    chosen_enu_m: np.ndarray | None = None
    """Point to touch down on that the pilot chose last; None if it chose none."""
    verdict: dict[str, Any] = field(default_factory=dict)
    plans: list[Plan] = field(default_factory=list)
    """Plans in the order in which they were taken up."""

    @property
    def area(self) -> dict[str, Any]:
        """Area that the flight was to end on, as the scene's file describes it.

        Raises:
            ValueError: If the flight had none.
        """
        for area in self.scene["interaction_areas"]:
            if area["id"] == self.verdict.get("area"):
                return area
        raise ValueError("the flight had no area to end on")


def read_recording(path: Path) -> Recording:
    """Read a recording.

    Args:
        path: File of rerun.

    Raises:
        ValueError: If the file has no flight with a verdict.
    """
    found, hull = Recording(), []
    motion: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    rotors: list[tuple[np.ndarray, np.ndarray]] = []
    for entity, time_s, columns in _entities(path):
        if entity == _VEHICLE and "Transform3D:translation" in columns:
            motion.append((time_s, *_pose(columns)))
        elif entity == "/motors/speed" and "Scalars:scalars" in columns:
            rotors.append((time_s, np.array(columns["Scalars:scalars"], dtype=float)))
        elif entity.startswith("/world/scene/"):
            found.solids += solids_of(entity, _only(columns))
        elif entity.startswith(_VEHICLE):
            hull += _hull_points(_only(columns))
        # Each choice of the pilot replaces the one before; the last one counts.
        elif entity == "/world/landing_map/touchdown" and len(time_s):
            found.chosen_enu_m = np.array(columns["Points3D:positions"][-1][0])
        elif entity == _PLANNED and len(time_s):
            found.plans += _plans(time_s, columns)
        elif entity == "/run/scene":
            found.scene = json.loads(_only(columns)["json"][0])
        elif entity == "/__properties/run":
            found.limits = json.loads(_only(columns)["limits"][0])
        elif entity == "/__properties/verdict":
            found.verdict = json.loads(_only(columns)["figures"][0])
    if not (motion and rotors and found.verdict and found.scene):
        raise ValueError(f"recording {str(path)!r} has no flight with a verdict")
    times_s, positions_m, quats_xyzw = map(np.concatenate, zip(*motion, strict=True))
    found.time_s, found.position_enu_m = times_s, positions_m
    # Chunks of a file come in no order of time.
    found.plans.sort(key=lambda plan: plan.begun_s)
    found.attitude = Rotation.from_quat(quats_xyzw)
    found.rotor_time_s, found.rotor_speed_radps = map(np.concatenate, zip(*rotors, strict=True))
    found.hull_flu_m = np.concatenate([points_m for points_m, _ in hull])
    found.hull_radius_m = np.concatenate([radius_m for _, radius_m in hull])
    deepest_m = found.hull_flu_m[:, 2] - found.hull_radius_m
    # Soles are the lowest points of the hull: within a millimetre, because floats are single.
    found.soles_flu_m = found.hull_flu_m[deepest_m < deepest_m.min() + 1e-3]
    return found


def _entities(path: Path) -> Iterator[tuple[str, np.ndarray, Mapping[str, Any]]]:
    """Pieces of all entities: path, times in s and columns; no times for what never changes."""
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        time_s = np.empty(0)
        if "sim_time" in batch.schema.names:
            # Nanoseconds.
            time_s = batch.column("sim_time").cast("int64").to_numpy() * 1e-9
        yield chunk.entity_path, time_s, batch.to_pydict()


def _only(columns: Mapping[str, Any]) -> dict[str, Any]:
    """The one row of an entity that never changes, without empty components."""
    return {name: rows[0] for name, rows in columns.items() if rows and rows[0] is not None}


def _pose(columns: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    names = ("Transform3D:translation", "Transform3D:quaternion")
    position_m, quat_xyzw = (np.array([row[0] for row in columns[name]]) for name in names)
    return position_m.astype(float), quat_xyzw.astype(float)


def _plans(time_s: np.ndarray, columns: Mapping[str, Any]) -> Iterator[Plan]:
    strips, durations = columns["LineStrips3D:strips"], columns["duration_s"]
    for begun_s, strip, duration in zip(time_s, strips, durations, strict=True):
        # An empty strip takes a plan away.
        if strip:
            yield Plan(float(begun_s), float(duration[0]), np.array(strip[0], dtype=float))


def _hull_points(columns: Mapping[str, Any]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points on the drawn shapes of a vehicle, and its thickness about each."""
    for half_m in columns.get("Boxes3D:half_sizes", []):
        axes = [np.linspace(-h, h, max(2, round(2 * h / _STEP_M))) for h in half_m]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        # Points inside of a box are no nearer to anything than its skin.
        is_skin = np.any(np.isclose(np.abs(grid), half_m), axis=1)
        yield grid[is_skin], np.zeros(int(is_skin.sum()))
    for centre_m, radius_m in _discs(columns):
        # Discs need half as many points: their rims decide, and have points of their own.
        rings_m = np.linspace(0.0, radius_m, max(2, round(radius_m / _STEP_M / 2)))
        angles = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
        ring, angle = np.meshgrid(rings_m, angles, indexing="ij")
        flat = np.column_stack(
            [(ring * np.cos(angle)).ravel(), (ring * np.sin(angle)).ravel(), np.zeros(ring.size)]
        )
        half_m = columns["Cylinders3D:lengths"][0] / 2
        for side in (-half_m, half_m):
            yield flat + centre_m + [0.0, 0.0, side], np.zeros(len(flat))
    radii_m = columns.get("LineStrips3D:radii", [0.0])
    for i, strip in enumerate(columns.get("LineStrips3D:strips", [])):
        start_m, end_m = np.array(strip[0]), np.array(strip[-1])
        # Arms are thin rods, so that points along their axes suffice, with the radius as thickness.
        shares = np.linspace(0.0, 1.0, 2 + round(np.linalg.norm(end_m - start_m) / _STEP_M))
        points_m = start_m + shares[:, None] * (end_m - start_m)
        yield points_m, np.full(len(points_m), radii_m[min(i, len(radii_m) - 1)])


def _discs(columns: Mapping[str, Any]) -> Iterator[tuple[np.ndarray, float]]:
    radii_m = columns.get("Cylinders3D:radii", [])
    for i, centre_m in enumerate(columns.get("Cylinders3D:centers", [])):
        yield np.array(centre_m), radii_m[min(i, len(radii_m) - 1)]
